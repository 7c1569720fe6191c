// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/true_camera_path.h"

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

}  // namespace panoptes
