// SPDX-License-Identifier: BSD-3-Clause
#include "hw/physical/odometry_track.h"

#include <gmock/gmock.h>

namespace panoptes::hw {
namespace {

constexpr double kRoundoff = 1e-12;

WheelPose on_arc(double t_s, const Twist2& twist_body) {
  return {time_at(t_s), Pose2{1, 2, 0.5} * exp_twist(twist_body, t_s), twist_body, 0};
}

void expect_near(const Pose2& is, const Pose2& expected) {
  EXPECT_NEAR(is.x_m, expected.x_m, kRoundoff);
  EXPECT_NEAR(is.y_m, expected.y_m, kRoundoff);
  EXPECT_NEAR(wrap_angle(is.theta_rad - expected.theta_rad), 0, kRoundoff);
}

TEST(OdometryTrack, InterpolatesAlongTheArc) {
  for (const Twist2& twist : {Twist2{0.5, deg_to_rad(60)}, Twist2{0.5, 0}, Twist2{0, -1.5},
                              Twist2{-0.3, 1e-9}, Twist2{0, 0}}) {
    OdometryTrack track;
    for (int k = 0; k <= 10; ++k) {
      track.add(on_arc(0.1 * k, twist));
    }
    for (const double t_s : {0.0, 0.033, 0.5, 0.777, 1.0}) {
      const auto odometry = track.at(time_at(t_s));
      ASSERT_TRUE(odometry) << t_s;
      EXPECT_FALSE(odometry->extrapolated);
      expect_near(odometry->T_odom_body, on_arc(t_s, twist).T_odom_body);
      EXPECT_NEAR(odometry->twist_body.w_radps, twist.w_radps, kRoundoff);
    }
  }
}

TEST(OdometryTrack, GoesOnePeriodBeyondTheLastReportAndSaysSo) {
  const Twist2 twist{0.4, -1};
  OdometryTrack track;
  EXPECT_FALSE(track.at(Time{}));
  for (int k = 0; k <= 10; ++k) {
    track.add(on_arc(0.1 * k, twist));
  }
  const auto beyond = track.at(time_at(1.09));
  ASSERT_TRUE(beyond);
  EXPECT_TRUE(beyond->extrapolated);
  expect_near(beyond->T_odom_body, on_arc(1.09, twist).T_odom_body);
  EXPECT_FALSE(track.at(time_at(1.11)));
  EXPECT_FALSE(track.at(time_at(-0.01)));
}

TEST(OdometryTrack, GoesOnTowardsTheCommandedVelocity) {
  OdometryTrack track({0.6, 3.0});
  track.add({time_at(1), {}, {0.1, 0}, 0});
  track.commanded({time_at(0.5), {0.1, 0}});
  track.commanded({time_at(1.02), {0.5, -0.3}});  // reached in turning after 0.1 s
  const auto beyond = track.at(time_at(1.1));
  ASSERT_TRUE(beyond);
  EXPECT_NEAR(beyond->twist_body.v_mps, 0.1 + 0.6 * 0.08, kRoundoff);
  EXPECT_NEAR(beyond->twist_body.w_radps, -3 * 0.08, kRoundoff);
  EXPECT_NEAR(beyond->T_odom_body.x_m, 0.1 * 0.1 + 0.3 * 0.08 * 0.08, 1e-5);  // chord for arc
  EXPECT_NEAR(beyond->T_odom_body.theta_rad, -1.5 * 0.08 * 0.08, kRoundoff);
}

TEST(OdometryTrack, LearnsThePeriodDespiteLostReports) {
  OdometryTrack track;
  for (int k = 0; k <= 40; ++k) {
    if (k % 5 != 3) {
      track.add(on_arc(0.05 * k, {}));
    }
  }
  EXPECT_EQ(track.period(), from_seconds(0.05));
  EXPECT_EQ(track.last(), time_at(2));
}

}  // namespace
}  // namespace panoptes::hw
