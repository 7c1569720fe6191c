// SPDX-License-Identifier: BSD-3-Clause
#include "apps/evaluate/saved_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "apps/mission/mission.h"
#include "apps/report/goal_figures.h"
#include "apps/report/platform_figures.h"
#include "apps/report/run_files.h"
#include "core/base/error.h"
#include "core/eval/trajectory.h"
#include "core/io/digits.h"
#include "core/io/graph_file.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// What the run itself said of its end; a truth may have said more since, and made it a collision.
Json own_end(const Json& metrics) {
  if (metrics.contains("evaluated")) {
    return metrics["evaluated"];
  }
  Json end{{"outcome",
            metrics.at("outcome") == "collision" ? Json("completed") : metrics.at("outcome")}};
  if (metrics.contains("end_reason")) {
    end["end_reason"] = metrics["end_reason"];
  }
  return end;
}

void take_metrics(const Json& metrics, FinishedRun& run) {
  metrics.at("command").get_to(run.info.command);
  metrics.at("version").get_to(run.info.version);
  metrics.at("mission").get_to(run.info.mission);
  metrics.at("seed").get_to(run.info.seed);
  if (metrics.contains("start_unix_ns")) {
    run.info.start_unix_ns = metrics["start_unix_ns"].get<std::int64_t>();
  }
  const Json& lines = metrics.at("requirements");
  for (const Json& line : lines) {
    run.info.require.push_back(parse_requirement(line.at("require").get<std::string>()));
  }
  // as the run itself decided: `pass` is null where a line was not judged
  run.info.judged = std::any_of(lines.begin(), lines.end(),
                                [](const Json& line) { return !line.at("pass").is_null(); });
  const Json end = own_end(metrics);
  end.at("outcome").get_to(run.end.outcome);
  run.end.end_reason = end.value("end_reason", "");
  if (metrics.contains("replay")) {
    run.end.commands_diverged_at =
        time_at(metrics["replay"].at("commands_diverged_at_s").get<double>());
  }
  run.last_step = time_at(metrics.at("run_s").get<double>());
  if (metrics.contains("goals")) {
    run.goals = goals_from(metrics["goals"]);
  }
  if (metrics.contains("exploration") && metrics["exploration"].contains("end_delay_s")) {
    run.end_delay = from_seconds(metrics["exploration"]["end_delay_s"].get<double>());
  }
}

void take_frames(const fs::path& folder, FinishedRun& run) {
  const CsvTable steps = read_csv(folder / "steps.csv");
  const std::size_t stamp = steps.column("stamp_s");
  const std::size_t goal = steps.column("goal_x_m");
  const std::vector<TumPose> odometry = read_tum(folder / "odometry.tum");
  for (std::size_t i = 0; i < std::min(odometry.size(), steps.rows.size()); ++i) {
    if (steps.stamp(i, stamp) != odometry[i].stamp) {
      throw steps.fault(i, "stamp_s must be " + seconds(odometry[i].stamp) +
                               ", as in odometry.tum, got " + steps.rows[i][stamp]);
    }
    run.frames.push_back(
        {odometry[i].stamp, floor_pose(odometry[i]), !steps.rows[i][goal].empty()});
  }
  if (odometry.size() != steps.rows.size() || odometry.empty()) {
    throw ConfigError((folder / "odometry.tum").string() + ": must have a line for each of the " +
                      std::to_string(steps.rows.size()) + " rows of steps.csv, and one at least");
  }
}

void take_keyframes(const fs::path& folder, FinishedRun& run) {
  std::vector<TruePose> wheels;  // a keyframe may be older than the frame set that brought it
  for (const FinishedRun::Frame& frame : run.frames) {
    TruePose pose;
    pose.stamp = frame.stamp;
    pose.T_scene_body = frame.T_odom_body;
    wheels.push_back(pose);
  }
  for (const TumPose& pose : read_tum(folder / "keyframes.tum")) {
    if (pose.stamp > wheels.back().stamp) {
      throw ConfigError((folder / "keyframes.tum").string() + ": the keyframe of " +
                        seconds(pose.stamp) + " s is later than all of odometry.tum");
    }
    run.result.keyframes.push_back(
        {pose.stamp, floor_pose(pose), true_pose_at(wheels, pose.stamp)});
  }
}

// A check that was not reached left no number.
double number_or_none(const CsvTable& table, std::size_t row, std::size_t column) {
  return table.rows[row][column].empty() ? std::numeric_limits<double>::quiet_NaN()
                                         : table.number(row, column);
}

void take_graph(const fs::path& folder, FinishedRun& run) {
  if (run.result.keyframes.empty()) {
    return;  // the file is empty, too
  }
  const fs::path file = folder / "graph.g2o";
  run.result.graph = read_graph(file).graph;
  const std::size_t nodes = run.result.graph.T_map_node.size();
  if (nodes != run.result.keyframes.size()) {
    throw ConfigError(file.string() + ": has " + std::to_string(nodes) + " poses, but there are " +
                      std::to_string(run.result.keyframes.size()) + " in keyframes.tum");
  }
}

void take_closures(const CsvTable& table, FinishedRun& run) {
  for (const std::string_view name : kTrueLoopColumns) {
    table.column(name);  // or else it throws
  }
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const auto keyframe = [&](const char* name) {
      const int k = table.whole(row, table.column(name));
      if (k < 0 || static_cast<std::size_t>(k) >= run.result.keyframes.size()) {
        throw table.fault(row, std::string(name) + " must be a keyframe of keyframes.tum, got " +
                                   std::to_string(k));
      }
      return k;
    };
    ClosureReport closure;
    closure.recent = keyframe("recent");
    closure.earlier = keyframe("earlier");
    const std::string& heading = table.rows[row][table.column("class")];
    const std::optional<Heading> known = heading_named(heading);
    if (!known) {
      throw table.fault(row, "class must be same, opposite or other, got '" + heading + "'");
    }
    closure.heading = *known;
    closure.T_earlier_recent = {number_or_none(table, row, table.column("x_m")),
                                number_or_none(table, row, table.column("y_m")),
                                deg_to_rad(number_or_none(table, row, table.column("theta_deg")))};
    closure.accepted = table.whole(row, table.column("accepted")) != 0;
    if (closure.accepted) {
      const auto& edges = run.result.graph.edges;  // what a closure claims is in its edge
      const auto edge = std::find_if(edges.begin(), edges.end(), [&](const GraphEdge& e) {
        return e.closure && e.from == closure.earlier && e.to == closure.recent;
      });
      if (edge == edges.end()) {
        throw table.fault(row, "is accepted, but graph.g2o has no edge between its keyframes");
      }
      closure.information = edge->information;
    }
    run.closures.emplace_back(table.stamp(row, table.column("stamp_s")), std::move(closure));
  }
}

void take_snapshots(const fs::path& folder, FinishedRun& run) {
  const CsvTable table = read_csv(folder / "exploration.csv");
  const std::size_t stamp = table.column("stamp_s");
  const std::size_t mapped = table.column("mapped_m2");
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    run.snapshots.push_back({table.stamp(row, stamp), table.number(row, mapped), std::nullopt});
  }
}

// As far as the mission of the run can still be read: its world may be elsewhere now.
void take_beliefs(const fs::path& folder, FinishedRun& run) {
  try {
    const auto mission = load_mission<ExploreMission>((folder / "mission.yaml").string(), {},
                                                      CameraRequirement::kNothing);
    run.info.rig = mission.rig;
    run.info.body = mission.robot;
  } catch (const ConfigError&) {
    return;
  } catch (const IoError&) {
    return;
  }
}

SavedRun read(const fs::path& folder) {
  SavedRun saved;
  saved.folder = folder;
  saved.metrics_json = read_file(folder / "metrics.json");
  try {
    take_metrics(Json::parse(saved.metrics_json), saved.run);
  } catch (const Json::exception& error) {
    throw ConfigError((folder / "metrics.json").string() +
                      ": is not of a run that drove and mapped: " + error.what());
  }
  take_frames(folder, saved.run);
  take_keyframes(folder, saved.run);
  saved.run.result.map = read_map_server(folder / "map.yaml");
  saved.loops = read_csv(folder / "loops.csv");
  take_graph(folder, saved.run);
  take_closures(saved.loops, saved.run);
  take_snapshots(folder, saved.run);
  take_beliefs(folder, saved.run);
  return saved;
}

// The table as it is but for what the truth says.
void write_loops(const SavedRun& saved, const RunFindings& findings) {
  CsvWriter csv(saved.folder / "loops.csv", saved.loops.columns);
  for (std::size_t row = 0; row < saved.loops.rows.size(); ++row) {
    std::vector<std::string> fields = saved.loops.rows[row];
    const auto said = true_loop_fields(findings, saved.run.closures[row].second);
    for (std::size_t i = 0; i < kTrueLoopColumns.size(); ++i) {
      fields[saved.loops.column(kTrueLoopColumns[i])] = said[i];
    }
    for (const std::string& field : fields) {
      csv << field;
    }
    csv.end_row();
  }
  csv.finish();
}

// What the run's figures are besides those that are found anew.
std::string other_figures(const SavedRun& saved, const Truth& truth) {
  constexpr std::array<const char*, 10> kOfTruth = {
      "T_scene_map",     "collisions", "collisions_while_stopped",
      "min_clearance_m", "stuck_s",    "trajectory",
      "checkpoints",     "places",     "end_reason",
      "platform_truth"};
  Json others = Json::parse(saved.metrics_json);
  others["evaluated"] = own_end(others);
  for (const char* key : kOfTruth) {
    others.erase(key);
  }
  if (others.contains("wheels")) {
    others["wheels"].erase("radius_ratio_error");
    others["wheels"].erase("base_error");
    if (truth.wheels) {
      put_wheel_errors(others["wheels"], *truth.wheels);
    }
  }
  return others.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

SavedRun read_run(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder / "metrics.json", ignored)) {
    throw ConfigError(folder.string() + ": is no run directory; it holds no metrics.json");
  }
  try {
    return read(folder);
  } catch (const IoError& error) {
    throw ConfigError(error.what());
  }
}

RunReport report_with(const SavedRun& saved, const RunTruth& truth) {
  const RunFindings findings = find_out(saved.run, &truth);
  write_ground_truth(saved.folder, findings);
  write_contacts(saved.folder, saved.run, findings);
  write_exploration(saved.folder, findings);
  write_loops(saved, findings);
  RunReport report;
  Faults faults;
  report.pictures = draw_run(saved.folder, saved.run, findings, {}, faults);
  RunVerdict verdict = judge_run(saved.run, findings, {}, other_figures(saved, truth.truth));
  write_file(saved.folder / "metrics.json", verdict.metrics_json);
  report.exit_status = faults.none() ? verdict.exit_status : faults.status();
  report.summary = std::move(verdict.summary);
  return report;
}

}  // namespace panoptes
