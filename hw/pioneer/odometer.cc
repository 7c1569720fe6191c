// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/odometer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace panoptes::hw {
namespace {

constexpr int kModulus = 4096;
constexpr double kSlack_m = 0.06;
const double kSlack_rad = deg_to_rad(5);
constexpr int kAgreeing = 3;
constexpr double kTopSpeed_mps = 2.2;  // of any Pioneer's wheel, by the maker's files
// By what a distance driven tells the time that it took.
constexpr double kTellStep_s = 0.01;
constexpr double kTellMost_s = 2;
constexpr double kVelocityOf_s = 0.05;
constexpr double kAccel_mps2 = 0.9;             // of a Pioneer under us, and half as much again
constexpr double kTurnAccel_radps2 = 4.5;       // likewise
constexpr double kDistanceRounding_m = 1.5e-3;  // of counters, at both ends
const double kTurnRounding_rad = deg_to_rad(0.15);

/// The step between two counters of which the lowest 12 bits are known, in [-2048, 2048).
std::int64_t step(std::int64_t from, std::int64_t to) {
  const std::int64_t forward = ((to - from) % kModulus + kModulus) % kModulus;
  return forward < kModulus / 2 ? forward : forward - kModulus;
}

Twist2 twist_of(const Sip& sip, const PioneerModel& model) {
  const double left_mps = model.speed_mps * sip.left;
  const double right_mps = model.speed_mps * sip.right;
  return {(left_mps + right_mps) / 2, (right_mps - left_mps) / 2 * model.turn_rad_per_m};
}

}  // namespace

PioneerOdometer::Counts PioneerOdometer::continued(const Counts& from, const Sip& sip) {
  return {from.x + step(from.x, sip.x), from.y + step(from.y, sip.y),
          from.theta + step(from.theta, sip.theta)};
}

Pose2 PioneerOdometer::pose(const Counts& counts) const {
  return {model_.distance_m * static_cast<double>(counts.x),
          model_.distance_m * static_cast<double>(counts.y),
          wrap_angle(model_.angle_rad * static_cast<double>(counts.theta))};
}

bool PioneerOdometer::near(const Candidate& from, const Candidate& to, double dt_s,
                           const Twist2& most) const {
  const Pose2 predicted = pose(from.counts) * exp_twist(from.twist_body, dt_s);
  const Pose2 reported = pose(to.counts);
  const double v_mps = std::max(std::abs(from.twist_body.v_mps), most.v_mps);
  const double w_radps = std::max(std::abs(from.twist_body.w_radps), most.w_radps);
  return (reported.position() - predicted.position()).norm() <= kSlack_m + v_mps * dt_s &&
         std::abs(wrap_angle(reported.theta_rad - predicted.theta_rad)) <=
             kSlack_rad + w_radps * dt_s;
}

void PioneerOdometer::rebase(const Candidate& report) {
  T_odom_counter_ = T_odom_body_ * pose(report.counts).inverse();
}

void PioneerOdometer::take(const Candidate& report) {
  last_ = report.stamp;
  counts_ = report.counts;
  twist_body_ = report.twist_body;
  T_odom_body_ = T_odom_counter_ * pose(counts_);
  elsewhere_.reset();
  agreeing_ = 0;
}

void PioneerOdometer::restart(const PioneerModel& model) {
  model_ = model;
  epoch_ += last_ ? 1 : 0;
  last_.reset();
  twist_body_ = {};
  elsewhere_.reset();
  agreeing_ = 0;
}

ReportClock::Elapsed PioneerOdometer::elapsed(const Sip& sip) const {
  if (!last_) {
    return {};
  }
  const Pose2 moved = pose(counts_).inverse() * pose(continued(counts_, sip));
  const Twist2 now = twist_of(sip, model_);
  // The mean velocity is that in the middle, but for what it gained and lost again meanwhile, and
  // for the last 50 ms of which a controller's velocity is the mean.
  const auto tells = [](double s, double moved_by, double before, double after, double accel,
                        double rounding) {
    const double unknown = accel * s * (s / 4 + kVelocityOf_s) + rounding;
    return std::abs(moved_by - s * (before + after) / 2) <= unknown;
  };
  // The shortest time that fits, and the longest without a break: it might have stopped for a while
  // and gone on, but seldom does.
  ReportClock::Elapsed elapsed{std::numeric_limits<double>::infinity(), 0};
  for (double s = kTellStep_s; s <= kTellMost_s; s += kTellStep_s) {
    if (tells(s, moved.x_m, twist_body_.v_mps, now.v_mps, kAccel_mps2, kDistanceRounding_m) &&
        tells(s, moved.theta_rad, twist_body_.w_radps, now.w_radps, kTurnAccel_radps2,
              kTurnRounding_rad)) {
      elapsed.least_s = std::min(elapsed.least_s, s);
      elapsed.most_s = s;
    } else if (elapsed.most_s > 0) {
      break;
    }
  }
  if (elapsed.most_s == 0) {  // it was stopped harder than that, or pushed
    return {};
  }
  if (elapsed.most_s + kTellStep_s > kTellMost_s) {
    elapsed.most_s = std::numeric_limits<double>::infinity();
  }
  return elapsed;
}

PioneerOdometer::Verdict PioneerOdometer::add(Time stamp, const Sip& sip, const Twist2& most,
                                              Duration apart, Duration gap) {
  const auto faster = [&](std::int16_t count) {
    return std::abs(model_.speed_mps * count) > kTopSpeed_mps;
  };
  if (faster(sip.left) || faster(sip.right)) {
    return Verdict::kImplausible;
  }
  Candidate report{stamp, continued(last_ ? counts_ : Counts{}, sip), twist_of(sip, model_)};
  if (!last_) {
    rebase(report);
    take(report);
    return Verdict::kAccepted;
  }
  const double dt_s = to_seconds(apart > Duration::zero() ? apart : stamp - *last_);
  const double longest_s = std::max(dt_s, to_seconds(gap));
  const double v_mps = std::max(std::abs(twist_body_.v_mps), most.v_mps);
  const double w_radps = std::max(std::abs(twist_body_.w_radps), most.w_radps);
  const bool wrapped = v_mps * longest_s + kSlack_m >= model_.distance_m * kModulus / 2 ||
                       w_radps * longest_s + kSlack_rad >= std::numbers::pi;
  const Candidate last{*last_, counts_, twist_body_};
  const bool believed =
      near(last, report, dt_s, most) || (longest_s > dt_s && near(last, report, longest_s, most));
  if (believed && !wrapped) {
    take(report);
    return Verdict::kAccepted;
  }
  if (!wrapped) {
    if (elsewhere_) {
      report.counts = continued(elsewhere_->counts, sip);
    }
    const auto agrees = [&](const Candidate& before) {
      return near(before, report, to_seconds(stamp - before.stamp), most);
    };
    agreeing_ = elsewhere_ && agrees(*elsewhere_) ? agreeing_ + 1 : 1;
    elsewhere_ = report;
    if (agreeing_ < kAgreeing) {
      return Verdict::kImplausible;
    }
  }
  ++epoch_;
  rebase(report);
  take(report);
  return Verdict::kDiscontinuity;
}

}  // namespace panoptes::hw
