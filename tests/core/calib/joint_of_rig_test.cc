// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/joint_of_rig.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-12;  // relative, of an eigen decomposition

// A pinhole and a fisheye, and what is known of them and of three wheel errors.
RigCalibration known_by(const Eigen::MatrixXd& covariance) {
  RigCalibration told;
  told.cameras = {"up", "ahead"};
  Intrinsics fisheye = pinhole(320, 320, 1.2);
  fisheye.distortion = Equidistant{};
  told.bundle.state.lenses = {fisheye, pinhole(320, 240, 1.2)};
  told.bundle.known.camera = {0, 15};
  told.bundle.known.wheels = 26;
  told.bundle.known.covariance = covariance;
  return told;
}

Eigen::MatrixXd a_covariance(Eigen::Index rank) {
  Rng rng(3);
  Eigen::MatrixXd half(29, rank);
  for (double& number : half.reshaped()) {
    number = rng.normal(0, 1);
  }
  const Eigen::VectorXd units = Eigen::VectorXd::LinSpaced(29, -4, 0).array().exp();
  return units.asDiagonal() * (half * half.transpose()) * units.asDiagonal();
}

TEST(JointOfRig, IsOfTheCamerasInTheirOrder) {
  const Eigen::MatrixXd covariance = a_covariance(40);
  const JointCovariance joint = joint_covariance(known_by(covariance));
  ASSERT_EQ(joint.parameters.size(), 26U);
  EXPECT_EQ(joint.parameters[14], "up.clock_s");
  EXPECT_EQ(joint.parameters[15], "ahead.rotation_x_rad");
  EXPECT_EQ(joint.parameters[25], "ahead.clock_s");
  EXPECT_LT((joint.covariance - covariance.topLeftCorner<26, 26>()).norm(),
            kRoundoff * covariance.norm());
}

TEST(JointOfRig, IsReadAgainWhereRoundoffHasLeftItIndefinite) {
  Eigen::MatrixXd covariance = a_covariance(5);
  covariance.diagonal() *= 1 - 1e-5;
  const RigCalibration told = known_by(covariance);
  Rig rig;
  rig.cameras["up"].intrinsics = told.bundle.state.lenses[0];
  rig.cameras["ahead"].intrinsics = told.bundle.state.lenses[1];
  rig.covariance = joint_covariance(told);
  const auto back = read_settings_text<Rig>(write_settings(rig), "rig.yaml");
  EXPECT_EQ(back.covariance->covariance, rig.covariance->covariance);
}

}  // namespace
}  // namespace panoptes
