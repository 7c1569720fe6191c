// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/encoders.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace panoptes::sim {
namespace {

constexpr double kStep_s = 1.0 / 120;
const WheelError kPerfect{0, 0, 0, 0, 0};

double tick_m(const Body& body) {
  return 2 * std::numbers::pi * body.wheel_radius_m / body.ticks_per_turn;
}

Pose2 reckon(WheelEncoders& encoders, const Body& body, const Twist2& twist, double seconds) {
  DeadReckoning reckoning(body);
  for (int i = 0; i < std::lround(seconds / kStep_s); ++i) {
    encoders.roll(twist.v_mps * kStep_s, twist.w_radps * kStep_s);
    reckoning.add(encoders.ticks(), from_seconds(kStep_s));
  }
  return reckoning.odometry().T_odom_body;
}

TEST(WheelEncoders, WithoutErrorsAreRightToATick) {
  const Body body;
  for (const Twist2 twist : {Twist2{0.4, 0}, Twist2{-0.4, 0.3}, Twist2{0, 1}}) {
    WheelEncoders encoders(kPerfect, body, Rng(1));
    const Pose2 odom = reckon(encoders, body, twist, 5);
    const Pose2 truth = exp_twist(twist, 5);
    // A wheel is off by less than a tick, the heading by less than a tick over the base; a heading
    // off by so much moves the end of the way.
    const double heading_rad = tick_m(body) / body.wheel_base_m;
    EXPECT_NEAR(wrap_angle(odom.theta_rad - truth.theta_rad), 0, heading_rad);
    EXPECT_NEAR((odom.position() - truth.position()).norm(), 0,
                tick_m(body) + heading_rad * std::abs(twist.v_mps) * 5);
  }
}

TEST(WheelEncoders, CountWholeTicks) {
  const Body body;
  WheelEncoders encoders(kPerfect, body, Rng(1));
  encoders.roll(0.9 * tick_m(body), 0);
  EXPECT_EQ(encoders.ticks().left, 0);
  encoders.roll(0.2 * tick_m(body), 0);
  EXPECT_EQ(encoders.ticks().left, 1);
  EXPECT_EQ(encoders.ticks().right, 1);
  encoders.roll(-1.2 * tick_m(body), 0);
  EXPECT_EQ(encoders.ticks().left, -1);
}

// The variance of a wheel's way is noise^2 * way, whatever the steps it is cut into.
TEST(WheelEncoders, NoiseGrowsWithTheRootOfTheWayForAnyStep) {
  const Body body;
  const WheelError only_noise{0.005, 0, 0, 0, 0};
  constexpr int kDraws = 1000;
  constexpr double kDistance_m = 4;
  for (const int steps : {10, 400}) {
    double sum = 0;
    for (int i = 0; i < kDraws; ++i) {
      WheelEncoders encoders(only_noise, body, Rng(static_cast<std::uint64_t>(i)));
      for (int k = 0; k < steps; ++k) {
        encoders.roll(kDistance_m / steps, 0);
      }
      const double distance_m = (static_cast<double>(encoders.ticks().left) + 0.5) * tick_m(body);
      sum += (distance_m - kDistance_m) * (distance_m - kDistance_m);
    }
    const double cut = tick_m(body) * tick_m(body) / 12;  // of whole ticks
    const double expected = 0.005 * 0.005 * kDistance_m + cut;
    const double three_sigma = 3 * expected * std::sqrt(2.0 / kDraws);
    EXPECT_NEAR(sum / kDraws, expected, three_sigma) << steps;
  }
}

TEST(WheelEncoders, DiametersAndBaseDifferByWhatWasAsked) {
  const Body body;
  int left_larger = 0;
  int base_larger = 0;
  constexpr int kSeeds = 64;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Rng rng(static_cast<std::uint64_t>(seed));
    WheelEncoders straight({0, 0.001, 0, 0, 0}, body, rng);
    straight.roll(1000, 0);
    const Ticks motion = straight.ticks();
    const double ratio = static_cast<double>(motion.right) / static_cast<double>(motion.left);
    EXPECT_NEAR(std::abs(ratio - 1), 0.001, 1e-5);  // a tick in 800 000 and second order
    left_larger += ratio > 1 ? 1 : 0;               // a larger wheel turns less

    WheelEncoders turning({0, 0, 0.005, 0, 0}, body, rng);
    turning.roll(0, 1000);
    const double base_m = 2 * static_cast<double>(turning.ticks().right) * tick_m(body) / 1000;
    EXPECT_NEAR(std::abs(base_m / body.wheel_base_m - 1), 0.005, 1e-4);
    base_larger += base_m > body.wheel_base_m ? 1 : 0;
  }
  const double three_sigma = 3 * std::sqrt(kSeeds / 4.0);
  EXPECT_NEAR(left_larger, kSeeds / 2.0, three_sigma);
  EXPECT_NEAR(base_larger, kSeeds / 2.0, three_sigma);
}

TEST(WheelEncoders, SlipIsDrawnOncePerTurn) {
  const Body body;
  WheelEncoders encoders({0, 0, 0, 0.01, 0}, body, Rng(3));
  const auto felt = [&](double turn_rad, int steps) {
    const std::int64_t before = encoders.ticks().right;
    for (int i = 0; i < steps; ++i) {
      encoders.roll(0, turn_rad / steps);
    }
    return 2 * static_cast<double>(encoders.ticks().right - before) * tick_m(body) /
           body.wheel_base_m / turn_rad;
  };
  const double tick = 2 * tick_m(body) / body.wheel_base_m / 100;  // of a turn of 100 rad
  const double first = felt(100, 50);
  EXPECT_NEAR(felt(100, 70), first, 2 * tick) << "the same turn goes on";
  EXPECT_GT(std::abs(felt(-100, 50) - first), 2 * tick) << "the other way is another turn";

  constexpr int kTurns = 2000;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kTurns; ++i) {
    encoders.roll(0.1, 0);  // ends the turn
    const double slip = felt(100, 1) - 1;
    sum += slip;
    squares += slip * slip;
  }
  EXPECT_NEAR(sum / kTurns, 0, 3 * 0.01 / std::sqrt(kTurns));
  EXPECT_NEAR(squares / kTurns, 1e-4, 3 * 1e-4 * std::sqrt(2.0 / kTurns));
}

TEST(WheelEncoders, RepeatFromTheSameSeedOnly) {
  const Body body;
  const auto ticks = [&](std::uint64_t seed) {
    WheelEncoders encoders(WheelError{}, body, Rng(seed));
    reckon(encoders, body, {0.4, 0.2}, 20);
    return encoders.ticks();
  };
  EXPECT_EQ(ticks(4).left, ticks(4).left);
  EXPECT_EQ(ticks(4).right, ticks(4).right);
  EXPECT_NE(ticks(4).left, ticks(5).left);
}

TEST(WheelEncoders, SlipWhereTheFloorIsSlippery) {
  const Body body;
  const Surface wet{{2, 0, deg_to_rad(90)}, {4, 1}, 0.05, 3};  // x from 1.5 to 2.5, y from -2 to 2
  const auto traction = [&](const Pose2& at) { return traction_under_wheels({wet}, body, at); };
  EXPECT_EQ(traction({1.4, 1.9, 0})[0].slip, 0);
  EXPECT_EQ(traction({1.6, 1.9, 0})[0].slip, 0) << "the left wheel stands beyond its edge";
  EXPECT_EQ(traction({1.6, 1.9, 0})[1].slip, 0.05);
  EXPECT_EQ(traction({1.6, 0, 0})[0].noise_factor, 3);
  EXPECT_EQ(traction({1.4, 0, deg_to_rad(90)})[1].slip, 0.05) << "the right wheel stands on it";
  EXPECT_EQ(traction({1.4, 0, deg_to_rad(90)})[0].slip, 0);

  WheelEncoders encoders(kPerfect, body, Rng(1));
  encoders.roll(100, 0, traction({1.6, 0, 0}));
  EXPECT_NEAR(static_cast<double>(encoders.ticks().left) * tick_m(body), 105, tick_m(body));
  encoders.roll(0, 100, traction({1.6, 1.9, 0}));
  const double half_m = 100 * body.wheel_base_m / 2;
  EXPECT_NEAR(static_cast<double>(encoders.ticks().left) * tick_m(body), 105 - half_m,
              2 * tick_m(body));
  EXPECT_NEAR(static_cast<double>(encoders.ticks().right) * tick_m(body), 105 + 1.05 * half_m,
              2 * tick_m(body));
}

TEST(WheelEncoders, RoughFloorAddsToNoiseAndSlip) {
  const Body body;
  const std::array<TractionFactors, 2> rough{TractionFactors{0, 4}, TractionFactors{0, 4}};
  for (const WheelError& error : {WheelError{0.003, 0, 0, 0, 0}, WheelError{0, 0, 0, 0.005, 0}}) {
    WheelEncoders plain(error, body, Rng(5));
    WheelEncoders off(error, body, Rng(5));
    plain.roll(0, 500);
    off.roll(0, 500, rough);
    const double distance_m = 500 * body.wheel_base_m / 2;
    const double plain_m = static_cast<double>(plain.ticks().right) * tick_m(body) - distance_m;
    const double off_m = static_cast<double>(off.ticks().right) * tick_m(body) - distance_m;
    EXPECT_NEAR(off_m, 4 * plain_m, 5 * tick_m(body));
    EXPECT_GT(std::abs(off_m), 5 * tick_m(body));
  }
}

TEST(DeadReckoning, SaysTheVelocityOfTheLastEightSteps) {
  const Body body;
  WheelEncoders encoders(kPerfect, body, Rng(1));
  DeadReckoning reckoning(body);
  for (int i = 0; i < 100; ++i) {
    encoders.roll(0.4 * kStep_s, 0.8 * kStep_s);
    reckoning.add(encoders.ticks(), from_seconds(kStep_s));
  }
  const double tick_mps = tick_m(body) / (8 * kStep_s);
  EXPECT_NEAR(reckoning.odometry().twist_body.v_mps, 0.4, tick_mps);
  EXPECT_NEAR(reckoning.odometry().twist_body.w_radps, 0.8, 2 * tick_mps / body.wheel_base_m);
}

TEST(WheelFactors, GivenExactlyTakeThePlaceOfAllDraws) {
  const auto error = read_settings_text<WheelError>(
      "{sigma_radius_percent: 3, exactly: {radius_percent: 2, radius_ratio_percent: 0.5, "
      "base_percent: -1}}",
      "m.yaml");
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const TrueWheels wheels = true_wheels(wheel_factors(error, Rng(seed)), Body());
    constexpr double kRoundoff = 1e-12;
    EXPECT_NEAR((wheels.left_radius_m + wheels.right_radius_m) / 2 / Body().wheel_radius_m, 1.02,
                kRoundoff);
    EXPECT_NEAR(wheels.left_radius_m / wheels.right_radius_m, 1.005, kRoundoff);
    EXPECT_NEAR(wheels.base_m / Body().wheel_base_m, 0.99, kRoundoff);
  }
}

TEST(WheelFactors, AreDrawnBySigmaBesidesTheFixedOnes) {
  constexpr int kDraws = 1000;
  const WheelError error{0, 0, 0, 0, 0.5, 0.1, 0.5};
  double radius2 = 0;
  double ratio2 = 0;
  double base2 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const WheelFactors f = wheel_factors(error, Rng(static_cast<std::uint64_t>(i)));
    radius2 += std::pow(100 * ((f.radius[0] + f.radius[1]) / 2 - 1), 2);
    ratio2 += std::pow(100 * (f.radius[0] / f.radius[1] - 1), 2);
    base2 += std::pow(100 * (f.base - 1), 2);
  }
  const double three_sigma = 3 * std::sqrt(2.0 / kDraws);  // of a variance, relative
  EXPECT_NEAR(radius2 / kDraws / 0.25, 1, three_sigma);
  EXPECT_NEAR(ratio2 / kDraws / 0.01, 1, three_sigma);
  EXPECT_NEAR(base2 / kDraws / 0.25, 1, three_sigma);
  // What was there before is drawn as before.
  WheelError only_fixed;
  only_fixed.sigma_radius_percent = 0;
  const WheelFactors fixed = wheel_factors(only_fixed, Rng(7));
  constexpr double kRoundoff = 1e-12;
  EXPECT_NEAR(std::abs(fixed.radius[0] - 1), only_fixed.diameter_difference / 2, kRoundoff);
}

TEST(WheelFactors, OfACalibratedBaseAreOffInEveryPart) {
  constexpr int kDraws = 1000;
  double radius2 = 0;
  for (int i = 0; i < kDraws; ++i) {
    const WheelFactors f = wheel_factors({}, Rng(static_cast<std::uint64_t>(i)));
    radius2 += std::pow(100 * ((f.radius[0] + f.radius[1]) / 2 - 1), 2);
    EXPECT_NEAR(std::abs(f.radius[0] / f.radius[1] - 1), 0.0006, 1e-6);  // of second order
    constexpr double kRoundoff = 1e-12;
    EXPECT_NEAR(std::abs(f.base - 1), 0.003, kRoundoff);
  }
  EXPECT_NEAR(radius2 / kDraws / (0.2 * 0.2), 1, 3 * std::sqrt(2.0 / kDraws));
}

TEST(WheelEncoders, LargerWheelsCountFewerTicks) {
  const auto error = read_settings_text<WheelError>(
      "{noise_m_per_sqrt_m: 0, turn_slip: 0, exactly: {radius_percent: 2}}", "m.yaml");
  const Body body;
  WheelEncoders encoders(error, body, Rng(1));
  const Pose2 odom = reckon(encoders, body, {0.4, 0}, 10);
  EXPECT_NEAR(odom.x_m, 4 / 1.02, tick_m(body));
  EXPECT_EQ(encoders.wheels().left_radius_m, encoders.wheels().right_radius_m);
}

}  // namespace
}  // namespace panoptes::sim
