// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/odometry_prior.h"

#include <cmath>

#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

// One sigma, of the motion between two pictures: what wheels miss by slip and by their steps, and
// what the floor and the springs do.
constexpr double kSlips = 0.03;  // as a share
constexpr double kShift_m = 0.001;
constexpr double kTurn_rad = 0.005;

}  // namespace

MotionTold camera_motion(const Pose2& T_before_now, const RigCamera& camera) {
  const Pose3 T_body = on_floor(T_before_now);
  const Pose3& T_body_camera = camera.T_body_camera;
  const double moved_m = T_before_now.position().norm();
  const double turned_rad = std::abs(T_before_now.theta_rad);
  const double mounted_rad = camera.sigma.rotation_rad.maxCoeff();
  const double shift_m = std::hypot(kShift_m, kSlips * moved_m, mounted_rad * moved_m) +
                         camera.sigma.position_m.maxCoeff() * turned_rad;
  const double turn_rad = std::hypot(kTurn_rad, kSlips * turned_rad, mounted_rad * turned_rad);
  Eigen::Matrix<double, 6, 1> sigma_body;
  sigma_body << Vec3::Constant(shift_m), Vec3::Constant(turn_rad);
  // The body's shift, and its turn about the axes it then has, as the camera's.
  const Mat3 R_camera_body = T_body_camera.rotation.conjugate().toRotationMatrix();
  Eigen::Matrix<double, 6, 6> by_body = Eigen::Matrix<double, 6, 6>::Zero();
  by_body.topLeftCorner<3, 3>() = R_camera_body;
  by_body.topRightCorner<3, 3>() =
      -R_camera_body * T_body.rotation.toRotationMatrix() * cross_matrix(T_body_camera.translation);
  by_body.bottomRightCorner<3, 3>() = R_camera_body;
  const Eigen::Matrix<double, 6, 6> root = by_body * sigma_body.asDiagonal();
  return {T_body_camera.inverse() * T_body * T_body_camera, root * root.transpose()};
}

}  // namespace panoptes
