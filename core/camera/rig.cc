// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/rig.h"

#include <algorithm>
#include <cmath>

namespace panoptes {

Vec2 Intrinsics::project(const Vec3& p_camera) const {
  return {cx_px + fx_px * p_camera.x() / p_camera.z(), cy_px + fy_px * p_camera.y() / p_camera.z()};
}

Vec3 Intrinsics::ray(const Vec2& px) const {
  return {(px.x() - cx_px) / fx_px, (px.y() - cy_px) / fy_px, 1};
}

Intrinsics pinhole(int width_px, int height_px, double horizontal_fov_rad) {
  const double f_px = width_px / (2 * std::tan(horizontal_fov_rad / 2));
  return {width_px, height_px, f_px, f_px, (width_px - 1) / 2.0, (height_px - 1) / 2.0, {}};
}

bool RigCamera::has_role(std::string_view role) const {
  return std::find(roles.begin(), roles.end(), role) != roles.end();
}

std::string Rig::with_role(std::string_view role) const {
  for (const auto& [name, camera] : cameras) {
    if (camera.has_role(role)) {
      return name;
    }
  }
  return {};
}

}  // namespace panoptes
