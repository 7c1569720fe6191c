// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/drive_path.h"

#include <algorithm>
#include <utility>

#include "core/base/check.h"
#include "core/geometry/arc.h"

namespace panoptes {

DrivePath::DrivePath(std::vector<Pose2> T_start_body, double period_s)
    : T_start_body_(std::move(T_start_body)), period_s_(period_s) {
  PANOPTES_CHECK(T_start_body_.size() >= 2 && period_s > 0, "a path has a beginning and an end");
}

Time DrivePath::instant(std::size_t pose) const {
  return time_at(period_s_ * static_cast<double>(pose));
}

std::optional<Pose2> DrivePath::at(Time instant) const {
  const double i = to_seconds(instant) / period_s_;
  if (i < 0 || i > static_cast<double>(T_start_body_.size() - 1)) {
    return std::nullopt;
  }
  const auto low = std::min(static_cast<std::size_t>(i), T_start_body_.size() - 2);
  return on_arc(T_start_body_[low], T_start_body_[low + 1], i - static_cast<double>(low));
}

std::optional<Odometry> DrivePath::odometry(Time instant) const {
  const std::optional<Pose2> T = at(instant);
  if (!T) {
    return std::nullopt;
  }
  constexpr double kStep_s = 1e-3;
  const std::optional<Pose2> after = at(instant + from_seconds(kStep_s));
  const Pose2 moved = after ? T->inverse() * *after : Pose2();
  return Odometry{*T, {moved.x_m / kStep_s, moved.theta_rad / kStep_s}};
}

DrivePath driven_path(const MotionProgramOptions& program, const Body& body, double longest_s) {
  constexpr double kPeriod_s = 0.05;
  MotionProgram drive(program, body, {from_seconds(kPeriod_s), Duration{}});
  std::vector<Pose2> poses{Pose2{}};
  Twist2 twist_body;
  do {
    twist_body = drive.command({poses.back(), twist_body}, from_seconds(kPeriod_s));
    poses.push_back(poses.back() * exp_twist(twist_body, kPeriod_s));
  } while (!drive.done() && kPeriod_s * static_cast<double>(poses.size()) <= longest_s);
  return {std::move(poses), kPeriod_s};
}

}  // namespace panoptes
