// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/rig_figures.h"

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr double kNumeric = 1e-7;  // of derivatives found by differences

Rig believed_rig() {
  Rig rig;
  for (const auto& [name, yaw_rad] : {std::pair{"front", 0.0}, {"back", 3.1}}) {
    RigCamera& camera = rig.cameras[name];
    camera.roles = {std::string("loop_") + name};
    camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
    camera.T_body_camera = mounted_camera({0.2, 0, 0.5}, yaw_rad, 0);
    camera.clock_offset_s = 0.004;
  }
  return rig;
}

/// Whose prior is one sigma of these, and of which nothing is known yet.
RigEstimate nothing_learned(const Rig& rig) {
  CameraCorrection sigmas;
  sigmas << 0.02, 0.02, 0.02, 0.01, 0.01, 0.01, 0.005, 2, 2, 0.01;
  RigEstimate estimate;
  estimate.believed = loop_cameras(rig);
  const int states = rig_states(estimate.believed.size());
  estimate.state = RigState::Zero(states);
  estimate.prior_covariance = Eigen::MatrixXd::Zero(states, states);
  for (const int at : {camera_state(0), camera_state(1)}) {
    estimate.prior_covariance.diagonal().segment<kCameraStates>(at) = sigmas.cwiseAbs2();
  }
  estimate.prior_covariance.diagonal().tail<kWheelStates>() << 2.5e-5, 2.5e-5, 4e-4;
  estimate.covariance = estimate.prior_covariance;
  return estimate;
}

LearnedCamera front_of(const RigEstimate& estimate, const Rig& rig, const Rig* truth) {
  return learned_cameras(estimate, rig, truth).at("front");
}

TEST(RigFigures, OfWhatWasNotObservedAreAbsent) {
  const Rig rig = believed_rig();
  RigEstimate estimate = nothing_learned(rig);
  estimate.covariance *= 0.6;  // less than the rig file says itself
  const LearnedCamera none = front_of(estimate, rig, &rig);
  EXPECT_FALSE(none.roll_rad || none.pitch_rad || none.yaw_rad || none.x_m || none.y_m);
  EXPECT_FALSE(none.clock_s || none.centre_bearing_rad || none.position_error_m);
  EXPECT_FALSE(none.consistency.has_value());
  const LearnedWheels wheels = learned_wheels(estimate, 0.33);
  EXPECT_FALSE(wheels.radius_ratio || wheels.base_m);
  estimate.covariance(kRotation + 2, kRotation + 2) *= 0.01;
  const LearnedCamera yaw = front_of(estimate, rig, &rig);
  EXPECT_FALSE(yaw.pitch_rad || yaw.x_m);
  ASSERT_TRUE(yaw.yaw_rad.has_value());
  EXPECT_NEAR(yaw.yaw_rad->sigma, 0.1 * std::sqrt(0.6) * 0.02, kNumeric);
  ASSERT_TRUE(yaw.consistency.has_value());
  EXPECT_EQ(yaw.consistency->freedom, 1);
}

TEST(RigFigures, OfAKnownCorrectionAreThatAndWithoutError) {
  const Rig rig = believed_rig();
  Rig truth = rig;
  RigCamera& front = truth.cameras["front"];
  const MountingOffset off{{0.01, -0.02, 0.03}, {0.004, -0.005, 0.006}};
  front.T_body_camera = displaced(front.T_body_camera, off);
  front.clock_offset_s = 0.011;
  front.intrinsics.cx_px += 1;
  RigEstimate estimate = nothing_learned(rig);
  const Eigen::AngleAxisd turn(front.T_body_camera.rotation *
                               rig.cameras.at("front").T_body_camera.rotation.conjugate());
  estimate.state.segment<3>(kRotation) = turn.angle() * turn.axis();
  estimate.state.segment<3>(kPosition) = off.shift_m;
  estimate.state[kCentre] = 1;
  estimate.state[kClock] = 0.007;
  estimate.covariance *= 1e-4;
  const LearnedCamera one = front_of(estimate, rig, &truth);
  EXPECT_NEAR(one.roll_rad->value, 0.01, kNumeric);
  EXPECT_NEAR(one.pitch_rad->value, -0.02, kNumeric);
  EXPECT_NEAR(one.yaw_rad->value, 0.03, kNumeric);
  EXPECT_NEAR(one.x_m->value, 0.004, kNumeric);
  EXPECT_NEAR(one.y_m->value, -0.005, kNumeric);
  EXPECT_NEAR(one.z_m->value, 0.006, kNumeric);
  EXPECT_NEAR(one.clock_s->value, 0.011, kNumeric);
  for (const auto& learned : {one.roll_rad, one.pitch_rad, one.yaw_rad, one.x_m, one.y_m, one.z_m,
                              one.clock_s, one.centre_bearing_rad}) {
    EXPECT_NEAR(*learned->error, 0, kNumeric);
  }
  EXPECT_NEAR(*one.position_error_m, 0, kNumeric);
  EXPECT_NEAR(one.consistency->chi2, 0, 1e-3);
  EXPECT_EQ(one.consistency->freedom, kCameraStates);
  EXPECT_TRUE(one.consistency->inside_95);
}

TEST(RigFigures, ErrorsAreEstimatedMinusTrue) {
  const Rig rig = believed_rig();
  RigEstimate estimate = nothing_learned(rig);
  estimate.state[kRotation + 2] = 0.01;
  estimate.state[kPosition] = 0.003;
  estimate.state[kPosition + 1] = -0.004;
  estimate.covariance *= 0.01;
  const LearnedCamera one = front_of(estimate, rig, &rig);
  EXPECT_NEAR(*one.yaw_rad->error, 0.01, kNumeric);
  EXPECT_NEAR(*one.y_m->error, -0.004, kNumeric);
  EXPECT_NEAR(*one.position_error_m, 0.005, kNumeric);
  EXPECT_NEAR(one.consistency->chi2, 100 * (0.25 + 0.09 + 0.16), 1e-3);
  EXPECT_FALSE(one.consistency->inside_95);
  EXPECT_FALSE(front_of(estimate, rig, nullptr).yaw_rad->error.has_value());
  EXPECT_FALSE(front_of(estimate, rig, nullptr).consistency.has_value());
}

// Pictures show where the camera looks, and not whether that is yaw or the principal point.
TEST(RigFigures, BearingOfTheCentreIsKnownWhereYawAndPrincipalPointAreNot) {
  const Rig rig = believed_rig();
  RigEstimate estimate = nothing_learned(rig);
  const double f_px = rig.cameras.at("front").intrinsics.fx_px;
  // about what looks ahead, a yaw of 1 rad to the left and a centre f px to the right do the same
  CameraCorrection shows = CameraCorrection::Zero();
  shows[kRotation + 2] = 1;
  shows[kCentre] = 1 / f_px;
  const double sigma_rad = 1e-4;
  const CameraCovariance prior =
      estimate.prior_covariance.topLeftCorner<kCameraStates, kCameraStates>();
  const CameraCorrection gain = prior * shows / (shows.dot(prior * shows) + sigma_rad * sigma_rad);
  estimate.covariance.topLeftCorner<kCameraStates, kCameraStates>() =
      prior - gain * (prior * shows).transpose();
  const LearnedCamera one = front_of(estimate, rig, &rig);
  ASSERT_TRUE(one.centre_bearing_rad.has_value());
  EXPECT_NEAR(one.centre_bearing_rad->sigma, sigma_rad, 0.01 * sigma_rad);
  EXPECT_EQ(one.consistency->freedom, 1);
}

TEST(RigFigures, OfTruthsDrawnFromTheCovarianceLieInsideAsOftenAsTheyOught) {
  const Rig rig = believed_rig();
  RigEstimate estimate = nothing_learned(rig);
  estimate.covariance *= 1e-4;
  Rng rng(5);
  constexpr int kRuns = 400;
  int inside = 0;
  for (int run = 0; run < kRuns; ++run) {
    for (int k = 0; k < kCameraStates; ++k) {
      estimate.state[k] = rng.normal(0, std::sqrt(estimate.covariance(k, k)));
    }
    inside += front_of(estimate, rig, &rig).consistency->inside_95 ? 1 : 0;
  }
  EXPECT_NEAR(inside, 0.95 * kRuns, 3 * std::sqrt(0.95 * 0.05 * kRuns));  // three sigma
}

TEST(RigFigures, OfACameraThatLooksUpHaveNoBearing) {
  Rig rig = believed_rig();
  rig.cameras["front"].T_body_camera = mounted_camera({0, 0, 0.5}, 0, deg_to_rad(-80));
  RigEstimate estimate = nothing_learned(rig);
  estimate.covariance *= 0.01;
  EXPECT_FALSE(front_of(estimate, rig, &rig).centre_bearing_rad.has_value());
  EXPECT_TRUE(front_of(estimate, rig, &rig).yaw_rad.has_value());
}

TEST(RigFigures, OfCamerasThatTheTruthDoesNotKnowHaveNoErrors) {
  const Rig rig = believed_rig();
  Rig truth = rig;
  truth.cameras.erase("front");
  RigEstimate estimate = nothing_learned(rig);
  estimate.covariance *= 0.01;
  EXPECT_FALSE(front_of(estimate, rig, &truth).x_m->error.has_value());
}

TEST(RigFigures, OfWheelsAreTheirRatioAndTheirBase) {
  RigEstimate estimate = nothing_learned(believed_rig());
  estimate.covariance *= 0.01;
  estimate.state.tail<kWheelStates>() << 0.001, -0.002, 0.01;
  const LearnedWheels wheels = learned_wheels(estimate, 0.33);
  EXPECT_NEAR(wheels.radius_ratio->value, 1.001 / 0.999, kNumeric);  // the right one is smaller
  EXPECT_NEAR(wheels.radius_ratio->sigma, 0.0005, 1e-5);
  EXPECT_NEAR(wheels.base_m->value, 0.3333, kNumeric);
  EXPECT_NEAR(wheels.base_m->sigma, 0.33 * 0.002, kNumeric);
}

}  // namespace
}  // namespace panoptes
