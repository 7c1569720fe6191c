// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/pose3.h"

#include <cmath>

namespace panoptes {

Pose3 Pose3::inverse() const {
  const Eigen::Quaterniond back = rotation.conjugate();
  return {back, -(back * translation)};
}

Pose3 operator*(const Pose3& T_a_b, const Pose3& T_b_c) {
  return {(T_a_b.rotation * T_b_c.rotation).normalized(), T_a_b * T_b_c.translation};
}

Vec3 operator*(const Pose3& T_a_b, const Vec3& p_b) {
  return T_a_b.rotation * p_b + T_a_b.translation;
}

Pose3 on_floor(const Pose2& T_a_b) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(T_a_b.theta_rad, Vec3::UnitZ())),
          Vec3(T_a_b.x_m, T_a_b.y_m, 0)};
}

double floor_heading_rad(const Pose3& T_body_camera) {
  constexpr double kRoundoff = 1e-12;  // a camera mounted straight ahead looks straight ahead
  const Vec3 axis = T_body_camera.rotation * Vec3::UnitZ();
  const Vec3 edge = T_body_camera.rotation * Vec3(0, axis.z() < 0 ? -1 : 1, 0);
  const Vec3& towards = axis.head<2>().norm() > kRoundoff ? axis : edge;
  return std::atan2(std::abs(towards.y()) < kRoundoff ? 0.0 : towards.y(), towards.x());
}

Pose3 mounted_camera(const Vec3& position_body, double yaw_rad, double tilt_rad) {
  Mat3 R_body_camera;  // columns: the camera's x, y, z axes seen from the body, looking ahead
  R_body_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Quaterniond turn =
      Eigen::AngleAxisd(yaw_rad, Vec3::UnitZ()) * Eigen::AngleAxisd(tilt_rad, Vec3::UnitY());
  return {(turn * Eigen::Quaterniond(R_body_camera)).normalized(), position_body};
}

}  // namespace panoptes
