// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/joint_of_rig.h"

#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
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

TEST(JointOfRig, BeforeACalibrationEachNumberIsKnownToItsSigma) {
  RigCamera ahead;
  ahead.intrinsics = pinhole(320, 240, 1.2);
  ahead.intrinsics.distortion = BrownConrady{};
  ahead.sigma.position_m = Vec3(0.01, 0.02, 0.03);
  ahead.sigma.focal_ratio = 0.002;
  const Eigen::MatrixXd before = covariance_before({"ahead"}, {ahead}, std::nullopt);
  ASSERT_EQ(before.rows(), 6 + 9 + 1);
  EXPECT_DOUBLE_EQ(before(4, 4), 0.02 * 0.02);
  const double fx_px = 0.002 * ahead.intrinsics.fx_px;
  EXPECT_NEAR(before(6, 6), fx_px * fx_px, 1e-12);
  const double ratio = before(6, 6) + before(7, 7) - 2 * before(6, 7);
  EXPECT_NEAR(std::sqrt(ratio), 0.1 * fx_px, 1e-9) << "fy goes with fx";
  EXPECT_DOUBLE_EQ(std::sqrt(before(10, 10)), 0.002);
  EXPECT_EQ(before(0, 3), 0);
}

TEST(JointOfRig, BeforeAnotherCalibrationWhatWentTogetherGoesTogether) {
  std::vector<RigCamera> rig(2);
  rig[0].intrinsics = rig[1].intrinsics = pinhole(320, 240, 1.2);
  rig[1].intrinsics.distortion = BrownConrady{};
  JointCovariance joint;
  for (const char* name : {"a", "b"}) {
    const bool is_b = name[0] == 'b';
    const auto of = joint_parameters(name, rig[is_b ? 1 : 0].intrinsics);
    joint.parameters.insert(joint.parameters.end(), of.begin(), of.end());
  }
  const auto size = static_cast<Eigen::Index>(joint.parameters.size());
  joint.covariance = 1e-6 * Eigen::MatrixXd::Identity(size, size);
  joint.covariance(5, 11 + 5) = joint.covariance(11 + 5, 5) = 1e-6;  // heights
  joint.covariance(11 + 10, 11 + 10) = 4e-8;                         // k1
  const Eigen::MatrixXd turned = covariance_before({"b", "a"}, {rig[1], rig[0]}, joint);
  ASSERT_EQ(turned.rows(), size);
  EXPECT_NEAR(turned(5, 16 + 5), 0.01 * 0.01, 1e-9) << "by the cameras' sigmas, wholly together";
  EXPECT_NEAR(std::sqrt(turned(10, 10)), 2e-4, 1e-9) << "no sigma says it";
  EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(turned).info(), Eigen::Success);
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
