// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/camera_map_truth.h"

#include <cmath>

#include "core/eval/trajectory.h"
#include "hw/replay/truth_files.h"

namespace panoptes {

std::optional<TrueCameraPath> TrueCameraPath::read(const std::filesystem::path& dataset,
                                                   const std::string& camera) {
  const std::optional<hw::RecordedTruth> recorded = hw::RecordedTruth::read(dataset);
  if (!recorded || recorded->observations() == 0) {
    return std::nullopt;
  }
  const Truth truth = recorded->after(recorded->observations());
  if (truth.poses.empty() || !truth.rig || !truth.rig->cameras.contains(camera)) {
    return std::nullopt;
  }
  TrueCameraPath path;
  path.poses_ = truth.poses;
  path.camera_ = truth.rig->cameras.at(camera);
  return path;
}

Pose3 TrueCameraPath::T_scene_camera(Time stamp) const {
  return on_floor(true_pose_at(poses_, stamp - from_seconds(camera_.clock_offset_s))) *
         camera_.T_body_camera;
}

Vec3 TrueCameraPath::up_camera() const {
  return camera_.T_body_camera.rotation.conjugate() * Vec3::UnitZ();
}

CameraPathErrors camera_path_errors(const std::vector<MonoMap::Frame>& frames,
                                    const TrueCameraPath& truth) {
  CameraPathErrors errors;
  if (frames.empty()) {
    return errors;
  }
  const Pose3 T_map_scene =
      frames.front().T_map_camera * truth.T_scene_camera(frames.front().stamp).inverse();
  double both = 0;
  double own = 0;
  const Vec3 start = frames.front().T_map_camera.translation;
  for (const MonoMap::Frame& frame : frames) {
    const Pose3 T = T_map_scene * truth.T_scene_camera(frame.stamp);
    const Eigen::AngleAxisd off(T.rotation.conjugate() * frame.T_map_camera.rotation);
    const double angle_rad = wrap_angle(off.angle());
    errors.heading_error_rad.push_back(std::abs(angle_rad * off.axis().dot(truth.up_camera())));
    errors.path_m += errors.true_map.empty() ? 0 : (T.translation - errors.true_map.back()).norm();
    errors.true_map.push_back(T.translation);
    const Vec3 moved = frame.T_map_camera.translation - start;
    both += moved.dot(T.translation - start);
    own += moved.squaredNorm();
  }
  errors.scale = own > 0 ? both / own : 1;
  double squares = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Vec3 moved = frames[i].T_map_camera.translation - start;
    squares += (errors.scale * moved - (errors.true_map[i] - start)).squaredNorm();
  }
  errors.position_rms_m = std::sqrt(squares / static_cast<double>(frames.size()));
  return errors;
}

}  // namespace panoptes
