// SPDX-License-Identifier: BSD-3-Clause
#include "hw/physical/physical_robot.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"

namespace panoptes::hw {

PhysicalRobot::PhysicalRobot(std::unique_ptr<Base> base, std::unique_ptr<CameraSource> cameras,
                             const BaseRamp& ramp, const Robot* behind)
    : base_(std::move(base)), cameras_(std::move(cameras)), behind_(behind), track_(ramp) {
  const BaseReports before = base_->take_reports();  // there was nobody to see all but the last
  PANOPTES_CHECK(!before.poses.empty(), "a robot's base has reported");
  track_.add(before.poses.back());
  epoch_ = before.poses.back().epoch;
  for (const CommandedTwist& command : before.commanded) {
    track_.commanded(command);
  }
  if (cameras_) {
    cameras_->start([this] { return base_->now(); },
                    [this] {
                      arrived_ = true;
                      base_->wake();
                    });
  }
}

PhysicalRobot::~PhysicalRobot() = default;

// What is observed has come with a report, a period after its instant at most; the command that
// answers it goes back after as long again.
Timing PhysicalRobot::timing() const {
  const BaseTiming base = base_->timing();
  return {base.period, base.worst_round_trip + 2 * base.period};
}

Time PhysicalRobot::now() const { return base_->now(); }

void PhysicalRobot::take_reports() {
  const BaseReports reports = base_->take_reports();
  for (const WheelPose& pose : reports.poses) {
    if (pose.epoch != epoch_) {
      base_->stop();
      throw DeviceError(fmt::format(
          "the base has lost count of its way at {:.1f} s: its reports were missing for too long "
          "or it was reset; the map is good until then, begin another run from here",
          to_seconds(pose.stamp)));
    }
    track_.add(pose);
  }
  held_up_ = reports.held_up;
  for (const CommandedTwist& command : reports.commanded) {
    track_.commanded(command);
  }
  if (!reports.error.empty()) {
    throw DeviceError(reports.error);
  }
}

Observation PhysicalRobot::observe(Time deadline) {
  Observation seen;
  std::optional<Odometry> odometry;
  while (true) {
    take_reports();
    if (!waiting_ && cameras_) {
      arrived_ = false;  // one that arrives meanwhile is asked for again
      waiting_ = cameras_->next();
    }
    if (waiting_ && waiting_->stamp < track_.first()) {
      waiting_.reset();  // so late that its odometry will not be known any more
      continue;
    }
    if (waiting_) {
      odometry = track_.at(waiting_->stamp, held_up_);
      if (odometry && (!odometry->extrapolated || !held_up_ || base_->now() >= deadline)) {
        seen.stamp = waiting_->stamp;
        seen.pictures = std::move(waiting_->pictures);
        waiting_.reset();
        ++sets_;
        extrapolated_ += odometry->extrapolated ? 1 : 0;
        break;
      }
    }
    if (!cameras_ && track_.last() > last_stamp_) {
      seen.stamp = *track_.last();
      odometry = track_.at(seen.stamp);
      break;
    }
    if (base_->now() >= deadline) {
      const Time latest = *track_.last() + track_.period();
      seen.stamp = std::min(std::max(base_->now(), last_stamp_), latest);
      odometry = track_.at(seen.stamp, held_up_);
      break;
    }
    base_->wait(deadline, [&] { return !waiting_ && arrived_; });
  }
  last_stamp_ = std::max(last_stamp_, seen.stamp);
  if (!T_first_odom_) {
    T_first_odom_ = odometry->T_odom_body.inverse();
  }
  seen.odometry = *odometry;
  seen.odometry.T_odom_body = *T_first_odom_ * odometry->T_odom_body;
  seen.health = base_->health();
  return seen;
}

void PhysicalRobot::drive(const Twist2& command_body, Duration valid_for) {
  base_->drive(command_body, valid_for);
}

void PhysicalRobot::stop() { base_->stop(); }

void PhysicalRobot::emergency_stop() { base_->emergency_stop(); }

void PhysicalRobot::acknowledge() { base_->acknowledge(); }

std::optional<Truth> PhysicalRobot::truth() const {
  return behind_ == nullptr ? std::nullopt : behind_->truth();
}

std::optional<Truth> PhysicalRobot::truth_since(std::size_t poses, std::size_t contacts) const {
  return behind_ == nullptr ? std::nullopt : behind_->truth_since(poses, contacts);
}

DeviceFigures PhysicalRobot::devices() const {
  DeviceFigures figures;
  figures["base"] = base_->figures();
  figures["base"]["epoch"] = static_cast<double>(epoch_);
  if (cameras_) {
    figures["cameras"] = {{"sets", static_cast<double>(sets_)},
                          {"odometry_extrapolated", static_cast<double>(extrapolated_)}};
  }
  return figures;
}

}  // namespace panoptes::hw
