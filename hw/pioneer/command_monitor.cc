// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/command_monitor.h"

#include <algorithm>
#include <cmath>

namespace panoptes::hw {
namespace {

// With a report's cycle on either side, and the latency, this is said within a second.
constexpr Duration kDoubted = std::chrono::milliseconds(500);
constexpr Duration kSeenAfter = std::chrono::milliseconds(100);     // a report's cycle
constexpr Duration kUnseenAtMost = std::chrono::milliseconds(250);  // two reports, and one lost
constexpr double kOfBraking = 0.25;
// Slower than this the robot comes less than 5 cm in that second.
constexpr double kMatters_mps = 0.05;
constexpr double kOvershoot = 0.25;  // of a controller's servo

/// By how much a velocity is beyond all between rest and what was commanded: negative where it is
/// below.
double beyond(double is, double least, double most, double matters) {
  const double low = std::min(least, 0.0);
  const double high = std::max(most, 0.0);
  const double above = is - high * (1 + kOvershoot);
  const double below = is - low * (1 + kOvershoot);
  return above > matters ? above : below < -matters ? below : 0;
}

}  // namespace

void CommandMonitor::commanded(Time at, const Twist2& twist_body) {
  if (commanded_.empty() || commanded_.back().twist_body.v_mps != twist_body.v_mps ||
      commanded_.back().twist_body.w_radps != twist_body.w_radps) {
    commanded_.push_back({at, twist_body});
  }
}

void CommandMonitor::forget() { speed_ = turn_ = {}; }

bool CommandMonitor::persists(Doubt& doubt, Time at, double is, double beyond, double accel) {
  if (beyond == 0) {
    doubt.since.reset();
    return false;
  }
  const bool above = beyond > 0;
  if (!doubt.since || above != doubt.above) {
    doubt = {at, is, at, is, above};
    return false;
  }
  const auto comes_back = [&](double was, Duration during) {
    return (above ? was - is : is - was) >= kOfBraking * accel * to_seconds(during);
  };
  // What it was commanded and did meanwhile is not known.
  *doubt.since += std::max(Duration::zero(), at - doubt.last - kUnseenAtMost);
  const Duration during = at - *doubt.since;
  const bool now = comes_back(doubt.is_last, std::max(at - doubt.last, kSeenAfter));
  const bool comes = now || comes_back(doubt.is, during);
  doubt.last = at;
  doubt.is_last = is;
  if (during < kDoubted) {
    return false;
  }
  if (comes) {
    doubt = {at, is, at, is, above};
  }
  return !comes;
}

bool CommandMonitor::disobeys(Time at, const Twist2& twist_body) {
  while (commanded_.size() > 1 && commanded_[1].at + latency_ + kSeenAfter <= at) {
    commanded_.pop_front();
  }
  Twist2 least;
  Twist2 most;
  for (const CommandedTwist& one : commanded_) {
    least = {std::min(least.v_mps, one.twist_body.v_mps),
             std::min(least.w_radps, one.twist_body.w_radps)};
    most = {std::max(most.v_mps, one.twist_body.v_mps),
            std::max(most.w_radps, one.twist_body.w_radps)};
  }
  const double v = beyond(twist_body.v_mps, least.v_mps, most.v_mps, kMatters_mps);
  const double w =
      beyond(twist_body.w_radps, least.w_radps, most.w_radps, kMatters_mps / body_.radius_m);
  const bool too_fast = persists(speed_, at, twist_body.v_mps, v, body_.max_accel_mps2);
  const bool turns = persists(turn_, at, twist_body.w_radps, w, body_.max_turn_accel_radps2);
  return too_fast || turns;
}

}  // namespace panoptes::hw
