// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/command_monitor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "core/base/rng.h"

namespace panoptes::hw {
namespace {

/// A robot that is sent commands now and hears them later, or does not.
struct CommandedRobot {
  explicit CommandedRobot(double braking = 1) : braking_(braking) {}

  /// When it is found out, after so long; never: infinite.
  double until_found(const Twist2& twist_body, double during_s, double heard_after_s) {
    const double begun_s = now_s_;
    monitor.commanded(time_at(now_s_), twist_body);
    for (; now_s_ < begun_s + during_s; now_s_ += 0.1) {
      if (now_s_ - begun_s >= heard_after_s) {
        heard_ = twist_body;
      }
      const auto towards = [&](double from, double wanted, double accel) {
        return from + std::clamp(wanted - from, -0.1 * accel * braking_, 0.1 * accel * braking_);
      };
      is = {towards(is.v_mps, heard_.v_mps, body.max_accel_mps2),
            towards(is.w_radps, heard_.w_radps, body.max_turn_accel_radps2)};
      if (monitor.disobeys(time_at(now_s_), is)) {
        return now_s_ - begun_s;
      }
    }
    return std::numeric_limits<double>::infinity();
  }

  Body body;
  CommandMonitor monitor{body};
  Twist2 is;

 private:
  double braking_;
  double now_s_ = 0;
  Twist2 heard_;
};

constexpr double kNever = std::numeric_limits<double>::infinity();

TEST(CommandMonitor, FindsARobotThatGoesOn) {
  for (const Twist2& twist :
       {Twist2{0.3, 0}, Twist2{-0.3, 0}, Twist2{0, 1}, Twist2{0.1, 0}, Twist2{0.6, -1.5}}) {
    CommandedRobot robot;
    EXPECT_EQ(robot.until_found(twist, 4, 0.1), kNever);
    EXPECT_LT(robot.until_found({}, 4, kNever), 0.85);
  }
}

TEST(CommandMonitor, FindsARobotThatSlowsNoMoreThanAFraction) {
  CommandedRobot robot;
  robot.until_found({0.5, 0}, 4, 0.1);
  EXPECT_LT(robot.until_found({0.1, 0}, 4, kNever), 0.85);
  CommandedRobot reverse;
  reverse.until_found({0.3, 0}, 4, 0.1);
  EXPECT_LT(reverse.until_found({-0.3, 0}, 4, kNever), 0.85);
}

// Braking at half of what is believed, hearing everything up to 0.3 s late.
TEST(CommandMonitor, LeavesARobotInPeaceThatFollowsItsCommands) {
  Rng rng(2);
  for (const double braking : {1.0, 0.5}) {
    CommandedRobot robot(braking);
    for (int i = 0; i < 500; ++i) {
      const Twist2 twist{rng.uniform(-0.3, 0.6), rng.uniform(-1.5, 1.5)};
      EXPECT_EQ(robot.until_found(i % 4 == 0 ? Twist2{} : twist, rng.uniform(0.4, 3),
                                  rng.uniform(0, 0.3)),
                kNever)
          << i;
    }
  }
}

TEST(CommandMonitor, AllowsForALinksLatency) {
  CommandedRobot robot;
  robot.monitor.allow(std::chrono::milliseconds(600));
  robot.until_found({0.5, 0}, 4, 0.6);
  EXPECT_EQ(robot.until_found({}, 4, 0.6), kNever);
}

// Commanded otherwise and back within a silence of five lost reports, it brakes a second time.
TEST(CommandMonitor, DoesNotDoubtThroughASilence) {
  CommandMonitor monitor{Body()};
  monitor.commanded(time_at(0), {0.5, 0});
  EXPECT_FALSE(monitor.disobeys(time_at(1), {0.5, 0}));
  monitor.commanded(time_at(1), {-0.1, 0});
  EXPECT_FALSE(monitor.disobeys(time_at(1.11), {0.44, 0}));
  EXPECT_TRUE(monitor.doubtful());
  monitor.commanded(time_at(1.2), {0.5, 0});
  monitor.commanded(time_at(1.6), {});
  EXPECT_FALSE(monitor.disobeys(time_at(1.71), {0.44, 0}));
}

// It brakes as fast as it can, and is commanded to go slower and slower.
TEST(CommandMonitor, LeavesARobotInPeaceThatIsCommandedLessAndLess) {
  Body body;
  body.max_accel_mps2 = 0.6;
  CommandMonitor monitor{body};
  monitor.commanded(time_at(0), {0.541, 0});
  const std::vector<std::pair<double, double>> commands{
      {0.255, 0.276}, {0.455, 0.119}, {0.795, -0.06}};
  std::size_t next = 0;
  for (const double at_s : {0.285, 0.385, 0.485, 0.585, 0.685, 0.785, 0.985}) {
    for (; next < commands.size() && commands[next].first <= at_s; ++next) {
      monitor.commanded(time_at(commands[next].first), {commands[next].second, 0});
    }
    EXPECT_FALSE(monitor.disobeys(time_at(at_s), {0.541 - 0.6 * (at_s - 0.262), 0})) << at_s;
  }
}

// Reports of one burst, the first of which are of before the motors were on.
TEST(CommandMonitor, RemembersWhatReportsThatComeLateAreOf) {
  CommandMonitor monitor{Body()};
  monitor.allow(std::chrono::milliseconds(500));
  monitor.commanded(time_at(0), {-0.3, 0});
  monitor.commanded(time_at(0.6), {});
  monitor.forget();
  for (int i = 0; i < 7; ++i) {
    EXPECT_FALSE(monitor.disobeys(time_at(0.3 + 0.1 * i), {-0.3, 0})) << i;
  }
}

TEST(CommandMonitor, LetsWheelsBeSlowerThanCommanded) {
  CommandMonitor monitor{Body()};
  monitor.commanded(Time{}, {0.5, 1});
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(monitor.disobeys(time_at(0.1 * i), {0.1, 0.2}));
  }
}

}  // namespace
}  // namespace panoptes::hw
