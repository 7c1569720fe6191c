// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_camera_check.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace panoptes {
namespace {

constexpr int kSteps = 4;  // of a stretch: 0.6 m of driving, or a turn by 40 degrees or more
// Stretches that are looked at together.
constexpr std::array<int, 5> kWindows{3, 4, 6, 8, 12};
constexpr int kSettled = 12;  // are learned from before any is judged
constexpr int kJump = 5;      // the states that are tested for a jump, which are the first
// Of the jump's freedoms: by chance once in 10^4 tests, each with one stretch left out.
constexpr double kLeastGain = 25;
constexpr double kTurned_rad = deg_to_rad(2);
constexpr double kShifted_m = 0.02;
constexpr double kClock_s = 0.01;

// Of what is off before anything was seen, and of a jump.
FloorState prior_sigma() {
  FloorState sigma;
  sigma << Vec3::Constant(kTurned_rad), Vec3::Constant(kShifted_m), kClock_s;
  return sigma;
}

// What a lens that is not as believed makes of the states depends on where the texture lies, and
// what slipping wheels make of them on how the robot drives: those look like another height.
FloorState wander_sigma() {
  FloorState sigma;
  sigma << Vec3::Constant(deg_to_rad(0.15)), 0.002, 0.002, kShifted_m, 0.005;
  return sigma;
}

// A body that tilts by more than this, one sigma, hides a knock and may look like one.
constexpr double kTilts_rad = deg_to_rad(0.5);

FloorInformation diagonal(const FloorState& sigma) { return sigma.cwiseAbs2().asDiagonal(); }

// What a stretch shows of all, where it is off by a covariance of its own.
FloorEvidence softened(const FloorEvidence& evidence, const FloorInformation& covariance) {
  const Eigen::PartialPivLU<FloorInformation> spread(FloorInformation::Identity() +
                                                     evidence.information * covariance);
  return {spread.solve(evidence.information), spread.solve(evidence.vector)};
}

}  // namespace

void FloorCameraCheck::Known::add(const Stretch& stretch) {
  evidence += stretch.evidence;
  excess += stretch.excess;
  weight += stretch.weight;
  ++stretches;
}

FloorInformation FloorCameraCheck::Known::covariance() const {
  return (evidence.information + diagonal(prior_sigma().cwiseInverse())).inverse();
}

// By moments (DerSimonian and Laird 1986).
FloorInformation FloorCameraCheck::Known::between_stretches() const {
  FloorInformation covariance = FloorInformation::Zero();
  for (int state = 0; state < kJump; ++state) {
    if (weight[state] > 0) {
      covariance(state, state) = std::max(0.0, excess[state] / weight[state]);
    }
  }
  return covariance;
}

FloorCameraCheck::Stretch FloorCameraCheck::Known::compare(const FloorEvidence& next) const {
  constexpr double kShown = 0.5;  // of a state, by a stretch that counts
  constexpr double kOdd = 16;     // of what is expected: one such stretch says no more of others
  const FloorInformation known = covariance();
  const FloorState rest = next.vector - next.information * (known * evidence.vector);
  const FloorInformation solve =
      (next.information + diagonal(prior_sigma().cwiseInverse())).inverse();
  const FloorState off = solve * rest;
  const FloorInformation shown = solve * next.information;
  const FloorInformation claimed = shown * (solve + known * shown.transpose());
  const FloorInformation wanders = between_stretches() + diagonal(wander_sigma());
  Stretch stretch{next};
  for (int state = 0; state < kJump; ++state) {
    if (shown(state, state) > kShown) {
      const double by_one = shown(state, state) * shown(state, state);
      const double square = std::min(
          off[state] * off[state], kOdd * (claimed(state, state) + by_one * wanders(state, state)));
      stretch.excess[state] = square / claimed(state, state) - 1;
      stretch.weight[state] = by_one / claimed(state, state);
    }
  }
  return stretch;
}

FloorCameraCheck::Gain FloorCameraCheck::gain(const Known& before, const FloorEvidence& lately) {
  FloorInformation covariance = before.covariance();
  const FloorState state = covariance * before.evidence.vector;
  covariance += before.between_stretches() / before.stretches + diagonal(wander_sigma());
  const FloorEvidence shown =
      softened({lately.information, lately.vector - lately.information * state}, covariance);
  using Square = Eigen::Matrix<double, kJump, kJump>;
  Square information = shown.information.topLeftCorner<kJump, kJump>();
  information = 0.5 * (information + information.transpose()).eval();
  information.diagonal() += prior_sigma().head<kJump>().cwiseAbs2().cwiseInverse();
  const Eigen::Matrix<double, kJump, 1> jump = information.ldlt().solve(shown.vector.head<kJump>());
  return {shown.vector.head<kJump>().dot(jump), {jump.head<3>(), jump.tail<2>()}};
}

std::optional<FloorKnock> FloorCameraCheck::judge() const {
  const int count = static_cast<int>(lately_.size());
  for (const int window : kWindows) {
    if (window > count || before_.stretches + count - window < kSettled) {
      break;
    }
    const auto since = lately_.end() - window;
    Known before = before_;
    std::for_each(lately_.begin(), since, [&](const Stretch& one) { before.add(one); });
    const FloorInformation between = before.between_stretches();
    if (between.diagonal().head<2>().maxCoeff() > kTilts_rad * kTilts_rad) {
      continue;
    }
    FloorEvidence sum;
    std::vector<FloorEvidence> since_then;
    for (auto one = since; one != lately_.end(); ++one) {
      since_then.push_back(softened(one->evidence, between));
      sum += since_then.back();
    }
    const Gain all = gain(before, sum);
    double least = all.chi2;
    for (std::size_t out = 0; out < since_then.size() && least >= kLeastGain; ++out) {
      FloorEvidence rest = sum;
      rest -= since_then[out];
      least = std::min(least, gain(before, rest).chi2);
    }
    if (least >= kLeastGain) {
      return all.jump;
    }
  }
  return std::nullopt;
}

std::optional<FloorKnock> FloorCameraCheck::add(const FloorEvidence& evidence) {
  open_ += evidence;
  if (++steps_ < kSteps) {
    return std::nullopt;
  }
  Known all = before_;
  for (const Stretch& stretch : lately_) {
    all.add(stretch);
  }
  lately_.push_back(all.compare(open_));
  open_ = {};
  steps_ = 0;
  if (static_cast<int>(lately_.size()) > kWindows.back()) {
    before_.add(lately_.front());
    lately_.pop_front();
  }
  return judge();
}

}  // namespace panoptes
