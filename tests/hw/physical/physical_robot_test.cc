// SPDX-License-Identifier: BSD-3-Clause
#include "hw/physical/physical_robot.h"

#include <cstdlib>
#include <iterator>
#include <map>
#include <memory>
#include <string>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "hw/standin/cameras.h"
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
                 StandInLink::Delay delay = {}, bool has_cameras = true) {
    auto rolling = std::make_unique<RollingRobot>(body);
    behind = rolling.get();
    auto cameras = has_cameras ? std::make_unique<StandInCameras>() : nullptr;
    auto made =
        std::make_unique<StandInLink>(std::move(rolling), body, StandInOptions(), body, wire,
                                      [this, to = cameras.get()](const Observation& seen) {
                                        own[seen.stamp] = seen.odometry;
                                        if (to != nullptr) {
                                          to->add(seen);
                                        }
                                      });
    link = made.get();
    link->delay(std::move(delay));
    connect(*link);
    robot =
        std::make_unique<PhysicalRobot>(std::move(made), std::move(cameras),
                                        BaseRamp{body.max_accel_mps2, body.max_turn_accel_radps2,
                                                 body.max_speed_mps, body.max_turn_radps});
  }

  /// By the stand-in's own wheels; empty where no two sets are around.
  std::optional<Pose2> own_at(Time at) const {
    const auto after = own.lower_bound(at);
    if (after == own.end() || after == own.begin()) {
      return std::nullopt;
    }
    const auto before = std::prev(after);
    const double share = to_seconds(at - before->first) / to_seconds(after->first - before->first);
    const Pose2 T_before_after = before->second.T_odom_body.inverse() * after->second.T_odom_body;
    return before->second.T_odom_body * Pose2{share * T_before_after.x_m,
                                              share * T_before_after.y_m,
                                              share * T_before_after.theta_rad};
  }

  RollingRobot* behind = nullptr;
  StandInLink* link = nullptr;
  std::map<Time, Odometry> own;
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

/// Five minutes of driving about on a link that holds bytes up, or of a program that is frozen
/// again and again. On other seeds: PANOPTES_LINK_SEED=7 hw_physical_test
/// --gtest_filter='*HeldUpLinks*'
class HeldUpLinks : public testing::TestWithParam<HeldUp> {
 protected:
  static constexpr double kNear_m = 0.05;
  static constexpr double kDrive_s = 300;

  explicit HeldUpLinks(bool has_cameras = true)
      : wired_(
            GetParam().wire, {}, [this](Time at, bool) { return held_up(at); }, has_cameras) {
    wired_.link->damage([this](Bytes bytes, bool to_robot) {
      const bool lost = !to_robot && bytes.size() > 20 && losing_.uniform(0, 1) < GetParam().lost;
      return lost ? Bytes() : bytes;
    });
  }

  Observation step(double otherwise, Duration deadline) {
    if (rng_.uniform(0, 1) < otherwise) {
      command_ = {rng_.uniform(-0.2, 0.6), rng_.uniform(-1.5, 1.5)};
    }
    wired_.robot->drive(command_, kValid);
    return wired_.robot->observe(wired_.robot->now() + deadline);
  }

 private:
  static std::uint64_t seed() {
    const char* given = std::getenv("PANOPTES_LINK_SEED");
    return given == nullptr ? 21 : std::stoull(given);
  }

  Duration held_up(Time at) {
    const HeldUp& how = GetParam();
    while (how.freeze_s > 0 && at >= next_freeze_) {
      thaw_ = next_freeze_ + from_seconds(how.freeze_s);
      next_freeze_ += from_seconds(how.every_s * rng_.uniform(0.7, 1.3));
    }
    const Duration frozen = std::max(Duration::zero(), thaw_ - at);
    return frozen + from_seconds(how.jitter_s * rng_.uniform(0, 1));
  }

  Rng rng_{seed()};
  Rng losing_{seed() + 1};
  Time thaw_{};
  Time next_freeze_ = time_at(GetParam().every_s);
  Twist2 command_;

 protected:
  Wired wired_;
};

TEST_P(HeldUpLinks, NeverPutTheRobotFarFromWhereItsOwnWheelsDo) {
  std::optional<Pose2> T_own_odom;
  double worst_m = 0;
  double told_m = 0;
  double driven_m = 0;
  std::optional<Pose2> before;
  std::optional<Pose2> own_before;
  int pictures = 0;
  while (wired_.robot->now() < time_at(kDrive_s)) {
    const Observation seen = step(0.05, milliseconds(500));
    if (seen.pictures.empty()) {
      continue;
    }
    const Odometry& own = wired_.own.at(seen.stamp);
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

class HeldUpLinksWithoutCameras : public HeldUpLinks {
 protected:
  HeldUpLinksWithoutCameras() : HeldUpLinks(false) {}
};

// Asked more often than reports come.
TEST_P(HeldUpLinksWithoutCameras, TellWhereTheRobotIsBetweenReports) {
  std::map<Time, Pose2> told;
  while (wired_.robot->now() < time_at(kDrive_s)) {
    const Observation seen = step(0.03, milliseconds(30));
    EXPECT_TRUE(told.empty() || seen.stamp >= told.rbegin()->first);
    told[seen.stamp] = seen.odometry.T_odom_body;
  }
  EXPECT_GT(told.size(), 2900U);
  std::optional<Pose2> T_own_odom;
  double worst_m = 0;
  for (const auto& [stamp, T_odom_body] : told) {
    if (const auto own = wired_.own_at(stamp)) {
      T_own_odom = T_own_odom.value_or(*own * T_odom_body.inverse());
      worst_m =
          std::max(worst_m, ((*T_own_odom * T_odom_body).position() - own->position()).norm());
    }
  }
  EXPECT_LT(worst_m, kNear_m);
  RecordProperty("worst_mm", std::to_string(1e3 * worst_m));
}

const auto kHeldUp =
    testing::Values(HeldUp{"FrozenOnPty", StandInLink::Wire::kPty, 0, 0.15, 0.5},
                    HeldUp{"JitterOnTcp", StandInLink::Wire::kTcp, 0.25, 0, 1},
                    HeldUp{"LongJitterOnTcp", StandInLink::Wire::kTcp, 0.3, 0, 1},
                    HeldUp{"FrozenLongOnTcp", StandInLink::Wire::kTcp, 0, 0.3, 1.1},
                    HeldUp{"BothOnTcp", StandInLink::Wire::kTcp, 0.1, 0.2, 0.7},
                    HeldUp{"BothLongOnTcp", StandInLink::Wire::kTcp, 0.3, 0.3, 1.1},
                    HeldUp{"BothLongOnPty", StandInLink::Wire::kPty, 0.3, 0.3, 1.1},
                    HeldUp{"LostOnTcp", StandInLink::Wire::kTcp, 0, 0, 1, 0.1},
                    HeldUp{"LostOnMemory", StandInLink::Wire::kMemory, 0, 0, 1, 0.1});
std::string name_of(const testing::TestParamInfo<HeldUp>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(PhysicalRobot, HeldUpLinks, kHeldUp, name_of);
INSTANTIATE_TEST_SUITE_P(PhysicalRobot, HeldUpLinksWithoutCameras, kHeldUp, name_of);

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
