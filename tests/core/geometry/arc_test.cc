// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/arc.h"

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kRoundoff_m = 1e-12;  // a few ulps at room scale

TEST(Arc, BetweenTwoPosesLiesTheArc) {
  const Twist2 twist{0.3, -0.7};
  const Pose2 T_a_from{1, 2, 3};
  const Pose2 T_a_to = T_a_from * exp_twist(twist, 2);
  const Pose2 part = on_arc(T_a_from, T_a_to, 0.25);
  const Pose2 driven = T_a_from * exp_twist(twist, 0.5);
  EXPECT_NEAR((part.position() - driven.position()).norm(), 0, kRoundoff_m);
  EXPECT_NEAR(wrap_angle(part.theta_rad - driven.theta_rad), 0, kRoundoff_m);
  const Pose2 all = on_arc(T_a_from, T_a_to, 1);
  EXPECT_NEAR((all.position() - T_a_to.position()).norm(), 0, kRoundoff_m);
  // the body may slide: two quarters of the way are half of it
  const Pose2 T_a_slid{0.4, 2.5, -2.9};
  const Pose2 half = on_arc(T_a_from, T_a_slid, 0.5);
  const Pose2 twice = T_a_from * (T_a_from.inverse() * half) * (T_a_from.inverse() * half);
  EXPECT_NEAR((twice.position() - T_a_slid.position()).norm(), 0, kRoundoff_m);
}

}  // namespace
}  // namespace panoptes
