// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/pose2.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_m = 1e-12;  // a few ulps at room scale

Pose2 random_pose(Rng& rng) {
  return {rng.uniform(-10, 10), rng.uniform(-10, 10), rng.uniform(-3.14, 3.14)};
}

TEST(Pose2, InverseUndoesTheTransform) {
  Rng rng(7);
  for (int i = 0; i < 100; ++i) {
    const Pose2 T_map_body = random_pose(rng);
    const Vec2 p_body(rng.uniform(-5, 5), rng.uniform(-5, 5));
    EXPECT_NEAR((T_map_body.inverse() * (T_map_body * p_body) - p_body).norm(), 0, kRoundoff_m);
  }
}

TEST(Pose2, CompositionIsTheTransformOfTransforms) {
  Rng rng(8);
  for (int i = 0; i < 100; ++i) {
    const Pose2 T_a_b = random_pose(rng);
    const Pose2 T_b_c = random_pose(rng);
    const Vec2 p_c(rng.uniform(-5, 5), rng.uniform(-5, 5));
    EXPECT_NEAR(((T_a_b * T_b_c) * p_c - T_a_b * (T_b_c * p_c)).norm(), 0, kRoundoff_m);
    EXPECT_NEAR((T_a_b * p_c - (T_a_b.rotation() * p_c + T_a_b.position())).norm(), 0, kRoundoff_m);
  }
}

TEST(Pose2, AnglesWrapToOneTurn) {
  constexpr double kPi = std::numbers::pi;
  EXPECT_EQ(wrap_angle(kPi), kPi);
  EXPECT_EQ(wrap_angle(-kPi), kPi);
  EXPECT_EQ(wrap_angle(0.5), 0.5);
  for (int turns = -5; turns <= 5; ++turns) {
    EXPECT_NEAR(wrap_angle(0.3 + 2 * kPi * turns), 0.3, 1e-14);
  }
}

TEST(Pose2, ATwistDrivesAnArc) {
  EXPECT_EQ(exp_twist({0.5, 0}, 2).x_m, 1);
  const Pose2 quarter = exp_twist({std::numbers::pi / 2, std::numbers::pi / 2}, 1);  // radius 1
  EXPECT_NEAR(quarter.x_m, 1, kRoundoff_m);
  EXPECT_NEAR(quarter.y_m, 1, kRoundoff_m);
  EXPECT_NEAR(quarter.theta_rad, std::numbers::pi / 2, kRoundoff_m);
  // two halves of an arc make the arc
  const Twist2 twist{0.3, -0.7};
  const Pose2 halves = exp_twist(twist, 0.4) * exp_twist(twist, 0.4);
  const Pose2 whole = exp_twist(twist, 0.8);
  EXPECT_NEAR((halves.position() - whole.position()).norm(), 0, kRoundoff_m);
}

}  // namespace
}  // namespace panoptes
