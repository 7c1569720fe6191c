// SPDX-License-Identifier: BSD-3-Clause
#include "hw/physical/physical_robot.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace panoptes::hw {

PhysicalRobot::PhysicalRobot(std::unique_ptr<BaseLink> link, NextCameraSet next_set,
                             const BaseRamp& ramp, const Robot* behind)
    : link_(std::move(link)), next_set_(std::move(next_set)), behind_(behind), track_(ramp) {
  link_->with([&](PioneerClient& client) {
    client.take_poses();  // from before there was anybody to see them
    track_.add(*client.pose());
    epoch_ = client.pose()->epoch;
  });
}

PhysicalRobot::~PhysicalRobot() = default;

Time PhysicalRobot::now() const { return link_->now(); }

void PhysicalRobot::take_reports() {
  link_->with([&](PioneerClient& client) {
    for (const WheelPose& pose : client.take_poses()) {
      if (pose.epoch != epoch_) {
        client.stop(link_->now());
        throw DeviceError(fmt::format(
            "the base has lost count of its way at {:.1f} s: its reports were missing for too long "
            "or it was reset; the map is good until then, begin another run from here",
            to_seconds(pose.stamp)));
      }
      track_.add(pose);
    }
    holds_up_ = client.holds_up();
    for (const CommandedTwist& command : client.take_commanded()) {
      track_.commanded(command);
    }
    if (client.state() == PioneerClient::State::kRefused) {
      throw DeviceError(client.fault());
    }
  });
}

Observation PhysicalRobot::observe(Time deadline) {
  Observation seen;
  std::optional<Odometry> odometry;
  while (true) {
    take_reports();
    if (!waiting_ && next_set_) {
      waiting_ = next_set_();
    }
    if (waiting_) {
      odometry = track_.at(waiting_->stamp, holds_up_);
      if (odometry && (!odometry->extrapolated || !holds_up_ || link_->now() >= deadline)) {
        seen.stamp = waiting_->stamp;
        seen.pictures = std::move(waiting_->pictures);
        waiting_.reset();
        ++sets_;
        extrapolated_ += odometry->extrapolated ? 1 : 0;
        break;
      }
    }
    if (!next_set_ && track_.last() > last_stamp_) {
      seen.stamp = *track_.last();
      odometry = track_.at(seen.stamp);
      break;
    }
    if (link_->now() >= deadline) {
      const Time latest = *track_.last() + track_.period();
      seen.stamp = std::min(std::max(link_->now(), last_stamp_), latest);
      odometry = track_.at(seen.stamp, holds_up_);
      break;
    }
    const std::optional<Time> known = track_.last();
    link_->wait(deadline, [&](const PioneerClient& client) {
      return client.state() == PioneerClient::State::kRefused ||
             (client.pose() && client.pose()->stamp != known) ||
             (!waiting_ && next_set_ && (waiting_ = next_set_()));
    });
  }
  last_stamp_ = std::max(last_stamp_, seen.stamp);
  if (!T_first_odom_) {
    T_first_odom_ = odometry->T_odom_body.inverse();
  }
  seen.odometry = *odometry;
  seen.odometry.T_odom_body = *T_first_odom_ * odometry->T_odom_body;
  link_->with([&](PioneerClient& client) {
    const Sip& report = *client.report();
    seen.health.bumper_pressed = report.front_bumpers != 0 || report.rear_bumpers != 0;
    seen.health.motors_enabled = (report.flags & kFlagMotorsOn) != 0;
    seen.health.held_by = client.held_by();
  });
  return seen;
}

void PhysicalRobot::drive(const Twist2& command_body, Duration valid_for) {
  link_->with([&](PioneerClient& client) {
    const bool stands = command_body.v_mps == 0 && command_body.w_radps == 0;
    if (!enabled_ && stands && client.state() == PioneerClient::State::kReady) {
      return;  // whoever only watches does not switch the motors on
    }
    if (!enabled_) {
      client.enable(link_->now());
      enabled_ = true;
    }
    client.drive(link_->now(), command_body, valid_for);
  });
}

void PhysicalRobot::stop() {
  link_->with([&](PioneerClient& client) { client.stop(link_->now()); });
}

void PhysicalRobot::emergency_stop() {
  link_->with([&](PioneerClient& client) { client.emergency_stop(link_->now()); });
}

void PhysicalRobot::acknowledge() {
  link_->with([&](PioneerClient& client) {
    if (client.enabled()) {
      client.acknowledge();
    } else if (enabled_) {
      client.enable(link_->now());
    }
  });
}

std::optional<Truth> PhysicalRobot::truth() const {
  return behind_ == nullptr ? std::nullopt : behind_->truth();
}

std::optional<Truth> PhysicalRobot::truth_since(std::size_t poses, std::size_t contacts) const {
  return behind_ == nullptr ? std::nullopt : behind_->truth_since(poses, contacts);
}

DeviceFigures PhysicalRobot::devices() const {
  DeviceFigures figures;
  link_->with([&](const PioneerClient& client) {
    const LinkCounts counts = client.counts();
    figures["base"] = {{"reports", static_cast<double>(counts.reports)},
                       {"rejected_checksum", static_cast<double>(counts.rejected_checksum)},
                       {"rejected_implausible", static_cast<double>(counts.rejected_implausible)},
                       {"rejected_malformed", static_cast<double>(counts.rejected_malformed)},
                       {"skipped_bytes", static_cast<double>(counts.skipped_bytes)},
                       {"resyncs", static_cast<double>(counts.resyncs)},
                       {"commands", static_cast<double>(counts.commands)},
                       {"expired", static_cast<double>(counts.expired)},
                       {"longest_silence_s", counts.longest_silence_s},
                       {"round_trip_s", counts.round_trip_s},
                       {"battery_v", client.report() ? client.report()->battery_v() : 0},
                       {"epoch", static_cast<double>(epoch_)}};
  });
  if (next_set_) {
    figures["cameras"] = {{"sets", static_cast<double>(sets_)},
                          {"odometry_extrapolated", static_cast<double>(extrapolated_)}};
  }
  return figures;
}

}  // namespace panoptes::hw
