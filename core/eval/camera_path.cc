// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/camera_path.h"

#include <cmath>
#include <cstddef>

#include "core/base/check.h"

namespace panoptes {

CameraPathErrors camera_path_errors(const std::vector<Pose3>& T_map_camera,
                                    const std::vector<Pose3>& true_T_scene_camera) {
  PANOPTES_CHECK(T_map_camera.size() == true_T_scene_camera.size(), "a truth for every pose");
  CameraPathErrors errors;
  if (T_map_camera.empty()) {
    return errors;
  }
  const Pose3 T_map_scene = T_map_camera.front() * true_T_scene_camera.front().inverse();
  const Vec3 start = T_map_camera.front().translation;
  double both = 0;
  double own = 0;
  for (std::size_t i = 0; i < T_map_camera.size(); ++i) {
    const Pose3 T = T_map_scene * true_T_scene_camera[i];
    const Vec3 up_camera = true_T_scene_camera[i].rotation.conjugate() * Vec3::UnitZ();
    const Eigen::AngleAxisd off(T.rotation.conjugate() * T_map_camera[i].rotation);
    errors.heading_error_rad.push_back(
        std::abs(wrap_angle(off.angle()) * off.axis().dot(up_camera)));
    errors.path_m += errors.true_map.empty() ? 0 : (T.translation - errors.true_map.back()).norm();
    errors.true_map.push_back(T.translation);
    const Vec3 moved = T_map_camera[i].translation - start;
    both += moved.dot(T.translation - start);
    own += moved.squaredNorm();
  }
  errors.scale = own > 0 && both > 0 ? both / own : 1;
  double squares = 0;
  for (std::size_t i = 0; i < T_map_camera.size(); ++i) {
    const Vec3 moved = T_map_camera[i].translation - start;
    squares += (errors.scale * moved - (errors.true_map[i] - start)).squaredNorm();
  }
  errors.position_rms_m = std::sqrt(squares / static_cast<double>(T_map_camera.size()));
  return errors;
}

}  // namespace panoptes
