// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/eval/truth.h"
#include "core/geometry/pose2.h"
#include "core/loops/closure.h"

namespace panoptes {

/// A stretch of keyframes that truly were where the robot had been before.
struct TrueRevisit {
  Heading heading = Heading::kSame;
  int first = 0;  ///< keyframes
  int last = 0;
};

struct RelativePoseError {
  int translations = 0;  ///< closures that claim one
  int rotations = 0;
  double median_m = 0;
  double p95_m = 0;
  double median_deg = 0;
  double p95_deg = 0;
};

struct LoopFigures {
  int accepted = 0;  ///< right ones at most once a revisit, wrong ones each
  int same_heading = 0;
  int opposite_heading = 0;
  int other_heading = 0;  ///< where other cameras see the same; no revisit counts them
  struct {
    int correct = 0;
    int wrong = 0;
    RelativePoseError error_same;
    RelativePoseError error_opposite;
    int revisits_same = 0;
    int revisits_opposite = 0;
    int recalled_same = 0;
    int recalled_opposite = 0;
  } against_truth;
};

/// Way driven up to each pose.
std::vector<double> path_lengths_m(const std::vector<Pose2>& T_frame_body);

/// True positions within 0.5 m and the true heading difference within 20 degrees of the claimed
/// one.
bool is_correct(const ClosureReport& closure, const std::vector<Pose2>& true_T_scene_body);

/// Keyframe i is on a revisit when an earlier j exists with at least 5 m of true path between them,
/// true positions within 0.5 m, headings within 20 degrees or beyond 160, and three keyframes on
/// each side of both. Those of one class with gaps under 1 m of true path are one revisit.
/// `path_m` is the true path length up to each keyframe.
std::vector<TrueRevisit> revisits(const std::vector<Pose2>& true_T_scene_body,
                                  const std::vector<double>& path_m);

/// The figures of the accepted closures among `closures`. Without truth `true_T_scene_body` is
/// empty, `path_m` is by odometry, and right closures are told apart by gaps of 1 m alone. A
/// closure claims a translation when it is surer of it than the 0.5 m that make it right, a
/// rotation when surer than 20 degrees.
LoopFigures loop_figures(const std::vector<ClosureReport>& closures,
                         const std::vector<Pose2>& true_T_scene_body,
                         const std::vector<double>& path_m);

}  // namespace panoptes
