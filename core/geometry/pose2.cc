// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/pose2.h"

#include <cmath>
#include <numbers>

namespace panoptes {

double wrap_angle(double angle_rad) {
  constexpr double kPi = std::numbers::pi;
  if (angle_rad > -kPi && angle_rad <= kPi) {
    return angle_rad;
  }
  const double wrapped = std::remainder(angle_rad, 2 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

Mat2 Pose2::rotation() const {
  const double c = std::cos(theta_rad);
  const double s = std::sin(theta_rad);
  return (Mat2() << c, -s, s, c).finished();
}

Pose2 Pose2::inverse() const {
  const Vec2 t = -(rotation().transpose() * position());
  return {t.x(), t.y(), wrap_angle(-theta_rad)};
}

Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c) {
  const Vec2 t = T_a_b * T_b_c.position();
  return {t.x(), t.y(), wrap_angle(T_a_b.theta_rad + T_b_c.theta_rad)};
}

Vec2 operator*(const Pose2& T_a_b, const Vec2& p_b) {
  const double c = std::cos(T_a_b.theta_rad);
  const double s = std::sin(T_a_b.theta_rad);
  return {T_a_b.x_m + c * p_b.x() - s * p_b.y(), T_a_b.y_m + s * p_b.x() + c * p_b.y()};
}

bool operator==(const Pose2& a, const Pose2& b) {
  return a.x_m == b.x_m && a.y_m == b.y_m && a.theta_rad == b.theta_rad;
}

Pose2 exp_twist(const Twist2& twist_body, double duration_s) {
  const double angle_rad = twist_body.w_radps * duration_s;
  const double length_m = twist_body.v_mps * duration_s;
  // chord of the arc: length * sinc(angle / 2), at half the angle
  const double half_rad = angle_rad / 2;
  const double sinc = std::abs(half_rad) < 1e-9 ? 1.0 : std::sin(half_rad) / half_rad;
  return {length_m * sinc * std::cos(half_rad), length_m * sinc * std::sin(half_rad),
          wrap_angle(angle_rad)};
}

}  // namespace panoptes
