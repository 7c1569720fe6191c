// SPDX-License-Identifier: BSD-3-Clause
#include "hw/physical/physical_robot.h"

#include <cstdlib>
#include <deque>
#include <map>
#include <memory>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "hw/standin/link.h"
#include "tests/support/rolling_robot.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;

constexpr double kOdometry_m = 0.002;
const double kOdometry_rad = deg_to_rad(0.1);
constexpr Duration kValid = milliseconds(400);

/// A stand-in's robot seen over the wire, and what the stand-in's own wheels said of each set.
struct Wired {
  explicit Wired(StandInLink::Wire wire = StandInLink::Wire::kPty, const Body& body = {},
                 StandInLink::Delay delay = {}) {
    auto rolling = std::make_unique<RollingRobot>(body);
    behind = rolling.get();
    auto made = std::make_unique<StandInLink>(std::move(rolling), body, StandInOptions(), body,
                                              wire, [this](const Observation& seen) {
                                                own[seen.stamp] = seen.odometry;
                                                sets.push_back({seen.stamp, seen.pictures});
                                              });
    link = made.get();
    link->delay(std::move(delay));
    connect(*link);
    sets.clear();
    const auto next = [this]() -> std::optional<CameraSet> {
      if (sets.empty()) {
        return std::nullopt;
      }
      CameraSet set = sets.front();
      sets.pop_front();
      return set;
    };
    robot =
        std::make_unique<PhysicalRobot>(std::move(made), next,
                                        BaseRamp{body.max_accel_mps2, body.max_turn_accel_radps2,
                                                 body.max_speed_mps, body.max_turn_radps});
  }

  RollingRobot* behind = nullptr;
  StandInLink* link = nullptr;
  std::map<Time, Odometry> own;
  std::deque<CameraSet> sets;
  std::unique_ptr<PhysicalRobot> robot;
};

TEST(PhysicalRobot, KnowsItsOdometryAtThePicturesInstants) {
  Wired wired;
  const Twist2 steady{0.5, deg_to_rad(60)};
  const auto command = [&] { wired.robot->drive(steady, kValid); };
  std::optional<Pose2> T_own_odom;
  int checked = 0;
  int extrapolated = 0;
  double worst_m = 0;
  double worst_rad = 0;
  while (wired.robot->now() < time_at(30)) {
    command();
    const Observation seen = wired.robot->observe(wired.robot->now() + std::chrono::seconds(1));
    ASSERT_EQ(seen.pictures.size(), 1U);
    const Odometry& own = wired.own.at(seen.stamp);
    if (!T_own_odom) {
      T_own_odom = own.T_odom_body * seen.odometry.T_odom_body.inverse();
    }
    const bool is_steady = std::abs(own.twist_body.v_mps - steady.v_mps) < 1e-9 &&
                           std::abs(own.twist_body.w_radps - steady.w_radps) < 1e-9;
    if (is_steady && seen.stamp > time_at(3)) {
      const Pose2 error = own.T_odom_body.inverse() * (*T_own_odom * seen.odometry.T_odom_body);
      worst_m = std::max(worst_m, error.position().norm());
      worst_rad = std::max(worst_rad, std::abs(error.theta_rad));
      ++checked;
      extrapolated += seen.odometry.extrapolated ? 1 : 0;
    }
  }
  EXPECT_GT(checked, 350);
  EXPECT_GT(extrapolated, 100);
  EXPECT_LT(worst_m, kOdometry_m);
  EXPECT_LT(worst_rad, kOdometry_rad);
  RecordProperty("worst_mm", std::to_string(1e3 * worst_m));
  RecordProperty("worst_deg", std::to_string(rad_to_deg(worst_rad)));
}

// As a navigator drives: a new command with every set of pictures, and wheels whose velocity is
// known as the mean of the last 100 ms.
TEST(PhysicalRobot, KnowsItsOdometryWhileItSpeedsUpAndTurns) {
  Wired wired;
  wired.behind->reports_mean = true;
  Rng rng(4);
  Twist2 command;
  std::optional<Pose2> T_own_odom;
  double sum_m2 = 0;
  double sum_rad2 = 0;
  double worst_m = 0;
  double worst_rad = 0;
  int count = 0;
  while (wired.robot->now() < time_at(120)) {
    if (rng.uniform(0, 1) < 0.15) {
      command = {rng.uniform(0, 0.6), rng.uniform(-1.5, 1.5)};
    }
    wired.robot->drive(command, kValid);
    const Observation seen = wired.robot->observe(wired.robot->now() + std::chrono::seconds(1));
    const Odometry& own = wired.own.at(seen.stamp);
    if (!T_own_odom) {
      T_own_odom = own.T_odom_body * seen.odometry.T_odom_body.inverse();
    }
    const Pose2 error = own.T_odom_body.inverse() * (*T_own_odom * seen.odometry.T_odom_body);
    if (seen.odometry.extrapolated) {
      sum_m2 += error.position().squaredNorm();
      sum_rad2 += error.theta_rad * error.theta_rad;
      worst_m = std::max(worst_m, error.position().norm());
      worst_rad = std::max(worst_rad, std::abs(error.theta_rad));
      ++count;
    }
  }
  EXPECT_GT(count, 600);
  EXPECT_LT(std::sqrt(sum_m2 / count), 0.002);
  EXPECT_LT(std::sqrt(sum_rad2 / count), deg_to_rad(0.15));
  RecordProperty("rms_mm", std::to_string(1e3 * std::sqrt(sum_m2 / count)));
  RecordProperty("rms_deg", std::to_string(rad_to_deg(std::sqrt(sum_rad2 / count))));
  RecordProperty("worst_mm", std::to_string(1e3 * worst_m));
  RecordProperty("worst_deg", std::to_string(rad_to_deg(worst_rad)));
}

struct HeldUp {
  const char* name;
  StandInLink::Wire wire;
  double jitter_s;  // at most, both ways
  double freeze_s;  // of the program,
  double every_s;   // once in so long
  double lost = 0;  // share of the reports
};

class HeldUpLinks : public testing::TestWithParam<HeldUp> {};

// Five minutes on a link that holds bytes up, or of a program that is frozen again and again. On
// other seeds: PANOPTES_LINK_SEED=7 hw_physical_test --gtest_filter='*HeldUpLinks*'
TEST_P(HeldUpLinks, NeverPutTheRobotFarFromWhereItsOwnWheelsDo) {
  const HeldUp& how = GetParam();
  constexpr double kNear_m = 0.05;
  const char* seed = std::getenv("PANOPTES_LINK_SEED");
  Rng rng(seed == nullptr ? 21 : std::stoull(seed));
  Time thaw{};
  Time next_freeze = time_at(how.every_s);
  Wired wired(how.wire, {}, [&](Time at, bool) {
    while (how.freeze_s > 0 && at >= next_freeze) {
      thaw = next_freeze + from_seconds(how.freeze_s);
      next_freeze += from_seconds(how.every_s * rng.uniform(0.7, 1.3));
    }
    const Duration frozen = std::max(Duration::zero(), thaw - at);
    return frozen + from_seconds(how.jitter_s * rng.uniform(0, 1));
  });
  Rng losing(22);
  wired.link->damage([&](Bytes bytes, bool to_robot) {
    const bool lost = !to_robot && bytes.size() > 20 && losing.uniform(0, 1) < how.lost;
    return lost ? Bytes() : bytes;
  });
  Twist2 command;
  std::optional<Pose2> T_own_odom;
  double worst_m = 0;
  double told_m = 0;
  double driven_m = 0;
  std::optional<Pose2> before;
  std::optional<Pose2> own_before;
  int pictures = 0;
  while (wired.robot->now() < time_at(300)) {
    if (rng.uniform(0, 1) < 0.05) {
      command = {rng.uniform(-0.2, 0.6), rng.uniform(-1.5, 1.5)};
    }
    wired.robot->drive(command, kValid);
    const Observation seen = wired.robot->observe(wired.robot->now() + milliseconds(500));
    if (seen.pictures.empty()) {
      continue;
    }
    const Odometry& own = wired.own.at(seen.stamp);
    if (!T_own_odom) {
      T_own_odom = own.T_odom_body * seen.odometry.T_odom_body.inverse();
    }
    const Pose2 is = *T_own_odom * seen.odometry.T_odom_body;
    worst_m = std::max(worst_m, (is.position() - own.T_odom_body.position()).norm());
    told_m += before ? (is.position() - before->position()).norm() : 0;
    driven_m += own_before ? (own.T_odom_body.position() - own_before->position()).norm() : 0;
    before = is;
    own_before = own.T_odom_body;
    ++pictures;
  }
  EXPECT_GT(pictures, 4000);
  EXPECT_GT(driven_m, 40);
  EXPECT_LT(worst_m, kNear_m);
  EXPECT_LT(told_m, 1.1 * driven_m);
  RecordProperty("worst_mm", std::to_string(1e3 * worst_m));
  RecordProperty("told_m", std::to_string(told_m));
  RecordProperty("driven_m", std::to_string(driven_m));
}

INSTANTIATE_TEST_SUITE_P(
    PhysicalRobot, HeldUpLinks,
    testing::Values(HeldUp{"FrozenOnPty", StandInLink::Wire::kPty, 0, 0.15, 0.5},
                    HeldUp{"JitterOnTcp", StandInLink::Wire::kTcp, 0.25, 0, 1},
                    HeldUp{"LongJitterOnTcp", StandInLink::Wire::kTcp, 0.3, 0, 1},
                    HeldUp{"FrozenLongOnTcp", StandInLink::Wire::kTcp, 0, 0.3, 1.1},
                    HeldUp{"BothOnTcp", StandInLink::Wire::kTcp, 0.1, 0.2, 0.7},
                    HeldUp{"BothLongOnTcp", StandInLink::Wire::kTcp, 0.3, 0.3, 1.1},
                    HeldUp{"BothLongOnPty", StandInLink::Wire::kPty, 0.3, 0.3, 1.1},
                    HeldUp{"LostOnTcp", StandInLink::Wire::kTcp, 0, 0, 1, 0.1},
                    HeldUp{"LostOnMemory", StandInLink::Wire::kMemory, 0, 0, 1, 0.1}),
    [](const auto& one) { return one.param.name; });

TEST(PhysicalRobot, DeliversEverySetOnceAndMeetsItsDeadlines) {
  Wired wired;
  Time last{};
  int sets = 0;
  while (wired.robot->now() < time_at(5)) {
    const Time deadline = wired.robot->now() + milliseconds(30);
    const Observation seen = wired.robot->observe(deadline);
    EXPECT_LE(wired.robot->now(), deadline + milliseconds(9));  // a tick of the simulated world
    if (!seen.pictures.empty()) {
      EXPECT_GT(seen.stamp, last);
      last = seen.stamp;
      ++sets;
    }
  }
  EXPECT_GE(sets, 60);
  EXPECT_EQ(wired.robot->devices().at("cameras").at("sets"), sets);
}

TEST(PhysicalRobot, SwitchesItsMotorsOnWhenItIsToldToMove) {
  Wired wired;
  const auto watch = [&](const Twist2& command) {
    Observation seen;
    for (const Time end = wired.robot->now() + std::chrono::seconds(1); wired.robot->now() < end;) {
      wired.robot->drive(command, kValid);
      seen = wired.robot->observe(wired.robot->now() + milliseconds(100));
    }
    return seen.health.motors_enabled;
  };
  EXPECT_FALSE(watch({}));
  EXPECT_TRUE(watch({0.1, 0}));
  EXPECT_TRUE(watch({}));
}

TEST(PhysicalRobot, HasNoTruthButThatOfARobotBehindIt) {
  Wired wired;
  EXPECT_FALSE(wired.robot->truth());
  EXPECT_FALSE(wired.robot->start_unix_ns());
}

TEST(PhysicalRobot, EndsWhenTheBaseIsLost) {
  Wired wired;
  wired.robot->drive({0.3, 0}, kValid);
  wired.robot->observe(wired.robot->now() + std::chrono::seconds(1));
  wired.link->damage([](const Bytes&, bool) { return Bytes(); });
  const Time cut = wired.robot->now();
  EXPECT_THROW(
      {
        while (wired.robot->now() < cut + std::chrono::seconds(3)) {
          wired.robot->observe(wired.robot->now() + milliseconds(100));
        }
      },
      DeviceError);
  EXPECT_LE(wired.robot->now() - cut, std::chrono::seconds(1));
}

TEST(PhysicalRobot, TellsWhatHoldsItAndGoesOnWhenItIsAcknowledged) {
  Wired wired;
  const auto drive_for = [&](double seconds) {
    Observation seen;
    for (const Time end = wired.robot->now() + from_seconds(seconds); wired.robot->now() < end;) {
      wired.robot->drive({0.3, 0}, kValid);
      seen = wired.robot->observe(wired.robot->now() + milliseconds(100));
    }
    return seen;
  };
  EXPECT_EQ(drive_for(1).health.held_by, "");
  wired.behind->pressed_rad = {0.1};
  const Observation held = drive_for(1);
  EXPECT_TRUE(held.health.bumper_pressed);
  EXPECT_THAT(held.health.held_by, testing::HasSubstr("front bumper"));
  wired.behind->pressed_rad.clear();
  wired.robot->acknowledge();
  EXPECT_EQ(drive_for(1).health.held_by, "");
  EXPECT_GT(wired.behind->twist.v_mps, 0.2);
  wired.robot->emergency_stop();
  EXPECT_EQ(drive_for(1).health.held_by, "emergency stop");
  EXPECT_EQ(wired.behind->twist.v_mps, 0);
  wired.robot->acknowledge();
  drive_for(1);
  EXPECT_GT(wired.behind->twist.v_mps, 0.2);
}

}  // namespace
}  // namespace panoptes::hw
