// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/loops.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "core/base/check.h"
#include "core/eval/statistics.h"

namespace panoptes {
namespace {

constexpr double kNear_m = 0.5;
constexpr double kNear_rad = deg_to_rad(20);
constexpr double kBetween_m = 5.0;  // of true path between the two visits
constexpr double kGap_m = 1.0;      // beyond which a revisit is another one
constexpr int kAround = 3;          // keyframes on each side: the seven of the thesis

std::size_t at(int keyframe) { return static_cast<std::size_t>(keyframe); }

Pose2 relative(const ClosureReport& closure, const std::vector<Pose2>& T_scene_body) {
  return T_scene_body[at(closure.earlier)].inverse() * T_scene_body[at(closure.recent)];
}

/// The stretch of this class that the keyframe lies on, or nearly; -1 when there is none.
int revisit_of(const ClosureReport& closure, const std::vector<TrueRevisit>& stretches,
               const std::vector<double>& path_m) {
  const double here_m = path_m[at(closure.recent)];
  for (std::size_t k = 0; k < stretches.size(); ++k) {
    const TrueRevisit& stretch = stretches[k];
    if (stretch.heading == closure.heading && here_m > path_m[at(stretch.first)] - kGap_m &&
        here_m < path_m[at(stretch.last)] + kGap_m) {
      return static_cast<int>(k);
    }
  }
  return -1;
}

RelativePoseError relative_pose_error(const std::vector<ClosureReport>& accepted, Heading heading,
                                      const std::vector<Pose2>& true_T_scene_body) {
  std::vector<double> away_m;
  std::vector<double> away_deg;
  for (const ClosureReport& closure : accepted) {
    if (closure.heading != heading) {
      continue;
    }
    const Pose2 truth = relative(closure, true_T_scene_body);
    const Pose2& claim = closure.T_earlier_recent;
    const Mat2 information = closure.information.topLeftCorner<2, 2>();
    const double weakest =
        Eigen::SelfAdjointEigenSolver<Mat2>(information, Eigen::EigenvaluesOnly).eigenvalues()[0];
    if (weakest > 1 / (kNear_m * kNear_m)) {
      away_m.push_back((claim.position() - truth.position()).norm());
    }
    if (closure.information(2, 2) > 1 / (kNear_rad * kNear_rad)) {
      away_deg.push_back(rad_to_deg(std::abs(wrap_angle(claim.theta_rad - truth.theta_rad))));
    }
  }
  RelativePoseError error;
  error.translations = static_cast<int>(away_m.size());
  error.rotations = static_cast<int>(away_deg.size());
  if (!away_m.empty()) {
    error.median_m = quantile(away_m, 0.5);
    error.p95_m = quantile(away_m, 0.95);
  }
  if (!away_deg.empty()) {
    error.median_deg = quantile(away_deg, 0.5);
    error.p95_deg = quantile(away_deg, 0.95);
  }
  return error;
}

}  // namespace

std::vector<double> path_lengths_m(const std::vector<Pose2>& T_frame_body) {
  std::vector<double> lengths(T_frame_body.size(), 0);
  for (std::size_t i = 1; i < T_frame_body.size(); ++i) {
    lengths[i] =
        lengths[i - 1] + (T_frame_body[i].position() - T_frame_body[i - 1].position()).norm();
  }
  return lengths;
}

bool is_correct(const ClosureReport& closure, const std::vector<Pose2>& true_T_scene_body) {
  const Pose2 truth = relative(closure, true_T_scene_body);
  return truth.position().norm() <= kNear_m &&
         std::abs(wrap_angle(truth.theta_rad - closure.T_earlier_recent.theta_rad)) <= kNear_rad;
}

std::vector<TrueRevisit> revisits(const std::vector<Pose2>& true_T_scene_body,
                                  const std::vector<double>& path_m) {
  PANOPTES_CHECK(path_m.size() == true_T_scene_body.size(), "a path length for every keyframe");
  const int count = static_cast<int>(true_T_scene_body.size());
  std::vector<TrueRevisit> stretches;
  for (const Heading heading : {Heading::kSame, Heading::kOpposite}) {
    const std::size_t before = stretches.size();
    for (int i = kAround; i + kAround < count; ++i) {
      const Pose2& here = true_T_scene_body[at(i)];
      bool seen_before = false;
      for (int j = kAround; j < i && path_m[at(i)] - path_m[at(j)] >= kBetween_m; ++j) {
        const Pose2& there = true_T_scene_body[at(j)];
        const double turned_rad = std::abs(wrap_angle(here.theta_rad - there.theta_rad));
        const bool of_class = heading == Heading::kSame ? turned_rad <= kNear_rad
                                                        : turned_rad >= deg_to_rad(180) - kNear_rad;
        if (of_class && (here.position() - there.position()).norm() <= kNear_m) {
          seen_before = true;
          break;
        }
      }
      if (!seen_before) {
        continue;
      }
      if (stretches.size() > before && path_m[at(i)] - path_m[at(stretches.back().last)] < kGap_m) {
        stretches.back().last = i;
      } else {
        stretches.push_back({heading, i, i});
      }
    }
  }
  return stretches;
}

LoopFigures loop_figures(const std::vector<ClosureReport>& closures,
                         const std::vector<Pose2>& true_T_scene_body,
                         const std::vector<double>& path_m) {
  std::vector<ClosureReport> accepted;
  for (const ClosureReport& closure : closures) {
    if (closure.accepted) {
      accepted.push_back(closure);
    }
  }
  std::stable_sort(accepted.begin(), accepted.end(),
                   [](const auto& a, const auto& b) { return a.recent < b.recent; });
  const bool known = !true_T_scene_body.empty();
  const std::vector<TrueRevisit> stretches =
      known ? revisits(true_T_scene_body, path_m) : std::vector<TrueRevisit>{};
  std::vector<bool> recalled(stretches.size(), false);

  LoopFigures figures;
  for (const Heading heading : {Heading::kSame, Heading::kOpposite, Heading::kOther}) {
    int& of_class = heading == Heading::kSame       ? figures.same_heading
                    : heading == Heading::kOpposite ? figures.opposite_heading
                                                    : figures.other_heading;
    const ClosureReport* previous = nullptr;  // the last right one off every revisit
    for (const ClosureReport& closure : accepted) {
      if (closure.heading != heading) {
        continue;
      }
      if (known && !is_correct(closure, true_T_scene_body)) {
        ++figures.against_truth.wrong;
        ++of_class;
        continue;
      }
      const int stretch = revisit_of(closure, stretches, path_m);
      bool counted = false;  // another closure of this revisit was
      if (stretch >= 0) {
        counted = recalled[at(stretch)];
        recalled[at(stretch)] = true;
      } else {
        counted = previous != nullptr &&
                  path_m[at(closure.recent)] - path_m[at(previous->recent)] < kGap_m;
        previous = &closure;
      }
      if (!counted) {
        figures.against_truth.correct += known ? 1 : 0;
        ++of_class;
      }
    }
  }
  figures.accepted = figures.same_heading + figures.opposite_heading + figures.other_heading;
  if (!known) {
    return figures;
  }
  auto& t = figures.against_truth;
  t.error_same = relative_pose_error(accepted, Heading::kSame, true_T_scene_body);
  t.error_opposite = relative_pose_error(accepted, Heading::kOpposite, true_T_scene_body);
  for (std::size_t k = 0; k < stretches.size(); ++k) {
    const bool same = stretches[k].heading == Heading::kSame;
    ++(same ? t.revisits_same : t.revisits_opposite);
    if (recalled[k]) {
      ++(same ? t.recalled_same : t.recalled_opposite);
    }
  }
  return figures;
}

}  // namespace panoptes
