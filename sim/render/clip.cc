// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/clip.h"

namespace panoptes::sim {

Eigen::Matrix4f clip_from_scene(const View& view, double near_m) {
  const Intrinsics& camera = view.intrinsics;
  const double w = camera.width_px;
  const double h = camera.height_px;
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = 2 * camera.fx_px / w;
  clip(0, 2) = 2 * (camera.cx_px + 0.5) / w - 1;
  clip(1, 1) = 2 * camera.fy_px / h;
  clip(1, 2) = 2 * (camera.cy_px + 0.5) / h - 1;
  clip(2, 3) = near_m;
  clip(3, 2) = 1;
  const Pose3 T_camera_scene = view.T_scene_camera.inverse();
  Eigen::Matrix4d camera_scene = Eigen::Matrix4d::Identity();
  camera_scene.topLeftCorner<3, 3>() = T_camera_scene.rotation.toRotationMatrix();
  camera_scene.topRightCorner<3, 1>() = T_camera_scene.translation;
  return (clip * camera_scene).cast<float>();
}

}  // namespace panoptes::sim
