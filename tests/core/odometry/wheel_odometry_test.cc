// SPDX-License-Identifier: BSD-3-Clause
#include "core/odometry/wheel_odometry.h"

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kBase_m = 0.33;

// Drives an arc in small steps with the noise that the options promise.
Pose2 drive(const WheelNoise& noise, double distance_m, double turn_rad, Rng rng) {
  constexpr int kSteps = 50;
  const double slip = 1 + rng.normal(0, noise.slip_share);
  Pose2 pose;
  for (int step = 0; step < kSteps; ++step) {
    double left = (distance_m - turn_rad * kBase_m / 2) / kSteps;
    double right = (distance_m + turn_rad * kBase_m / 2) / kSteps;
    left += rng.normal(0, noise.step_sigma_m * std::sqrt(std::abs(left)));
    right += rng.normal(0, noise.step_sigma_m * std::sqrt(std::abs(right)));
    pose = pose * exp_twist({(left + right) / 2, slip * (right - left) / kBase_m}, 1);
  }
  return pose;
}

class WheelCovariance : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(WheelCovariance, IsThatOfManyDrives) {
  const WheelNoise noise;
  const auto [distance_m, turn_rad] = GetParam();
  const Pose2 meant = exp_twist({distance_m, turn_rad}, 1);
  const Mat3 promised = wheel_covariance(noise, kBase_m, meant);
  Mat3 drawn = Mat3::Zero();
  constexpr int kDrives = 4000;
  const Rng rng(1);
  for (int i = 0; i < kDrives; ++i) {
    const Pose2 there = drive(noise, distance_m, turn_rad, rng.fork(std::to_string(i)));
    const Vec3 off(there.x_m - meant.x_m, there.y_m - meant.y_m, there.theta_rad - meant.theta_rad);
    drawn += off * off.transpose() / kDrives;
  }
  // heading and the swing it gives are what matters: within a fifth; never promised too sure
  EXPECT_NEAR(promised(2, 2) / drawn(2, 2), 1, 0.2);
  EXPECT_GT((promised.inverse() * drawn).trace() / 3, 0.4);
  EXPECT_LT((promised.inverse() * drawn).trace() / 3, 1.3);
}

INSTANTIATE_TEST_SUITE_P(StraightTurningAndBackwards, WheelCovariance,
                         ::testing::Values(std::pair(0.25, 0.0), std::pair(0.25, 0.2),
                                           std::pair(0.25, -0.2), std::pair(-0.25, 0.1),
                                           std::pair(0.0, 0.26)));

TEST(WheelOdometry, TellsWhatThePlatformSaysAndNothingThatIsNoNumber) {
  WheelOdometry wheels({}, Body());
  Observation seen;
  seen.odometry.T_odom_body = {1, 2, 3};
  seen.odometry.twist_body = {0.4, -0.5};
  const std::optional<Odometry> told = wheels.at(seen);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->T_odom_body, seen.odometry.T_odom_body);
  EXPECT_EQ(told->twist_body.w_radps, -0.5);
  for (double Pose2::*number : {&Pose2::x_m, &Pose2::y_m, &Pose2::theta_rad}) {
    Observation bad = seen;
    bad.odometry.T_odom_body.*number = std::nan("");
    EXPECT_FALSE(wheels.at(bad));
  }
  for (double Twist2::*number : {&Twist2::v_mps, &Twist2::w_radps}) {
    Observation bad = seen;
    bad.odometry.twist_body.*number = -std::numeric_limits<double>::infinity();
    EXPECT_FALSE(wheels.at(bad));
  }
}

TEST(WheelOdometry, GoesOnFromWhereItWasWhenTheWheelsJump) {
  WheelOdometry wheels({}, Body{});
  constexpr double kFrame_s = 1.0 / 15;
  const Twist2 twist{0.4, 0.5};
  const Pose2 T_reset{3, -1, 2.5};
  Pose2 T_true;
  for (int i = 0; i < 30; ++i) {
    Observation seen;
    seen.stamp = time_at(i * kFrame_s);
    seen.odometry.T_odom_body = i < 10 ? T_true : T_reset * T_true;
    seen.odometry.twist_body = twist;
    const std::optional<Odometry> told = wheels.at(seen);
    if (i == 10) {
      EXPECT_FALSE(told);
      EXPECT_NE(wheels.fault().find("jumped by "), std::string::npos) << wheels.fault();
    } else {
      ASSERT_TRUE(told) << i << " " << wheels.fault();
      EXPECT_LT((told->T_odom_body.position() - T_true.position()).norm(), 1e-9) << i;
      EXPECT_NEAR(wrap_angle(told->T_odom_body.theta_rad - T_true.theta_rad), 0, 1e-9) << i;
    }
    T_true = T_true * exp_twist(twist, kFrame_s);
  }
}

TEST(WheelOdometry, ALongGapIsNoJump) {
  WheelOdometry wheels({}, Body{});
  Observation seen;
  EXPECT_TRUE(wheels.at(seen));
  seen.stamp = time_at(4);
  seen.odometry.T_odom_body = {2, 0.5, 1};
  EXPECT_TRUE(wheels.at(seen)) << wheels.fault();
}

TEST(WheelOdometry, SaysWhatWheelsOfAnotherSizeTell) {
  Body body;
  body.wheel_base_m = kBase_m;
  const WheelOdometry wheels({}, body);
  constexpr double kWrong = 0.001;
  for (const auto& [left_m, right_m] : {std::pair(0.25, 0.25), std::pair(0.2, 0.26),
                                        std::pair(-0.25, -0.2), std::pair(-0.05, 0.05)}) {
    const auto told = [left = left_m, right = right_m](double scale, double difference,
                                                       double base) {
      const double l = left * (1 + scale - difference / 2);
      const double r = right * (1 + scale + difference / 2);
      return exp_twist({(l + r) / 2, (r - l) / (kBase_m * (1 + base))}, 1);
    };
    const Pose2 believed = told(0, 0, 0);
    const WheelJacobian J = wheels.by_wheels(believed);
    for (int k = 0; k < kWheelStates; ++k) {
      const Pose2 true_motion =
          told(k == kWheelScale ? kWrong : 0, k == kWheelDifference ? kWrong : 0,
               k == kWheelBase ? kWrong : 0);
      const Vec3 off(true_motion.x_m - believed.x_m, true_motion.y_m - believed.y_m,
                     true_motion.theta_rad - believed.theta_rad);
      EXPECT_LT((off / kWrong - J.col(k)).norm(), 0.03) << k << " " << left_m;
    }
  }
}

}  // namespace
}  // namespace panoptes
