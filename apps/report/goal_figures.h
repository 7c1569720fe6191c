// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "apps/report/finished_run.h"
#include "core/eval/truth.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// What a run made of a goal that it was told; what does not apply or is not known is empty.
struct GoalFigures {
  Vec2 goal_map = Vec2::Zero();
  bool reached = false;  ///< with truth: the true body at rest within 0.15 m, where it says so
  bool said_reached = false;
  bool refused = false;
  std::string why;  ///< it was refused
  std::optional<double> began_s;
  std::optional<double> time_s;      ///< that it was the present one
  std::optional<double> moved_m;     ///< meanwhile, truly, or without truth by the wheels
  std::optional<double> shortest_m;  ///< from where it began, for a disc on the true floor
  std::optional<double> true_error_m;
};

/// `truth` may be null; `reachable` is what a disc can reach in it, null where that is not known.
std::vector<GoalFigures> goal_figures(const FinishedRun& run, const Truth* truth,
                                      const Pose2& T_scene_map, const TruthLayer* reachable);

nlohmann::ordered_json goals_json(const std::vector<GoalFigures>& goals);

/// What has become of it, a line for people.
std::string goal_line(std::size_t number, const GoalFigures& goal);

/// The goals as metrics.json holds them, of a run as it was left.
std::vector<GoalProgress> goals_from(const nlohmann::ordered_json& goals);

}  // namespace panoptes
