// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/calib/turning.h"
#include "core/camera/mounting.h"
#include "tests/support/driven_rose.h"

namespace panoptes {

/// A camera that looks to the left and down, rolled, by a clock of its own.
inline RigCamera driven_camera() {
  RigCamera camera;
  camera.T_body_camera = mounted_camera({0.15, -0.1, 0.7}, 1.2, 0.1);
  camera.T_body_camera.rotation =
      (camera.T_body_camera.rotation * turned_by({0, 0, 0.05})).normalized();
  camera.clock_offset_s = 0.037;
  return camera;
}

/// Its path, in a map that lies so and whose metres are so long.
inline std::vector<StampedCamera> driven_camera_path(const DrivenRose& drive,
                                                     const RigCamera& camera,
                                                     const Pose3& T_map_start, double map_metre_m) {
  std::vector<StampedCamera> path;
  for (std::size_t i = 0; i < drive.instants(); ++i) {
    Pose3 T = T_map_start * on_floor(drive.T_start_body(i)) * camera.T_body_camera;
    T.translation /= map_metre_m;
    path.push_back({drive.instant(i) + from_seconds(camera.clock_offset_s), T});
  }
  return path;
}

}  // namespace panoptes
