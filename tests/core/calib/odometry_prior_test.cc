// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/odometry_prior.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

/// Looks ahead (x right, y down, z ahead), 0.2 m before the axis and 0.1 m to its left.
RigCamera ahead() {
  RigCamera camera;
  Mat3 R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  camera.T_body_camera = {Eigen::Quaterniond(R), Vec3(0.2, 0.1, 0.7)};
  camera.sigma.rotation_rad = Vec3::Zero();
  return camera;
}

TEST(OdometryPrior, ACameraOffTheAxisIsSwungRound) {
  const MotionTold told = camera_motion({0, 0, deg_to_rad(90)}, ahead());
  // From (0.2, 0.1) to (-0.1, 0.2): 0.1 m to the left and 0.3 m back.
  EXPECT_LT((told.T_before_now.translation - Vec3(-0.1, 0, -0.3)).norm(), 1e-12);
  // to the left: about y, which is down, the other way
  EXPECT_LT((told.T_before_now.rotation * Vec3::UnitZ() + Vec3::UnitX()).norm(), 1e-12);
}

TEST(OdometryPrior, DrivingAheadIsAlongTheLineOfSight) {
  const MotionTold told = camera_motion({0.1, 0, 0}, ahead());
  EXPECT_LT((told.T_before_now.translation - Vec3(0, 0, 0.1)).norm(), 1e-12);
}

TEST(OdometryPrior, IsLessCertainTheFartherItGoesAndTheWorseTheMountingIsKnown) {
  const auto shift_sigma_m = [](double moved_m, double mounted_rad) {
    RigCamera camera = ahead();
    camera.sigma.rotation_rad = Vec3::Constant(mounted_rad);
    const MotionTold told = camera_motion({moved_m, 0, 0}, camera);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Mat3>(told.covariance.topLeftCorner<3, 3>())
                  .eigenvalues()
                  .minCoeff(),
              0);
    return std::sqrt(told.covariance.topLeftCorner<3, 3>().trace());
  };
  EXPECT_GT(shift_sigma_m(0.2, 0), shift_sigma_m(0.05, 0));
  EXPECT_GT(shift_sigma_m(0.2, 0.05), 1.4 * shift_sigma_m(0.2, 0));
}

// A body that has turned more than was told has swung the camera farther.
TEST(OdometryPrior, AnErrorOfTheTurnShiftsTheCameraToo) {
  const RigCamera camera = ahead();
  const Pose2 motion{0.05, 0, 0.3};
  const MotionTold told = camera_motion(motion, camera);
  const double off_rad = 1e-6;
  const Pose3 off =
      camera_motion({motion.x_m, motion.y_m, motion.theta_rad + off_rad}, camera).T_before_now;
  Eigen::Matrix<double, 6, 1> by_turn;
  const Eigen::AngleAxisd turn(told.T_before_now.rotation.conjugate() * off.rotation);
  by_turn << (off.translation - told.T_before_now.translation) / off_rad,
      turn.angle() / off_rad * turn.axis();
  // What the turn alone explains of the shift, by the covariance: along its own direction.
  const Vec3 axis = by_turn.tail<3>();
  const Vec3 explained = told.covariance.topRightCorner<3, 3>() *
                         told.covariance.bottomRightCorner<3, 3>().inverse() * axis;
  EXPECT_LT((explained - by_turn.head<3>()).norm(), 1e-4);
}

}  // namespace
}  // namespace panoptes
