// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/calib/drive_path.h"
#include "core/camera/observation.h"
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
  DrivenRose(const RoseShape& rose, Rng rng) {
    stand();
    for (int leg = 0; leg < rose.legs; ++leg) {
      run(0, rose.turn_rad, rose);
      run(rose.leg_m, rose.leg_turn_rad, rose);
      if (rose.back) {
        run(-rose.leg_m, -rose.leg_turn_rad, rose);
      }
    }
    stand();
    true_path_.emplace(true_, rose.period_s);
    std::vector<Pose2> by_wheels;
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
      by_wheels.push_back(odometry);
    }
    odometry_.emplace(by_wheels, rose.period_s);
  }

  std::size_t instants() const { return true_.size(); }
  Time instant(std::size_t i) const { return true_path_->instant(i); }
  const DrivePath& path() const { return *true_path_; }
  const Pose2& T_start_body(std::size_t i) const { return true_[i]; }
  Pose2 T_start_body(Time at) const { return true_path_->at(at).value_or(true_.back()); }

  std::optional<Odometry> wheels(Time at) const { return odometry_->odometry(at); }

 private:
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

  std::vector<Pose2> true_;
  std::optional<DrivePath> true_path_;
  std::optional<DrivePath> odometry_;
};

}  // namespace panoptes
