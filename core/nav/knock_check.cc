// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/knock_check.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/motion/local_bundle.h"

namespace panoptes {
namespace {

// Bundles that are looked at together: a turned camera may show in each of two, one that is shifted
// takes many.
constexpr std::array<int, 6> kWindows{2, 3, 4, 5, 8, 12};
// Of the change's five freedoms that bundles show: by chance once in 10^4 tests, each with one
// bundle left out.
constexpr double kLeastGain = 25;
constexpr double kPlainly = 2;  // times what any other camera's jump would explain
// The first bundles are linearised about a rig that is hardly known.
constexpr int kSettled = 8;

StateSystem at_state(const StateSystem& shows, const RigState& of, const RigState& state) {
  return {shows.information, shows.gradient + shows.information * (state - of)};
}

}  // namespace

// What the bundles from `first` on show together, about what was known before them.
StateSystem KnockCheck::sum_of(int first) const {
  const RigState& state = bundles_[first].state;
  StateSystem sum{Eigen::MatrixXd::Zero(state.size(), state.size()), RigState::Zero(state.size())};
  for (std::size_t k = first; k < bundles_.size(); ++k) {
    const StateSystem one = at_state(bundles_[k].shows, bundles_[k].state, state);
    sum.information += one.information;
    sum.gradient += one.gradient;
  }
  return sum;
}

KnockCheck::Gain KnockCheck::gain(const Bundle& before, const StateSystem& shown,
                                  int camera) const {
  const Eigen::Index states = before.state.size();
  const Eigen::MatrixXd M = shown.information / before.variance_factor;
  const Eigen::PartialPivLU<Eigen::MatrixXd> spread(Eigen::MatrixXd::Identity(states, states) +
                                                    M * before.covariance);
  const int first = camera_state(camera);
  const Eigen::MatrixXd known = spread.solve(M.middleCols(first, kMountingStates));
  const RigState off = -spread.solve(shown.gradient / before.variance_factor);
  using Square = Eigen::Matrix<double, kMountingStates, kMountingStates>;
  Square information = known.middleRows(first, kMountingStates);
  information = 0.5 * (information + information.transpose()).eval();
  information.diagonal() += mounting_jump_sigmas().cwiseAbs2().cwiseInverse();
  const MountingChange right = off.segment<kMountingStates>(first);
  Gain of;
  of.change = information.ldlt().solve(right);
  of.chi2 = right.dot(of.change);
  return of;
}

// By what the bundles since explain best, at most so many.
Knock KnockCheck::since_when(int camera, int at_most) const {
  Knock knock{camera};
  double most = 0;
  const int count = static_cast<int>(bundles_.size());
  for (int bundles = kWindows.front(); bundles <= at_most; ++bundles) {
    const Gain one = gain(bundles_[count - bundles], sum_of(count - bundles), camera);
    if (one.chi2 > most) {
      most = one.chi2;
      knock.begin = bundles_[std::max(0, count - bundles - 1)].begin;
      knock.end = bundles_[count - bundles].end;
      knock.change = one.change;
    }
  }
  return knock;
}

std::optional<Knock> KnockCheck::add(const JointEdge& bundle, const RigState& state,
                                     const Eigen::MatrixXd& covariance, double variance_factor) {
  ++seen_;
  bundles_.push_back({bundle.first, bundle.first + static_cast<int>(bundle.T_first_node.size()),
                      of_states(bundle, state), state, covariance, variance_factor});
  if (static_cast<int>(bundles_.size()) > kWindows.back() + 1) {  // and the one before them
    bundles_.pop_front();
  }
  const int cameras = static_cast<int>(state.size() - kWheelStates) / kCameraStates;
  const int count = static_cast<int>(bundles_.size());
  const int at_most = std::min(seen_ - kSettled, kWindows.back());
  for (const int window : kWindows) {
    if (window > at_most) {
      break;
    }
    const int first = count - window;
    const Bundle& before = bundles_[first];
    const StateSystem all = sum_of(first);
    int knocked = 0;
    Gain best;
    double second = 0;
    for (int camera = 0; camera < cameras; ++camera) {
      const Gain one = gain(before, all, camera);
      second = std::max(second, std::min(one.chi2, best.chi2));
      if (one.chi2 > best.chi2) {
        best = one;
        knocked = camera;
      }
    }
    if (best.chi2 < std::max(kLeastGain, kPlainly * second)) {
      continue;
    }
    double least = best.chi2;
    for (int out = 0; out < window; ++out) {
      const Bundle& odd = bundles_[first + out];
      const StateSystem one = at_state(odd.shows, odd.state, before.state);
      const StateSystem rest{all.information - one.information, all.gradient - one.gradient};
      least = std::min(least, gain(before, rest, knocked).chi2);
    }
    if (least >= kLeastGain) {
      return since_when(knocked, at_most);
    }
  }
  return std::nullopt;
}

}  // namespace panoptes
