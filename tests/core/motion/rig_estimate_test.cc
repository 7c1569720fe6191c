// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/rig_estimate.h"

#include <gtest/gtest.h>

#include "core/camera/lens_correction.h"
#include "core/camera/rectify.h"
#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-9;
constexpr double kNumeric = 1e-6;  // of derivatives found by differences

Rig believed_rig(const Distortion& distortion = NoDistortion{}) {
  Rig rig;
  for (const auto& [name, yaw_rad] : {std::pair{"front", 0.0}, {"back", 3.1}, {"floor", 0.0}}) {
    RigCamera& camera = rig.cameras[name];
    camera.roles = {name == std::string("floor") ? "floor" : std::string("loop_") + name};
    camera.intrinsics = lens_of_view(320, 240, deg_to_rad(90), distortion);
    camera.T_body_camera = mounted_camera({0.2, 0.01, 0.5}, yaw_rad, 0.1);
    camera.clock_offset_s = 0.004;
  }
  rig.cameras["floor"].floor.emplace();
  return rig;
}

/// As a run has it that has seen nothing.
RigEstimate nothing_learned(const Rig& rig) {
  RigEstimate estimate;
  estimate.believed = loop_cameras(Rectifier(rig).rig());
  const int states = rig_states(estimate.believed.size());
  RigState sigmas = RigState::Constant(states, 0.01);
  for (int i = 0; i < static_cast<int>(estimate.believed.size()); ++i) {
    const CameraSigmas& sigma = estimate.believed[static_cast<std::size_t>(i)].sigma;
    sigmas.segment<kCameraStates>(camera_state(i)) << sigma.rotation_rad, sigma.position_m,
        sigma.focal_ratio, sigma.centre_px, sigma.centre_px, sigma.clock_s;
  }
  estimate.state = RigState::Zero(states);
  estimate.prior_covariance = sigmas.cwiseAbs2().asDiagonal();
  estimate.covariance = estimate.prior_covariance;
  return estimate;
}

TEST(RigEstimate, OfARunThatLearnedNothingLeavesTheRigAsItIs) {
  const Rig rig = believed_rig();
  const Rig same = refined(rig, nothing_learned(rig));
  for (const auto& [name, camera] : rig.cameras) {
    const RigCamera& after = same.cameras.at(name);
    EXPECT_NEAR(after.T_body_camera.rotation.angularDistance(camera.T_body_camera.rotation), 0,
                kRoundoff);
    EXPECT_NEAR(after.intrinsics.fx_px, camera.intrinsics.fx_px, kRoundoff);
    EXPECT_NEAR(after.intrinsics.cx_px, camera.intrinsics.cx_px, kRoundoff);
    EXPECT_NEAR((after.sigma.rotation_rad - camera.sigma.rotation_rad).norm(), 0, kNumeric);
    EXPECT_NEAR(after.sigma.centre_px, camera.sigma.centre_px, kNumeric);
    EXPECT_NEAR((after.sigma.position_m - camera.sigma.position_m).norm(), 0, kNumeric);
    EXPECT_EQ(after.clock_offset_s, camera.clock_offset_s);
  }
}

TEST(RigEstimate, CorrectsWhatItKnowsAndSaysHowWell) {
  const Rig rig = believed_rig();
  RigEstimate estimate = nothing_learned(rig);
  const int back = camera_state(1);
  estimate.state.segment<kCameraStates>(back) << 0.01, -0.02, 0.03, 0.004, -0.005, 0.006, 0.002, 1,
      -0.5, 0.003;
  estimate.covariance.diagonal().segment<kCameraStates>(back).array() *= 0.01;  // a tenth of each
  const RigCamera& before = rig.cameras.at("back");
  const Rig now = refined(rig, estimate);
  const RigCamera& after = now.cameras.at("back");
  const Vec3 turn_rad(0.01, -0.02, 0.03);
  const Eigen::Quaterniond turned =
      Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()) * before.T_body_camera.rotation;
  EXPECT_NEAR(after.T_body_camera.rotation.angularDistance(turned), 0, kRoundoff);
  EXPECT_NEAR((after.T_body_camera.translation - before.T_body_camera.translation -
               Vec3(0.004, -0.005, 0.006))
                  .norm(),
              0, kRoundoff);
  EXPECT_NEAR(after.intrinsics.fx_px, 1.002 * before.intrinsics.fx_px, 1e-6);
  EXPECT_NEAR(after.intrinsics.cx_px, before.intrinsics.cx_px + 1, 1e-6);
  EXPECT_NEAR(after.intrinsics.cy_px, before.intrinsics.cy_px - 0.5, 1e-6);
  EXPECT_NEAR(after.clock_offset_s, 0.007, kRoundoff);
  constexpr double kBent = 0.05;  // of a sigma: roll, pitch, yaw are not quite turns about axes
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(after.sigma.rotation_rad[k] / before.sigma.rotation_rad[k], 0.1, 0.1 * kBent);
  }
  EXPECT_NEAR(after.sigma.position_m.x(), 0.1 * before.sigma.position_m.x(), kNumeric);
  EXPECT_NEAR(after.sigma.position_m.z(), 0.1 * before.sigma.position_m.z(), kNumeric);
  EXPECT_NEAR(after.sigma.focal_ratio, 0.1 * before.sigma.focal_ratio, kNumeric);
  EXPECT_NEAR(after.sigma.centre_px, 0.1 * before.sigma.centre_px, kNumeric);
  EXPECT_NEAR(after.sigma.clock_s, 0.1 * before.sigma.clock_s, kNumeric);
  EXPECT_EQ(write_settings(now.cameras.at("floor")), write_settings(rig.cameras.at("floor")));
}

TEST(RigEstimate, IsARigFileAsAnyOther) {
  const Rig rig = believed_rig(BrownConrady{-0.2, 0.03, 0, 0, 0});
  RigEstimate estimate = nothing_learned(rig);
  estimate.state.setConstant(1e-3);
  const std::string text = write_settings(refined(rig, estimate));
  EXPECT_EQ(write_settings(read_settings_text<Rig>(text, "rig_refined.yaml")), text);
}

TEST(RigEstimate, OfALensThatBendsIsOfTheLensItself) {
  const Rig rig = believed_rig(Equidistant{});
  RigEstimate estimate = nothing_learned(rig);
  estimate.state[kCentre] = 2;
  const Intrinsics& lens = rig.cameras.at("front").intrinsics;
  const RigCamera moved = refined(rig, estimate).cameras.at("front");
  const double by_px = of_lens({0, {2, 0}}, estimate.believed[0].intrinsics, lens).centre_px.x();
  EXPECT_NEAR(moved.intrinsics.cx_px - lens.cx_px, by_px, kRoundoff);
  EXPECT_EQ(moved.intrinsics.distortion, lens.distortion);
}

TEST(RigEstimate, LeavesALensThatItWouldMakeImpossible) {
  const Rig rig = believed_rig(BrownConrady{-0.1, 0, 0, 0, 0});
  RigEstimate estimate = nothing_learned(rig);
  estimate.state[kCentre] = 400;  // the axis is outside of the picture
  const RigCamera& front = rig.cameras.at("front");
  const RigCamera same = refined(rig, estimate).cameras.at("front");
  EXPECT_EQ(same.intrinsics.cx_px, front.intrinsics.cx_px);
  EXPECT_EQ(same.sigma.centre_px, front.sigma.centre_px);
}

TEST(RigEstimate, KeepsWhatTheFileTakesForExact) {
  Rig rig = believed_rig();
  rig.cameras["front"].sigma.rotation_rad.setZero();
  RigEstimate estimate = nothing_learned(rig);
  estimate.covariance.diagonal().array() += 1e-12;  // a graph holds it by a small prior
  EXPECT_EQ(refined(rig, estimate).cameras.at("front").sigma.rotation_rad, Vec3(0, 0, 0));
}

TEST(RigEstimate, SaysThatTheFileIsOfAnotherRig) {
  Rig rig = believed_rig();
  RigEstimate estimate = nothing_learned(rig);
  const int x = camera_state(0) + kPosition;  // of front
  estimate.state[x] = 0.1;
  EXPECT_EQ(not_this_rig(estimate.believed, estimate.state), "");
  estimate.state[x] = 0.39;
  EXPECT_EQ(not_this_rig(estimate.believed, estimate.state).find("front looks mounted 39 cm from"),
            0U);
  rig.cameras["front"].sigma.position_m.setConstant(0.2);  // known that roughly
  EXPECT_EQ(not_this_rig(nothing_learned(rig).believed, estimate.state), "");
}

TEST(RigEstimate, LeavesOutHowCamerasWereKnownTogether) {
  Rig rig = believed_rig();
  const RigEstimate estimate = nothing_learned(rig);
  rig.covariance = JointCovariance{{"front.rotation_x_rad"}, Eigen::MatrixXd::Identity(1, 1)};
  EXPECT_FALSE(refined(rig, estimate).covariance);
}

// Where a lens' centre lies is told from where its camera looks only by how its pictures bend.
TEST(SystematicCovariance, IsWideWhereCentreAndMountingGoTogether) {
  const LoopCameras cameras = testing::front_and_back();
  const Eigen::MatrixXd covariance = systematic_covariance(cameras);
  const Vec3 far_ahead = cameras[1].T_body_camera.rotation * Vec3(0, 0, 1000);
  const auto px_of = [&](const RigState& state) {
    const LoopCamera camera = corrected(cameras, state)[1];
    return camera.intrinsics.project(camera.T_body_camera.inverse() * far_ahead);
  };
  Eigen::MatrixXd J(2, covariance.rows());
  for (int k = 0; k < J.cols(); ++k) {
    const RigState step = 1e-6 * RigState::Unit(J.cols(), k);
    J.col(k) = (px_of(step) - px_of(-step)) / 2e-6;
  }
  const Mat2 of_axis = J * covariance * J.transpose();
  const int centre = camera_state(1) + kCentre;
  EXPECT_LT(std::sqrt(of_axis(0, 0)), 0.2);
  EXPECT_LT(std::sqrt(of_axis(1, 1)), 0.2);
  EXPECT_GT(std::sqrt(covariance(centre, centre)), 0.4);
  EXPECT_GT(std::sqrt(covariance(centre + 1, centre + 1)), 0.4);
}

}  // namespace
}  // namespace panoptes
