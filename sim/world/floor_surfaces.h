// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "core/geometry/pose2.h"
#include "sim/world/world.h"

namespace panoptes::sim {

/// Which picture the floor shows where, seen from above: of rugs, paint and lids, which lie on it
/// up to kFloorLayerTop_m, their own. As it is at time 0.
class FloorSurfaces {
 public:
  FloorSurfaces() = default;  ///< shows nothing
  explicit FloorSurfaces(const World& world);

  /// How many floors it looks like within a distance of a point: different pictures, and twice as
  /// many under a sun, whose shadows have hard edges. What is narrower than 5 cm may be missed.
  int looks_within(double radius_m, const Vec2& p_scene) const;

  Vec2 low_scene() const { return low_scene_; }    ///< corners of the box around it; low above high
  Vec2 high_scene() const { return high_scene_; }  ///< where there is no floor

 private:
  struct Face {
    std::array<Vec3, 3> corners_scene;  // counter-clockwise from above
    Vec2 low_scene;                     // of the box around it
    Vec2 high_scene;
    int texture = 0;
  };
  std::vector<Face> faces_;
  Vec2 low_scene_ = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high_scene_ = -low_scene_;
  bool has_sun_ = false;
};

}  // namespace panoptes::sim
