// SPDX-License-Identifier: BSD-3-Clause
#include "core/odometry/wheel_odometry.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panoptes {

void bind(Fields& f, WheelNoise& o) {
  f("step_sigma_m", o.step_sigma_m, not_negative);
  f("slip_share", o.slip_share, not_negative);
  for (const char* name : {"diameter_share", "base_share"}) {
    f.removed(name,
              "is not set any more: navigator.localiser.wheel_prior says what the wheels may get "
              "wrong every time");
  }
}

Mat3 wheel_covariance(const WheelNoise& noise, double wheel_base_m, const Pose2& T_from_to) {
  const double turn = T_from_to.theta_rad;
  const double half = turn / 2;
  const double chord = T_from_to.position().norm();
  const double sinc = std::abs(half) < 1e-6 ? 1.0 : std::sin(half) / half;
  const double distance = chord / std::max(sinc, 0.1);
  const double left = std::abs(distance - half * wheel_base_m);
  const double right = std::abs(distance + half * wheel_base_m);
  const double step2 = noise.step_sigma_m * noise.step_sigma_m;
  const double base2 = wheel_base_m * wheel_base_m;
  // along the path; what a wheel gains or loses at random
  const double along = step2 * (left + right) / 4;
  const double turn_random = step2 * (left + right) / base2;
  const double turn_steady = noise.slip_share * noise.slip_share * turn * turn;
  // a heading that wanders along the path swings its end by half, with a third of the variance
  const double across = (turn_random / 3 + turn_steady / 4) * distance * distance;
  const double coupled = (turn_random + turn_steady) / 2 * distance;
  // unevenness, by the way of the wheels, and rounding of ticks: never quite certain
  constexpr double kGround_m_per_sqrt_m = 1e-3;
  constexpr double kTick_m = 1e-4;
  constexpr double kGround_rad = 5e-4;
  const double ground =
      kGround_m_per_sqrt_m * kGround_m_per_sqrt_m * (left + right) / 2 + kTick_m * kTick_m;
  Mat3 covariance = Mat3::Zero();
  covariance(0, 0) = along + ground;
  covariance(1, 1) = across + ground;
  covariance(2, 2) = turn_random + turn_steady + kGround_rad * kGround_rad;
  covariance(1, 2) = covariance(2, 1) = coupled;
  // along and across the chord, turned into the frame of the start
  const double direction = chord > 1e-9 ? std::atan2(T_from_to.y_m, T_from_to.x_m) : 0;
  const double c = std::cos(direction);
  const double s = std::sin(direction);
  // driven backwards the same wandering swings the end to the other side: the direction says so
  Mat3 R = Mat3::Identity();
  R.topLeftCorner<2, 2>() << c, -s, s, c;
  return R * covariance * R.transpose();
}

std::optional<Odometry> WheelOdometry::at(const Observation& seen) {
  const Pose2& T = seen.odometry.T_odom_body;
  if (!is_finite(seen.odometry)) {
    fault_ = "the wheels tell no number";
    return std::nullopt;
  }
  Odometry told = seen.odometry;
  if (T_told_raw_) {
    told.T_odom_body = *T_told_raw_ * T;
  }
  if (last_) {
    // pushed, or with a clock that is late, it may seem faster than it drives
    constexpr double kTimesAsFast = 3;
    constexpr double kMost_m = 0.1;
    constexpr double kMost_rad = deg_to_rad(15);
    const double dt = std::max(0.0, to_seconds(seen.stamp - last_stamp_));
    const Pose2 moved = last_->T_odom_body.inverse() * told.T_odom_body;
    if (moved.position().norm() > kTimesAsFast * body_.max_speed_mps * dt + kMost_m ||
        std::abs(moved.theta_rad) > kTimesAsFast * body_.max_turn_radps * dt + kMost_rad) {
      fault_ = fmt::format(
          "the wheels jumped by {:.2f} m and {:.0f} degrees in {:.2f} s: it goes on "
          "from where it was",
          moved.position().norm(), rad_to_deg(moved.theta_rad), dt);
      told.T_odom_body = last_->T_odom_body * exp_twist(last_->twist_body, dt);
      T_told_raw_ = told.T_odom_body * T.inverse();
      last_ = told;
      last_stamp_ = seen.stamp;
      return std::nullopt;
    }
  }
  last_ = told;
  last_stamp_ = seen.stamp;
  return told;
}

Mat3 WheelOdometry::covariance(Time /*from*/, Time /*to*/, const Pose2& T_from_to) const {
  return wheel_covariance(noise_, body_.wheel_base_m, T_from_to);
}

// Of a motion taken for one arc: a chord turns by half of what its arc does.
WheelJacobian WheelOdometry::by_wheels(const Pose2& T_from_to) const {
  const double forwards =
      std::cos(std::atan2(T_from_to.y_m, T_from_to.x_m) - T_from_to.theta_rad / 2);
  const double distance_m = std::copysign(T_from_to.position().norm(), forwards);
  Eigen::RowVector3d turn;
  turn[kWheelScale] = T_from_to.theta_rad;
  turn[kWheelDifference] = distance_m / body_.wheel_base_m;
  turn[kWheelBase] = -T_from_to.theta_rad;
  WheelJacobian J;
  J.row(2) = turn;
  J.topRows<2>() = Vec2(-T_from_to.y_m, T_from_to.x_m) * (0.5 * turn);
  J.col(kWheelScale).head<2>() += T_from_to.position();
  return J;
}

}  // namespace panoptes
