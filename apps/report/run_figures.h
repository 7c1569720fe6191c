// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/recognition/recognition_study.h"
#include "apps/report/finished_run.h"
#include "apps/report/goal_figures.h"
#include "core/eval/coverage.h"
#include "core/eval/truth.h"

namespace panoptes {

/// The truth of a run from its first frame set on, as far as somebody knows it.
struct RunTruth {
  Truth truth;                ///< layers may be empty
  bool touches_known = true;  ///< its contacts and clearances
};

/// Everything about a finished run that more than one file needs.
struct RunFindings {
  const RunTruth* known = nullptr;  ///< null without truth
  Pose2 T_scene_map;                ///< identity without truth
  std::vector<Pose2> T_map_body;    ///< of keyframes
  std::vector<Pose2> T_map_frame;   ///< of frame sets: the last keyframe carried on by the wheels
  std::vector<Pose2> T_scene_estimate;
  std::vector<Pose2> T_scene_odometry;
  std::vector<Pose2> true_T_scene_body;
  std::vector<double> path_m;  ///< path length up to each keyframe, by odometry without truth
  std::vector<ClosureReport> closures;
  std::optional<TruthLayer> reachable;
  std::vector<GoalFigures> goals;        ///< one per goal of the run
  std::vector<CoverageSample> coverage;  ///< the last one of the finished map

  /// Every sample has a share, so that when it passed another one is known.
  bool covered_throughout() const;
};

/// `known` may be null and outlives the findings.
RunFindings find_out(const FinishedRun& run, const RunTruth* known);

/// What metrics.json holds of a run, and what follows from it.
struct RunVerdict {
  std::string metrics_json;
  int exit_status = 0;
  std::vector<std::string> summary;  ///< a few lines for people
};

/// `places` are the rows of a study of recognition, else empty. `others` is a JSON object with the
/// figures that are known already, such as what the run cost; where a figure is found here it
/// counts.
RunVerdict judge_run(const FinishedRun& run, const RunFindings& findings,
                     const std::vector<RecognitionRow>& places, std::string_view others);

/// What can be said of a run whose figures cannot be found: which it was, and how it ended.
RunVerdict bare_verdict(const FinishedRun& run);

}  // namespace panoptes
