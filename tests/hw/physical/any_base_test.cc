// SPDX-License-Identifier: BSD-3-Clause
// A robot on a base that is no Pioneer.
#include <memory>
#include <string>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "hw/physical/physical_robot.h"
#include "tests/hw/physical/fake_base.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kRoundoff = 1e-12;
constexpr Duration kLong = std::chrono::seconds(60);  // nobody waits for it

struct OnAnyBase {
  OnAnyBase() {
    auto made = std::make_unique<FakeBase>();
    base = made.get();
    base->report({{time_at(0.01), {1, 2, 0.5}, {}, 7}});
    robot = std::make_unique<PhysicalRobot>(std::move(made), nullptr);
  }

  FakeBase* base = nullptr;
  std::unique_ptr<PhysicalRobot> robot;
};

std::string error_of(Robot& robot) {
  try {
    robot.observe(robot.now() + kLong);
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "";
}

TEST(AnyBase, TellsARobotItsOdometryAndHealthByEveryReport) {
  OnAnyBase on;
  const Observation first = on.robot->observe(on.robot->now() + kLong);
  EXPECT_EQ(first.stamp, time_at(0.01));
  EXPECT_NEAR(first.odometry.T_odom_body.position().norm(), 0, kRoundoff);
  const Twist2 twist{0.5, 0.4};
  on.base->report({{time_at(0.05), Pose2{1, 2, 0.5} * exp_twist(twist, 0.04), twist, 7}});
  on.base->held_by = "a hand";
  const Observation seen = on.robot->observe(on.robot->now() + kLong);
  EXPECT_EQ(seen.stamp, time_at(0.05));
  EXPECT_NEAR(seen.odometry.T_odom_body.x_m, exp_twist(twist, 0.04).x_m, kRoundoff);
  EXPECT_NEAR(seen.odometry.T_odom_body.theta_rad, 0.4 * 0.04, kRoundoff);
  EXPECT_TRUE(seen.health.bumper_pressed);
  EXPECT_FALSE(seen.health.motors_enabled);
  EXPECT_EQ(seen.health.held_by, "a hand");
}

TEST(AnyBase, StatesTheTimingOfTheRobot) {
  const Timing timing = OnAnyBase().robot->timing();
  EXPECT_EQ(timing.period, FakeBase::kPeriod);
  EXPECT_EQ(timing.worst_latency, FakeBase::kRoundTrip + 2 * FakeBase::kPeriod);
}

TEST(AnyBase, HearsWhatTheRobotIsAskedFor) {
  OnAnyBase on;
  on.robot->drive({0.1, 0}, milliseconds(400));
  on.robot->stop();
  on.robot->emergency_stop();
  on.robot->acknowledge();
  EXPECT_THAT(on.base->asked, ElementsAre("drive", "stop", "emergency_stop", "acknowledge"));
  EXPECT_EQ(on.robot->devices().at("base").at("drops"), 3);
  EXPECT_EQ(on.robot->devices().at("base").at("epoch"), 7);
}

TEST(AnyBase, EndsARobotThatItIsLostTo) {
  OnAnyBase on;
  on.base->fail("ros:/base: gone");
  EXPECT_EQ(error_of(*on.robot), "ros:/base: gone");
}

TEST(AnyBase, IsStoppedWhereItIsNotKnownHowItCameToWhereItIs) {
  OnAnyBase on;
  on.base->report({{time_at(0.05), {}, {}, 8}});
  EXPECT_THAT(error_of(*on.robot), HasSubstr("lost count of its way"));
  EXPECT_THAT(on.base->asked, ElementsAre("stop"));
}

}  // namespace
}  // namespace panoptes::hw
