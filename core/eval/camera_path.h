// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/geometry/pose3.h"

namespace panoptes {

/// How far a camera's path is from the truth, its first pose laid on the true one.
struct CameraPathErrors {
  std::vector<double> heading_error_rad;  ///< of each pose, about the true vertical
  std::vector<Vec3> true_map;             ///< where it truly was, in map, true metres
  double path_m = 0;                      ///< of the camera, truly
  double position_rms_m = 0;              ///< after the scale that fits best
  double scale = 1;                       ///< true metres in one of the map's
};

/// Of poses at the same instants; `scene` has its z axis up.
CameraPathErrors camera_path_errors(const std::vector<Pose3>& T_map_camera,
                                    const std::vector<Pose3>& true_T_scene_camera);

}  // namespace panoptes
