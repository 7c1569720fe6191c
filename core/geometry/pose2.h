// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace panoptes {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;

/// The same angle in (-pi, pi].
double wrap_angle(double angle_rad);
constexpr double deg_to_rad(double deg) { return deg * 0.017453292519943295769; }
constexpr double rad_to_deg(double rad) { return rad * 57.295779513082320877; }

/// A pose in the plane: position in metres, heading counter-clockwise from x in radians (kept in
/// (-pi, pi] by the operations). `T_a_b * p_b = p_a`.
struct Pose2 {
  double x_m = 0;
  double y_m = 0;
  double theta_rad = 0;

  Vec2 position() const { return {x_m, y_m}; }
  Mat2 rotation() const;
  Pose2 inverse() const;
};

Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c);
Vec2 operator*(const Pose2& T_a_b, const Vec2& p_b);
bool operator==(const Pose2& a, const Pose2& b);

/// Velocity of a wheeled body in its own frame: forward and counter-clockwise are positive.
struct Twist2 {
  double v_mps = 0;
  double w_radps = 0;
};

/// The pose reached from the origin by a constant twist: an arc of a circle, exactly.
Pose2 exp_twist(const Twist2& twist_body, double duration_s);

}  // namespace panoptes
