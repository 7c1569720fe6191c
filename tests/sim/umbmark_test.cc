// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "sim/physics/drive_world.h"
#include "sim/sensors/encoders.h"

namespace panoptes::sim {
namespace {

constexpr double kSide_m = 4;
constexpr int kRuns = 5;

/// The robot on the open floor, driven by what its wheels tell it.
class Robot {
 public:
  Robot(const WheelError& error, std::uint64_t seed, const Pose2& start)
      : drive_(body_, nothing_, start), encoders_(error, body_, Rng(seed)), reckoning_(body_) {}

  void step(const Twist2& command) {
    drive_.drive(command, Time::max());
    const Time before = drive_.now();
    drive_.step();
    encoders_.roll(drive_.last_motion().forward_m, drive_.last_motion().turn_rad);
    reckoning_.add(encoders_.ticks(), drive_.now() - before);
  }

  void turn_to(double theta_rad) {
    const double tick_rad =
        2 * std::numbers::pi * body_.wheel_radius_m / body_.ticks_per_turn / body_.wheel_base_m;
    for (int still = 0; still < 20;) {
      const double rest_rad = wrap_angle(theta_rad - odom().theta_rad);
      const bool there = std::abs(rest_rad) < tick_rad;
      step({0, there ? 0 : std::clamp(2 * rest_rad, -0.5, 0.5)});
      still = there ? still + 1 : 0;
    }
  }

  /// Along the line from `from` in the direction of `theta_rad`, one side of the square.
  void drive_side(const Vec2& from, double theta_rad) {
    constexpr double kAhead_m = 0.5;
    const Pose2 T_odom_side{from.x(), from.y(), theta_rad};
    while (true) {
      const Vec2 p_side = T_odom_side.inverse() * odom().position();
      const double rest_m = kSide_m - p_side.x();
      if (rest_m < 0.001 && drive_.twist_body().v_mps < 0.01) {
        break;
      }
      const double off_rad =
          wrap_angle(theta_rad + std::atan2(-p_side.y(), kAhead_m) - odom().theta_rad);
      step({std::clamp(2 * rest_m, -0.1, 0.2), std::clamp(off_rad, -0.3, 0.3)});
    }
    for (int i = 0; i < 60; ++i) {
      step({});
    }
  }

  const Pose2& odom() {
    odom_ = reckoning_.odometry().T_odom_body;
    return odom_;
  }
  Pose2 T_scene_body() const { return drive_.T_scene_body(); }

 private:
  Body body_;
  Obstacles nothing_{{}};
  DriveWorld drive_;
  WheelEncoders encoders_;
  DeadReckoning reckoning_;
  Pose2 odom_;
};

/// Once around the square; where it truly ended less where its wheels say.
Vec2 return_error(const WheelError& error, std::uint64_t seed, int run, int turns) {
  const Pose2 T_scene_odom{0.001 * run, 0, 0};
  Robot robot(error, seed, T_scene_odom);
  Vec2 corner(0, 0);
  for (int side = 0; side < 4; ++side) {
    const double theta_rad = turns * side * std::numbers::pi / 2;
    robot.drive_side(corner, theta_rad);
    corner += kSide_m * Vec2(std::cos(theta_rad), std::sin(theta_rad));
    robot.turn_to(turns * (side + 1) * std::numbers::pi / 2);
  }
  return (T_scene_odom.inverse() * robot.T_scene_body()).position() - robot.odom().position();
}

struct Recovered {
  double base_error = 0;           // true over believed, less 1
  double diameter_difference = 0;  // right over left, less 1
};

/// Borenstein and Feng, Measurement and Correction of Systematic Odometry Errors in Mobile Robots
/// (1996), equations 8 to 15: from the mean return errors of squares both ways around.
Recovered umbmark(const WheelError& error, std::uint64_t seed) {
  Vec2 ccw = Vec2::Zero();
  Vec2 cw = Vec2::Zero();
  for (int run = 0; run < kRuns; ++run) {
    ccw += return_error(error, seed, run, 1) / kRuns;
    cw += return_error(error, seed, run, -1) / kRuns;
  }
  const double alpha_rad = ((cw.x() + ccw.x()) + (cw.y() - ccw.y())) / 2 / (-4 * kSide_m);
  const double beta_rad = ((cw.x() - ccw.x()) + (cw.y() + ccw.y())) / 2 / (-4 * kSide_m);
  const double radius_m = kSide_m / 2 / std::sin(beta_rad / 2);
  const double base_m = Body{}.wheel_base_m;
  const double quarter_rad = std::numbers::pi / 2;
  return {quarter_rad / (quarter_rad - alpha_rad) - 1,
          (radius_m + base_m / 2) / (radius_m - base_m / 2) - 1};
}

// The formulas are of first order; with larger errors the squares of one show in the other.
TEST(Umbmark, RecoversTheWheelBaseAndTheDiameters) {
  const WheelError usual;
  for (const auto& [diameter_difference, base_error] :
       {std::pair(usual.diameter_difference, usual.base_error), std::pair(0.001, 0.01)}) {
    const WheelError error{0, diameter_difference, base_error, 0, 0};
    for (const std::uint64_t seed : {1, 3, 4}) {  // three of the four pairs of signs
      const Recovered found = umbmark(error, seed);
      EXPECT_NEAR(std::abs(found.base_error), base_error, 0.02 * base_error);
      EXPECT_NEAR(std::abs(found.diameter_difference), diameter_difference,
                  0.02 * diameter_difference);
    }
  }
}

}  // namespace
}  // namespace panoptes::sim
