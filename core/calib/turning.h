// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// Where a camera was, in a map of its own metre, at one of its stamps.
struct StampedCamera {
  Time stamp;
  Pose3 T_map_camera;
};

/// How a camera on a body that drives over a floor turns.
struct Turning {
  Vec3 axis_map = Vec3::UnitZ();  ///< of all turns: the floor's normal, up or down
  std::vector<double> angle_rad;  ///< about it, since the first pose; more than a turn goes on

  /// The same about the other normal.
  Turning reversed() const;
};

/// The axis that most turns of a path are about (least squares of sines), and the turns.
Turning turning_of(const std::vector<StampedCamera>& path);

}  // namespace panoptes
