// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/geometry/arc.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// What a drive over a floor consists of, and how its wheels lie.
struct RoseShape {
  int legs = 9;
  double leg_m = 0.4;       ///< out and back, 0: it turns on the spot
  double turn_rad = 0.8;    ///< between legs, 0: it never turns
  double leg_turn_rad = 0;  ///< on its way out: a leg is an arc,
  bool back = true;         ///< and it drives back on it
  double period_s = 0.1;
  double speed_mps = 0.4;
  double turn_radps = 0.5;
  double noise_m = 0;         ///< of a wheel that rolls a metre; grows with the root of the way
  double way_error = 0;       ///< of the wheels, as a share (core/calib/rig_costs.h),
  double turn_error = 0;      ///< likewise,
  double turn_per_metre = 0;  ///< and of unequal wheels, in rad
};

/// A robot that drives a rose: soft starts and stops, so that a clock can be told by them.
class DrivenRose {
 public:
  DrivenRose(const RoseShape& rose, Rng rng) : period_s_(rose.period_s) {
    stand();
    for (int leg = 0; leg < rose.legs; ++leg) {
      run(0, rose.turn_rad, rose);
      run(rose.leg_m, rose.leg_turn_rad, rose);
      if (rose.back) {
        run(-rose.leg_m, -rose.leg_turn_rad, rose);
      }
    }
    stand();
    Pose2 odometry;
    for (std::size_t i = 0; i < true_.size(); ++i) {
      if (i > 0) {
        const Pose2 moved = true_[i - 1].inverse() * true_[i];
        const double way = std::copysign(moved.position().norm(), moved.x_m) / (1 + rose.way_error);
        const double turn = (moved.theta_rad - rose.turn_per_metre * way) / (1 + rose.turn_error);
        const auto rolled = [&](double wheel_m) {
          return wheel_m + rose.noise_m * std::sqrt(std::abs(wheel_m)) * rng.normal();
        };
        constexpr double kBase_m = 0.4;
        const double left = rolled(way - turn * kBase_m / 2);
        const double right = rolled(way + turn * kBase_m / 2);
        const Twist2 told{(left + right) / 2, (right - left) / kBase_m};
        odometry = odometry * exp_twist(told, 1);
      }
      odometry_.push_back(odometry);
    }
  }

  std::size_t instants() const { return true_.size(); }
  Time instant(std::size_t i) const { return time_at(period_s_ * static_cast<double>(i)); }
  const Pose2& T_start_body(std::size_t i) const { return true_[i]; }
  Pose2 T_start_body(Time at) const { return between(true_, at).value_or(true_.back()); }

  std::optional<Odometry> wheels(Time at) const {
    const std::optional<Pose2> T = between(odometry_, at);
    if (!T) {
      return std::nullopt;
    }
    constexpr double kStep_s = 1e-3;
    const std::optional<Pose2> after = between(odometry_, at + from_seconds(kStep_s));
    const Pose2 moved = after ? T->inverse() * *after : Pose2();
    return Odometry{*T, {moved.x_m / kStep_s, moved.theta_rad / kStep_s}};
  }

 private:
  std::optional<Pose2> between(const std::vector<Pose2>& poses, Time at) const {
    const double i = to_seconds(at) / period_s_;
    if (i < 0 || i > static_cast<double>(poses.size() - 1)) {
      return std::nullopt;
    }
    const auto low = std::min(static_cast<std::size_t>(i), poses.size() - 2);
    return on_arc(poses[low], poses[low + 1], i - static_cast<double>(low));
  }

  void stand() {
    for (int i = 0; i < 10; ++i) {
      true_.push_back(true_.empty() ? Pose2() : true_.back());
    }
  }

  void run(double way_m, double turn_rad, const RoseShape& rose) {
    const double mean_s =
        way_m != 0 ? std::abs(way_m) / rose.speed_mps : std::abs(turn_rad) / rose.turn_radps;
    const int steps = std::max(4, static_cast<int>(2 * mean_s / rose.period_s));
    double done = 0;
    for (int i = 1; i <= steps && (way_m != 0 || turn_rad != 0); ++i) {
      const double next = 0.5 - 0.5 * std::cos(3.14159265358979 * i / steps);
      true_.push_back(true_.back() * exp_twist({way_m, turn_rad}, next - done));
      done = next;
    }
  }

  double period_s_;
  std::vector<Pose2> true_;
  std::vector<Pose2> odometry_;
};

}  // namespace panoptes
