// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/base/rng.h"
#include "core/geometry/pose2.h"
#include "sim/world/load.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {

/// Between what stands in an office, at least: a robot of 0.25 m radius drives through with 0.2 m
/// to spare on each side.
inline constexpr double kOfficeAisle_m = 0.9;

/// As many desks as fit into a room of this size, in blocks of desks that stand back to back with
/// aisles around them and room for cupboards along the walls.
int most_desks(const Vec2& size_m);

/// A rectangular room to be furnished, its walls' sides in any order, doors and doorways taken.
struct OfficeRoom {
  Vec2 low = Vec2::Zero();  ///< in scene, between the walls
  Vec2 high = Vec2::Zero();
  std::vector<WallFace> faces;
  std::vector<Rectangle> kept_free;  ///< of the floor, before doorways
  int desks = 0;                     ///< not more than fit
  bool overhangs = false;
  double texture = 1;  ///< as OfficePlan has it
};

/// Adds desks with chairs and what lies on them, furniture along the walls and what hangs above it,
/// windows in one of the longer walls, lamps, floor and ceiling.
void furnish(WorldSettings& into, OfficeRoom room, const Rng& rng);

/// The picture of an office's walls: plain without texture.
const char* office_wall(double texture);

}  // namespace panoptes::sim
