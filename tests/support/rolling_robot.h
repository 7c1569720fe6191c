// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/body.h"
#include "hw/robot.h"

namespace panoptes::hw {

/// A robot that rolls on an endless floor as it is told, within a body's limits of acceleration,
/// and takes a picture of nothing 15 times a second.
class RollingRobot final : public Robot {
 public:
  explicit RollingRobot(const Body& body = {}) : body_(body) {}

  Observation observe(Time deadline) override {
    const Time set = time_at(static_cast<double>(sets_) / kSets_hz);
    const Time until = std::max(now_, std::min(deadline, set));
    while (now_ < until) {
      roll(std::min(until, now_ + std::chrono::milliseconds(1)));
    }
    Observation seen;
    seen.stamp = now_;
    seen.odometry = {pose, reported()};
    seen.health.bumper_bearings_rad = pressed_rad;
    seen.health.bumper_pressed = !pressed_rad.empty();
    if (until == set) {
      ++sets_;
      seen.pictures["front"] = {now_, cv::Mat(1, 1, CV_8UC3)};
    }
    return seen;
  }
  void drive(const Twist2& command_body, Duration valid_for) override {
    command_ = command_body;
    expires_ = now_ + valid_for;
  }
  void stop() override { command_ = {}; }
  Time now() const override { return now_; }
  Timing timing() const override {
    return {std::chrono::milliseconds(67), std::chrono::milliseconds(8)};
  }
  std::optional<Truth> truth() const override { return std::nullopt; }

  Pose2 pose;
  Twist2 twist;
  bool reports_mean = false;        ///< of the velocities of the last 100 ms, as wheels' ticks tell
  std::vector<double> pressed_rad;  ///< bearings of bumpers

 private:
  static constexpr double kSets_hz = 15;

  Twist2 reported() const {
    if (!reports_mean || recent_.empty()) {
      return twist;
    }
    Twist2 sum;
    for (const Twist2& one : recent_) {
      sum.v_mps += one.v_mps;
      sum.w_radps += one.w_radps;
    }
    const auto count = static_cast<double>(recent_.size());
    return {sum.v_mps / count, sum.w_radps / count};
  }

  void roll(Time to) {
    const double dt_s = to_seconds(to - now_);
    const Twist2 wanted = now_ < expires_ ? command_ : Twist2{};
    const auto towards = [dt_s](double is, double to_be, double accel) {
      return is + std::clamp(to_be - is, -accel * dt_s, accel * dt_s);
    };
    twist = {towards(twist.v_mps, wanted.v_mps, body_.max_accel_mps2),
             towards(twist.w_radps, wanted.w_radps, body_.max_turn_accel_radps2)};
    recent_.push_back(twist);
    if (recent_.size() > 100) {
      recent_.pop_front();
    }
    pose = pose * exp_twist(twist, dt_s);
    now_ = to;
  }

  Body body_;
  std::deque<Twist2> recent_;
  Twist2 command_;
  Time expires_;
  Time now_;
  std::int64_t sets_ = 0;
};

}  // namespace panoptes::hw
