// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/grid2.h"
#include "core/geometry/pose2.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {

/// The free floor of a place while it is being furnished, on a grid of 5 cm. What would cut the
/// place in two for a robot, or leave a pocket that a robot fits into and cannot leave, is refused.
class PassabilityGrid {
 public:
  /// Nothing outside of `low` to `high` is free.
  PassabilityGrid(const Vec2& low, const Vec2& high);

  /// Walls: no questions asked.
  void block(const Rectangle& what);

  /// From now on there is to be a passage of 0.9 m width between all of these places.
  void keep_open(const std::vector<Vec2>& places);

  /// Blocks it, unless the place would come apart; returns whether it did.
  bool block_if_passable(const Rectangle& what);

 private:
  bool is_passable() const;
  std::vector<char> region(double clearance_m) const;
  std::size_t cell_of(const Vec2& p) const;
  void lower_clearance(const Rectangle& what);

  Grid2<float> clearance_m_;  // of the middle of each cell, as far as it matters
  std::vector<Vec2> places_;
};

}  // namespace panoptes::sim
