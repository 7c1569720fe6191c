// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/base/rng.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A direction in two frames, both of length 1.
struct DirectionPair {
  Vec3 in_a = Vec3::Zero();
  Vec3 in_b = Vec3::Zero();
  double tolerance_rad = 0;  ///< by which it may be off where it is true
};

struct TurnByDirections {
  Eigen::Quaterniond R_a_b;
  std::vector<std::size_t> agree;  ///< the pairs that it takes to one another, in order
};

/// The turn from frame b to frame a on which most pairs agree, many of which may be false: two
/// tell one, drawn at random (RANSAC, Fischler and Bolles 1981), and those that agree tell it
/// by least squares (Wahba 1965, Horn 1987). Empty where fewer than `fewest` agree.
std::optional<TurnByDirections> turn_by_directions(const std::vector<DirectionPair>& pairs,
                                                   std::size_t fewest, Rng rng);

}  // namespace panoptes
