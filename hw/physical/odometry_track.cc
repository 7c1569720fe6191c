// SPDX-License-Identifier: BSD-3-Clause
#include "hw/physical/odometry_track.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace panoptes::hw {
namespace {

constexpr Duration kKept = std::chrono::seconds(3);
// Of counters rounded to 1 mm and 0.09 degrees one period alone would tell 1 cm/s and 1 deg/s.
constexpr double kLearn = 0.2;
constexpr Duration kStep = std::chrono::milliseconds(5);  // 0.6 m/s2 in half of it is 8 um

/// The constant twist that leads from one pose to the other in `dt_s`. Where the way is no arc (the
/// counters' rounding) its chord is kept.
Pose2 along_arc(const Pose2& T_odom_from, const Pose2& T_odom_to, double share) {
  const Pose2 T_from_to = T_odom_from.inverse() * T_odom_to;
  const double turn = T_from_to.theta_rad;
  const Vec2 chord = T_from_to.position();
  // A twist turns its chord by half of its turn; part of the way has a chord of part of the length.
  const double half = turn / 2;
  const double whole_m = std::abs(half) < 1e-9 ? 1 : std::sin(half) / half;
  const double part_m = std::abs(half) < 1e-9 ? share : std::sin(share * half) / half;
  const double back = half - share * half;
  const Vec2 to = part_m / whole_m *
                  Vec2(std::cos(back) * chord.x() + std::sin(back) * chord.y(),
                       -std::sin(back) * chord.x() + std::cos(back) * chord.y());
  return T_odom_from * Pose2{to.x(), to.y(), share * turn};
}

}  // namespace

void OdometryTrack::add(const WheelPose& pose) {
  if (!poses_.empty() && pose.stamp <= poses_.back().stamp) {
    poses_.back() = pose;
    return;
  }
  if (poses_.empty()) {
    commanded_ = pose.twist_body;
  } else {
    const WheelPose& before = poses_.back();
    // Reports leave a period apart; stamps that are nearer to each other tell no velocity.
    const double dt_s = to_seconds(std::max(pose.stamp - before.stamp, period_ / 2));
    const MotionIncrement increment = by_commands(before.stamp, pose.stamp, commanded_, {});
    const Pose2 moved = before.T_odom_body.inverse() * pose.T_odom_body;
    const auto learn = [](double& value, double seen) { value += kLearn * (seen - value); };
    const Twist2 seen =
        held_within({(moved.x_m - increment.T_from_to.x_m) / dt_s,
                     wrap_angle(moved.theta_rad - increment.T_from_to.theta_rad) / dt_s});
    learn(besides_.v_mps, seen.v_mps);
    learn(besides_.w_radps, seen.w_radps);
    commanded_ = increment.twist_body;
  }
  poses_.push_back(pose);
  while (poses_.front().stamp < pose.stamp - kKept) {
    poses_.pop_front();
  }
  // The median: lost reports make some gaps longer, none shorter.
  std::vector<Duration> gaps;
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    gaps.push_back(poses_[i].stamp - poses_[i - 1].stamp);
  }
  if (!gaps.empty()) {
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2),
                     gaps.end());
    period_ = gaps[gaps.size() / 2];
  }
}

void OdometryTrack::commanded(const CommandedTwist& command) {
  commands_.push_back(command);
  while (commands_.size() > 1 && commands_[1].at < command.at - kKept) {
    commands_.pop_front();
  }
}

Twist2 OdometryTrack::held_within(const Twist2& twist_body) const {
  return {std::clamp(twist_body.v_mps, -ramp_.max_speed_mps, ramp_.max_speed_mps),
          std::clamp(twist_body.w_radps, -ramp_.max_turn_radps, ramp_.max_turn_radps)};
}

// The last report is up to a period old, in which a turn that begins or ends comes to a degree.
OdometryTrack::MotionIncrement OdometryTrack::by_commands(Time from, Time to,
                                                          const Twist2& twist_body,
                                                          const Twist2& besides) const {
  MotionIncrement increment{{}, twist_body};
  auto command = commands_.begin();
  for (Time now = from; now < to;) {
    while (command != commands_.end() && command + 1 != commands_.end() &&
           (command + 1)->at <= now) {
      ++command;
    }
    const Time next = std::min(to, now + kStep);
    const double dt_s = to_seconds(next - now);
    const Twist2 before = increment.twist_body;
    if (command != commands_.end() && command->at <= now) {
      const auto towards = [dt_s](double is, double wanted, double accel) {
        return is + std::clamp(wanted - is, -accel * dt_s, accel * dt_s);
      };
      increment.twist_body = {
          towards(before.v_mps, command->twist_body.v_mps, ramp_.accel_mps2),
          towards(before.w_radps, command->twist_body.w_radps, ramp_.turn_accel_radps2)};
    }
    const Twist2 mean =
        held_within({(before.v_mps + increment.twist_body.v_mps) / 2 + besides.v_mps,
                     (before.w_radps + increment.twist_body.w_radps) / 2 + besides.w_radps});
    increment.T_from_to = increment.T_from_to * exp_twist(mean, dt_s);
    now = next;
  }
  return increment;
}

std::optional<Time> OdometryTrack::first() const {
  return poses_.empty() ? std::nullopt : std::optional(poses_.front().stamp);
}

std::optional<Time> OdometryTrack::last() const {
  return poses_.empty() ? std::nullopt : std::optional(poses_.back().stamp);
}

std::optional<Odometry> OdometryTrack::at(Time t, bool late) const {
  const auto after =
      std::lower_bound(poses_.begin(), poses_.end(), t,
                       [](const WheelPose& pose, Time when) { return pose.stamp < when; });
  if (after == poses_.end()) {
    if (poses_.empty() || t > poses_.back().stamp + period_) {
      return std::nullopt;
    }
    const WheelPose& last = poses_.back();
    if (late) {
      const Twist2 twist_body = held_within(last.twist_body);
      return Odometry{last.T_odom_body * exp_twist(twist_body, to_seconds(t - last.stamp)),
                      twist_body, true};
    }
    const MotionIncrement increment = by_commands(last.stamp, t, commanded_, besides_);
    return Odometry{last.T_odom_body * increment.T_from_to,
                    held_within({increment.twist_body.v_mps + besides_.v_mps,
                                 increment.twist_body.w_radps + besides_.w_radps}),
                    true};
  }
  if (after->stamp == t) {
    return Odometry{after->T_odom_body, after->twist_body, false};
  }
  if (after == poses_.begin()) {
    return std::nullopt;
  }
  const WheelPose& before = *(after - 1);
  const double share = to_seconds(t - before.stamp) / to_seconds(after->stamp - before.stamp);
  const auto mixed = [&](double from, double to) { return from + share * (to - from); };
  return Odometry{along_arc(before.T_odom_body, after->T_odom_body, share),
                  {mixed(before.twist_body.v_mps, after->twist_body.v_mps),
                   mixed(before.twist_body.w_radps, after->twist_body.w_radps)},
                  false};
}

}  // namespace panoptes::hw
