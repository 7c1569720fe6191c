// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/jump_check.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "core/geometry/pose2.h"

namespace panoptes {
namespace {

using Square = Eigen::Matrix<double, kMountingStates, kMountingStates>;

// Looked at with as few as show a jump at all,
constexpr int kLookBefore = 5;
constexpr int kLookAfter = 4;
constexpr int kLookMost = 22;
// and judged with as many as show depths; again with more, which a shift along the camera's axis
// may take.
constexpr int kJudgeBefore = 12;
constexpr std::array<int, 3> kJudgeAfter{11, 14, 20};
constexpr int kJudgeMost = 45;
static_assert(kJudgeBefore + kJudgeAfter.back() <= KeyframeOdometry::kRemembered);

// Evidence as a chi square of the five freedoms of a knock. Of a thousand keyframes without one
// some seventy were suspicious, and none came to 18 by all and to 14 by each part of the picture.
constexpr double kSuspicious = 12;
constexpr double kForgotten = 8;  // no longer, when judged
constexpr double kKnocked = 20;
constexpr double kOfAnyPart = 14;
constexpr double kPlainly = 8;     // more than any other camera's
constexpr double kFitting = 0.45;  // of the tracks that go past it
constexpr int kFewest = 20;        // of these, to judge a camera by

// What a jump is surely not known by: things that move a little, and corners that follow edges.
constexpr double kNeverSurer_rad = deg_to_rad(0.04);
constexpr double kNeverSurer_m = 0.001;
// Stands for nothing known, so that everything has an inverse.
constexpr double kUnknown = 10;  // rad and m

struct Verdict {
  int camera = 0;
  double evidence = 0;
  double of_others = 0;
  MountingChange change = MountingChange::Zero();
};

// A covariance that is nowhere below what the information claims, nor below what the scatter shows.
Square covariance_of(const Square& information, const Square& scatter) {
  const Eigen::LLT<Square> root(information);
  const auto L = root.matrixL();
  Square half = L.solve(scatter);
  half = L.solve(half.transpose().eval()).eval();
  const Eigen::SelfAdjointEigenSolver<Square> shown(half);
  const Square back = root.matrixU().solve(shown.eigenvectors());
  return back * shown.eigenvalues().cwiseMax(1.0).asDiagonal() * back.transpose();
}

// How much better a jump of this camera, and of no other, explains all. What looks like a change of
// height is no evidence: somebody who walks towards the camera makes the same.
double evidence_of(const MountingJump& jump, int camera, MountingChange& change) {
  const int first = camera * kMountingStates;
  Square information = jump.information.block<kMountingStates, kMountingStates>(first, first);
  Square scatter = jump.scatter.block<kMountingStates, kMountingStates>(first, first);
  constexpr double kNothing = 1 / (kUnknown * kUnknown);
  information.diagonal().array() += kNothing;
  scatter.diagonal().array() += kNothing;
  const MountingChange seen = information.ldlt().solve(jump.pull.segment<kMountingStates>(first));
  Square covariance = covariance_of(information, scatter);
  MountingChange never_surer;
  never_surer << kNeverSurer_rad, kNeverSurer_rad, kNeverSurer_rad, kNeverSurer_m, kNeverSurer_m,
      kNeverSurer_m;
  covariance.diagonal() += never_surer.cwiseAbs2();
  Square known = covariance.inverse();
  const MountingChange pull = known * seen;
  known.diagonal() += mounting_jump_sigmas().cwiseAbs2().cwiseInverse();
  change = known.ldlt().solve(pull);
  return pull.dot(change) - pull[kHeight] * pull[kHeight] / known(kHeight, kHeight);
}

// None where too small a share fits of what some camera shows, nor by the wheels alone, which slip.
Verdict verdict(const MountingJump& jump, double least_share) {
  Verdict best;
  int witnesses = 0;
  for (int camera = 0; camera < static_cast<int>(jump.crossing.size()); ++camera) {
    if (jump.crossing[camera] < kFewest) {
      continue;
    }
    if (jump.fitting[camera] < least_share * jump.crossing[camera]) {
      return {};
    }
    ++witnesses;
    Verdict one{camera};
    one.evidence = evidence_of(jump, camera, one.change);
    one.of_others = best.evidence;
    if (one.evidence > best.evidence) {
      best = one;
    } else {
      best.of_others = std::max(best.of_others, one.evidence);
    }
  }
  return witnesses > 1 ? best : Verdict{};
}

bool is_knock(const Verdict& verdict) {
  return verdict.evidence >= kKnocked && verdict.evidence >= verdict.of_others + kPlainly;
}

}  // namespace

void JumpCheck::look(int newest, const Shows& shows) {
  const int at = newest - kLookAfter + 1;
  if (at - kLookBefore < first_) {
    return;
  }
  if (verdict(shows(at, kLookBefore, kLookMost, {}), kFitting).evidence >= kSuspicious) {
    suspicions_.push_back({at});
  }
}

bool JumpCheck::is_due(const Suspicion& suspicion, int newest) const {
  return newest - suspicion.keyframe + 1 >= kJudgeAfter[suspicion.judged];
}

bool JumpCheck::to_judge(int newest) const {
  return std::any_of(suspicions_.begin(), suspicions_.end(),
                     [&](const Suspicion& one) { return is_due(one, newest); });
}

std::optional<Knock> JumpCheck::judge(int newest, const Shows& shows) {
  const auto due = std::find_if(suspicions_.begin(), suspicions_.end(),
                                [&](const Suspicion& one) { return is_due(one, newest); });
  if (due == suspicions_.end()) {
    return std::nullopt;
  }
  int at = due->keyframe;
  const auto judged = [&](int keyframe,
                          const std::optional<KeyframeOdometry::PictureThird>& without) {
    return verdict(shows(keyframe, std::min(kJudgeBefore, keyframe - first_), kJudgeMost, without),
                   without ? 0 : kFitting);
  };
  Verdict best = judged(at, {});
  if (++due->judged == kJudgeAfter.size() || best.evidence < kForgotten) {
    suspicions_.erase(due);
  }
  if (!is_knock(best)) {
    return std::nullopt;
  }
  // many before and after show a jump at keyframes about the one at which it was
  std::vector<int> others;
  for (const Suspicion& one : suspicions_) {
    others.push_back(one.keyframe);
  }
  for (int keyframe = newest - kLookAfter + 2; keyframe <= newest; ++keyframe) {
    others.push_back(keyframe);  // not looked at yet
  }
  for (const int keyframe : others) {
    const Verdict one = judged(keyframe, {});
    if (one.evidence > best.evidence) {
      best = one;
      at = keyframe;
    }
  }
  if (!is_knock(best) || at > newest - kLookAfter + 1) {
    return std::nullopt;
  }
  for (int third = 0; third < 3; ++third) {
    const Verdict rest = judged(at, KeyframeOdometry::PictureThird{best.camera, third});
    if (rest.camera != best.camera || rest.evidence < kOfAnyPart) {
      return std::nullopt;
    }
  }
  return Knock{best.camera, at - 1, at, best.change};
}

}  // namespace panoptes
