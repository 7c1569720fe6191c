// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/drive_path.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(DrivePath, AProgramIsDrivenToItsEndInTheTimeThatIsExpected) {
  const LegsAndTurns program;
  constexpr double kLongest_s = 1000;
  const DrivePath path = driven_path(program, Body(), kLongest_s);
  EXPECT_NEAR(to_seconds(path.end()) / expected_s(program, Body()), 1, 0.15);
  constexpr double kArrived_m = 0.01;  // a program is content with 2 mm a leg
  EXPECT_LT(path.poses().back().position().norm(), kArrived_m);
  EXPECT_LE(to_seconds(driven_path(program, Body(), 3).end()), 3);
}

TEST(DrivePath, WheelsTellTheVelocityAndNothingBeyondTheEnds) {
  const DrivePath path({Pose2(), {0.1, 0, 0}, {0.1, 0, 0.2}}, 0.5);
  constexpr double kRoundoff = 1e-9;
  EXPECT_NEAR(path.odometry(time_at(0.25))->T_odom_body.x_m, 0.05, kRoundoff);
  EXPECT_NEAR(path.odometry(time_at(0.25))->twist_body.v_mps, 0.2, kRoundoff);
  EXPECT_NEAR(path.odometry(time_at(0.75))->twist_body.w_radps, 0.4, kRoundoff);
  EXPECT_FALSE(path.odometry(time_at(-0.01)).has_value());
  EXPECT_FALSE(path.odometry(time_at(1.01)).has_value());
}

}  // namespace
}  // namespace panoptes
