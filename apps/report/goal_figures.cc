// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/goal_figures.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/eval/shortest_path.h"

namespace panoptes {
namespace {

constexpr double kReached_m = 0.15;
constexpr double kRest_mps = 0.02;
constexpr double kRest_radps = 0.05;

template <class Pose>
const Pose* last_until(const std::vector<Pose>& poses, Time stamp) {
  const auto after = std::upper_bound(poses.begin(), poses.end(), stamp,
                                      [](Time t, const Pose& pose) { return t < pose.stamp; });
  return after == poses.begin() ? nullptr : &*(after - 1);
}

template <class Pose, class Position>
double way_m(const std::vector<Pose>& poses, Time from, Time to, const Position& position) {
  double moved_m = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if (poses[i - 1].stamp >= from && poses[i].stamp <= to) {
      moved_m += (position(poses[i]) - position(poses[i - 1])).norm();
    }
  }
  return moved_m;
}

/// The double nearest to the whole nanoseconds, which prints short.
double short_seconds(Duration d) { return static_cast<double>(d.count()) / 1e9; }

bool at_rest(const Twist2& twist) {
  return std::abs(twist.v_mps) <= kRest_mps && std::abs(twist.w_radps) <= kRest_radps;
}

}  // namespace

std::vector<GoalFigures> goal_figures(const FinishedRun& run, const Truth* truth,
                                      const Pose2& T_scene_map, const TruthLayer* reachable) {
  std::vector<GoalFigures> all;
  for (const GoalProgress& goal : run.goals) {
    GoalFigures& figures = all.emplace_back();
    figures.goal_map = goal.goal_map;
    figures.said_reached = goal.state == GoalProgress::State::kReached;
    figures.reached = figures.said_reached;
    figures.refused = goal.state == GoalProgress::State::kRefused;
    figures.why = goal.why;
    if (!goal.began) {
      continue;
    }
    const Time from = *goal.began;
    const Time to = goal.ended.value_or(run.last_step);
    figures.began_s = short_seconds(from.time_since_epoch());
    figures.time_s = short_seconds(to - from);
    if (truth == nullptr) {
      figures.moved_m = way_m(run.frames, from, to, [](const FinishedRun::Frame& frame) {
        return frame.T_odom_body.position();
      });
      continue;
    }
    figures.moved_m = way_m(truth->poses, from, to,
                            [](const TruePose& pose) { return pose.T_scene_body.position(); });
    const Vec2 goal_scene = T_scene_map * goal.goal_map;
    if (const TruePose* start = last_until(truth->poses, from); start && reachable != nullptr) {
      figures.shortest_m =
          shortest_path_m(*reachable, start->T_scene_body.position(), goal_scene, kReached_m);
    }
    if (const TruePose* end = last_until(truth->poses, to)) {
      figures.true_error_m = (end->T_scene_body.position() - goal_scene).norm();
      figures.reached =
          figures.said_reached && *figures.true_error_m <= kReached_m && at_rest(end->twist_body);
    }
  }
  return all;
}

nlohmann::ordered_json goals_json(const std::vector<GoalFigures>& goals) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const GoalFigures& goal : goals) {
    nlohmann::ordered_json json{{"x_m", goal.goal_map.x()},
                                {"y_m", goal.goal_map.y()},
                                {"reached", goal.reached},
                                {"refused", goal.refused}};
    if (goal.refused) {
      json["why"] = goal.why;
    }
    const auto put = [&json](const char* key, const std::optional<double>& value) {
      if (value) {
        json[key] = *value;
      }
    };
    put("began_s", goal.began_s);
    put("time_s", goal.time_s);
    put("moved_m", goal.moved_m);
    put("path_m", goal.reached ? goal.moved_m : std::nullopt);
    put("shortest_m", goal.shortest_m);
    put("true_error_m", goal.true_error_m);
    all.push_back(std::move(json));
  }
  return all;
}

std::string goal_line(std::size_t number, const GoalFigures& goal) {
  std::string line =
      fmt::format("goal {} ({:.2f}, {:.2f}): ", number, goal.goal_map.x(), goal.goal_map.y());
  if (!goal.began_s) {
    return line + "not begun";
  }
  line += fmt::format("{} after {:.1f} s",
                      goal.said_reached ? "reached"
                      : goal.refused    ? "refused"
                                        : "not reached",
                      *goal.time_s);
  if (goal.refused) {
    return line + ": " + goal.why;
  }
  line += fmt::format(", {:.1f} m driven", *goal.moved_m);
  if (goal.shortest_m) {
    line += fmt::format(", the shortest way is {:.1f} m", *goal.shortest_m);
  }
  if (goal.true_error_m) {
    line += fmt::format(", {:.2f} m from it", *goal.true_error_m);
  }
  return line + (goal.said_reached && !goal.reached ? ": not there by the truth" : "");
}

std::vector<GoalProgress> goals_from(const nlohmann::ordered_json& goals) {
  std::vector<GoalProgress> all;
  for (const nlohmann::ordered_json& goal : goals) {
    GoalProgress& progress = all.emplace_back();
    progress.goal_map = {goal.at("x_m").get<double>(), goal.at("y_m").get<double>()};
    if (!goal.contains("began_s")) {
      continue;
    }
    progress.began = time_at(goal["began_s"].get<double>());
    progress.ended = time_at(goal["began_s"].get<double>() + goal.at("time_s").get<double>());
    progress.state = goal.at("reached").get<bool>()   ? GoalProgress::State::kReached
                     : goal.at("refused").get<bool>() ? GoalProgress::State::kRefused
                                                      : GoalProgress::State::kPursued;
    progress.why = goal.value("why", "");
  }
  return all;
}

}  // namespace panoptes
