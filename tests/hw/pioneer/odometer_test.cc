// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/odometer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "core/base/rng.h"

namespace panoptes::hw {
namespace {

using Verdict = PioneerOdometer::Verdict;

constexpr double kRounding_m = 1.1e-3;                         // a count in each of x and y
constexpr double kRounding_rad = 2 * std::numbers::pi / 4096;  // a count of heading
constexpr double kCycle_s = 0.1;

const PioneerModel& model() { return *find_model("p3dx-sh"); }

// What a controller whose counters have so many bits reports of a pose.
Sip report(const Pose2& T_counter_body, const Twist2& twist_body, int bits = 16) {
  const auto count = [](double value, double unit) {
    return static_cast<std::int64_t>(std::llround(value / unit));
  };
  Sip sip;
  const std::int64_t mask = (1 << bits) - 1;
  sip.x = static_cast<std::uint16_t>(count(T_counter_body.x_m, model().distance_m) & mask);
  sip.y = static_cast<std::uint16_t>(count(T_counter_body.y_m, model().distance_m) & mask);
  sip.theta =
      static_cast<std::int16_t>(count(wrap_angle(T_counter_body.theta_rad), model().angle_rad));
  const double half_mps = twist_body.w_radps / model().turn_rad_per_m;
  sip.left = static_cast<std::int16_t>(count(twist_body.v_mps - half_mps, model().speed_mps));
  sip.right = static_cast<std::int16_t>(count(twist_body.v_mps + half_mps, model().speed_mps));
  return sip;
}

struct Drive {
  PioneerOdometer odometer{model()};
  Pose2 T_counter_body;
  Pose2 T_start_body;
  Time now{};
  int bits = 16;

  Verdict go(const Twist2& twist_body, int cycles = 1, int lost = 0) {
    Verdict verdict = Verdict::kAccepted;
    for (int i = 0; i < cycles; ++i) {
      const Pose2 step = exp_twist(twist_body, kCycle_s);
      T_counter_body = T_counter_body * step;
      T_start_body = T_start_body * step;
      now += from_seconds(kCycle_s);
      if (i >= lost) {
        verdict = odometer.add(now, report(T_counter_body, twist_body, bits),
                               {std::abs(twist_body.v_mps), std::abs(twist_body.w_radps)});
      }
    }
    return verdict;
  }
};

void expect_true(const Drive& drive) {
  const Pose2& is = drive.odometer.T_odom_body();
  EXPECT_NEAR(is.x_m, drive.T_start_body.x_m, kRounding_m);
  EXPECT_NEAR(is.y_m, drive.T_start_body.y_m, kRounding_m);
  EXPECT_NEAR(wrap_angle(is.theta_rad - drive.T_start_body.theta_rad), 0, kRounding_rad);
}

TEST(PioneerOdometer, BeginsAtItsOriginWhereverTheCountersStand) {
  Drive drive;
  drive.T_counter_body = {12.345, -3, 0};
  EXPECT_EQ(drive.odometer.add(drive.now, report(drive.T_counter_body, {}), {}),
            Verdict::kAccepted);
  expect_true(drive);
  drive.go({0.3, 0.1}, 20);
  expect_true(drive);
  EXPECT_EQ(drive.odometer.epoch(), 0);
}

class Wraps : public testing::TestWithParam<int> {};

// 10 km straight, back and in circles.
TEST_P(Wraps, AreExactOverTenKilometres) {
  Drive drive;
  drive.bits = GetParam();
  drive.odometer.add(drive.now, report({}, {}, drive.bits), {});
  for (const Twist2& twist :
       {Twist2{1.6, 0}, Twist2{-1.6, 0}, Twist2{0.8, deg_to_rad(20)}, Twist2{0, deg_to_rad(90)}}) {
    drive.go({}, 2);
    const int cycles = twist.v_mps == 0 ? 4000 : 32'000;
    for (int i = 0; i < cycles; i += 100) {
      ASSERT_EQ(drive.go(twist, 100), Verdict::kAccepted) << i;
    }
    drive.go({}, 2);
    expect_true(drive);
  }
  EXPECT_EQ(drive.odometer.epoch(), 0);
}

INSTANTIATE_TEST_SUITE_P(Bits, Wraps, testing::Values(12, 15, 16));

TEST(PioneerOdometer, IsExactOverTenLostReportsAtTopSpeed) {
  Drive drive;
  drive.odometer.add(drive.now, report({}, {}), {});
  drive.go({1.6, 0}, 30);
  for (int k = 0; k < 50; ++k) {
    ASSERT_EQ(drive.go({1.6, 0}, 11, 10), Verdict::kAccepted);
    expect_true(drive);
  }
}

TEST(PioneerOdometer, TellsOfALeapItCannotKnow) {
  Drive drive;
  drive.odometer.add(drive.now, report({}, {}), {});
  drive.go({1.6, 0}, 30);
  const Pose2 before = drive.odometer.T_odom_body();
  EXPECT_EQ(drive.go({1.6, 0}, 15, 14), Verdict::kDiscontinuity);
  EXPECT_EQ(drive.odometer.epoch(), 1);
  EXPECT_EQ(drive.odometer.T_odom_body().x_m, before.x_m);
  drive.go({1.6, 0}, 10);
  EXPECT_NEAR(drive.odometer.T_odom_body().x_m, before.x_m + 1.6, kRounding_m);
}

// A damaged report that passes the checksum.
TEST(PioneerOdometer, RejectsWhatIsOutsideOfTheGateAndMendsWhatIsInside) {
  Drive drive;
  drive.odometer.add(drive.now, report({}, {}), {});
  drive.go({0.5, 0}, 10);
  const Time soon = drive.now + from_seconds(0.05);
  const Pose2 ahead = drive.T_counter_body * Pose2{0.025, 0, 0};
  const Pose2 too_far{ahead.x_m + 0.087, ahead.y_m, 0};  // the gate: 60 mm + 0.5 * 50 mm, a count
  EXPECT_EQ(drive.odometer.add(soon, report(too_far, {0.5, 0}), {0.5, 0}), Verdict::kImplausible);
  EXPECT_EQ(drive.odometer.add(soon, report(ahead * Pose2{0, 0, deg_to_rad(5.2)}, {0.5, 0}), {}),
            Verdict::kImplausible);
  EXPECT_EQ(drive.odometer.add(soon, report(ahead, {2.5, 0}), {0.5, 0}), Verdict::kImplausible);
  const Pose2 near{ahead.x_m, ahead.y_m + 0.08, 0};
  EXPECT_EQ(drive.odometer.add(soon, report(near, {0.5, 0}), {0.5, 0}), Verdict::kAccepted);
  EXPECT_EQ(drive.go({0.5, 0}), Verdict::kAccepted);
  expect_true(drive);
  EXPECT_EQ(drive.odometer.epoch(), 0);
}

TEST(PioneerOdometer, BelievesThreeThatAgreeOnAnotherPlaceAsANewEpoch) {
  Drive drive;
  drive.odometer.add(drive.now, report({}, {}), {});
  drive.go({0.3, 0}, 10);
  const Pose2 before = drive.odometer.T_odom_body();
  drive.T_counter_body = {0.9, 0.8, 1};  // somebody zeroed or moved its counters
  EXPECT_EQ(drive.go({0, 0}), Verdict::kImplausible);
  EXPECT_EQ(drive.go({0, 0}), Verdict::kImplausible);
  EXPECT_EQ(drive.go({0, 0}), Verdict::kDiscontinuity);
  EXPECT_EQ(drive.odometer.epoch(), 1);
  EXPECT_NEAR(drive.odometer.T_odom_body().x_m, before.x_m, 1e-12);
  EXPECT_EQ(drive.go({0.3, 0}), Verdict::kAccepted);
}

TEST(PioneerOdometer, RestartsWhereItIs) {
  Drive drive;
  drive.odometer.add(drive.now, report({}, {}), {});
  drive.go({0.3, 0.2}, 30);
  const Pose2 before = drive.odometer.T_odom_body();
  drive.odometer.restart(model());
  EXPECT_EQ(drive.odometer.epoch(), 1);
  EXPECT_FALSE(drive.odometer.last());
  EXPECT_EQ(drive.odometer.add(drive.now, report({}, {}), {}), Verdict::kAccepted);
  EXPECT_NEAR(drive.odometer.T_odom_body().theta_rad, before.theta_rad, 1e-12);
  EXPECT_NEAR(drive.odometer.T_odom_body().x_m, before.x_m, 1e-12);
}

// Random words in random reports: whatever is accepted is within the gate of the truth, and the
// next right report mends it.
TEST(PioneerOdometer, NeverLeapsWhateverIsReported) {
  Rng rng(3);
  Drive drive;
  drive.odometer.add(drive.now, report({}, {}), {});
  int rejected = 0;
  Twist2 twist;
  for (int i = 0; i < 20'000; ++i) {
    twist.v_mps = std::clamp(twist.v_mps + rng.uniform(-0.06, 0.06), -0.6, 0.6);
    twist.w_radps = std::clamp(twist.w_radps + rng.uniform(-0.3, 0.3), -1.0, 1.0);
    ASSERT_EQ(drive.go(twist, 3), Verdict::kAccepted) << i;
    ASSERT_NEAR((drive.odometer.T_odom_body().position() - drive.T_start_body.position()).norm(), 0,
                2 * kRounding_m);
    Sip damaged = report(drive.T_counter_body, twist);
    damaged.x = static_cast<std::uint16_t>(rng.uniform(0, 65535));
    damaged.theta = static_cast<std::int16_t>(rng.uniform(-2048, 2048));
    drive.now += from_seconds(1e-3);
    const Verdict verdict = drive.odometer.add(drive.now, damaged, {0.6, 1});
    ASSERT_NE(verdict, Verdict::kDiscontinuity);
    rejected += verdict == Verdict::kImplausible ? 1 : 0;
    ASSERT_LT((drive.odometer.T_odom_body().position() - drive.T_start_body.position()).norm(),
              0.06 + 0.6e-3 + 3 * kRounding_m);
  }
  EXPECT_GT(rejected, 19'000);
}

}  // namespace
}  // namespace panoptes::hw
