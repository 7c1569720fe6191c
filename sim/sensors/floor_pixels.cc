// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/floor_pixels.h"

#include <cmath>

namespace panoptes::sim {

int first_mapped_row(const RigCamera& camera) {
  return camera.floor && camera.floor->rows == FloorView::Rows::kLowerHalf
             ? camera.intrinsics.height_px / 2
             : 0;
}

std::optional<Vec2> floor_under(const RigCamera& true_camera, const Vec2& px) {
  const std::optional<Vec3> ray_camera = true_camera.intrinsics.direction(px);
  if (!ray_camera) {
    return std::nullopt;
  }
  const Vec3 ray_body = true_camera.T_body_camera.rotation * *ray_camera;
  const Vec3& eye_body = true_camera.T_body_camera.translation;
  if (ray_body.z() >= 0 || eye_body.z() <= 0) {
    return std::nullopt;
  }
  const Vec3 p_body = eye_body - ray_body * (eye_body.z() / ray_body.z());
  return Vec2(p_body.x(), p_body.y());
}

bool in_mapped_range(const RigCamera& true_camera, const Body& body, const Vec2& p_body) {
  const double heading_rad = floor_heading_rad(true_camera.T_body_camera);
  const double ahead_m =
      p_body.dot(Vec2(std::cos(heading_rad), std::sin(heading_rad))) - body.radius_m;
  return ahead_m >= true_camera.floor->near_m && ahead_m <= true_camera.floor->far_m;
}

}  // namespace panoptes::sim
