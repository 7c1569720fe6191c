// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/run_figures.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/report/platform_figures.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/eval/drive.h"
#include "core/eval/edges.h"
#include "core/eval/loops.h"
#include "core/eval/trajectory.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

/// The double nearest to the whole nanoseconds, which prints short.
double rounded_seconds(Duration d) { return static_cast<double>(d.count()) / 1e9; }

/// A figure that could not be found is absent.
template <class T>
void put(Json& into, const char* key, const std::optional<T>& value) {
  if (value) {
    into[key] = *value;
  }
}

/// The figure at a dotted path, of a list by its number; null when there is none.
const Json* figure_at(const Json& metrics, std::string_view path) {
  const Json* at = &metrics;
  while (true) {
    const auto dot = path.find('.');
    const std::string word(path.substr(0, dot));
    if (at->is_array() && word.size() == 1 && word[0] >= '0' &&
        static_cast<std::size_t>(word[0] - '0') < at->size()) {
      at = &(*at)[static_cast<std::size_t>(word[0] - '0')];
    } else if (const auto found = at->is_object() ? at->find(word) : at->end();
               found != at->end()) {
      at = &*found;
    } else {
      return nullptr;
    }
    if (dot == std::string_view::npos) {
      return at;
    }
    path.remove_prefix(dot + 1);
  }
}

/// Figures that a replay which would have driven elsewhere does not have.
bool is_of_driving(const std::string& figure) {
  constexpr std::array<std::string_view, 6> kOfDriving = {
      "collisions", "collisions_while_stopped", "min_clearance_m", "stuck_s", "goals",
      "exploration"};
  return std::find(kOfDriving.begin(), kOfDriving.end(), figure.substr(0, figure.find('.'))) !=
         kOfDriving.end();
}

/// Figures that a robot which drives to goals does not work for; so are checkpoints where its way
/// was too short to have any.
bool is_of_exploring(const std::string& figure, const Json& metrics) {
  return figure == "map.coverage" || figure == "map.mapped_free_m2" ||
         figure.starts_with("exploration.") ||
         (figure.starts_with("checkpoints.") && !metrics.contains("checkpoints"));
}

struct Judged {
  Json lines = Json::array();  ///< `pass` is null where a line is not judged
  int broken = 0;
  std::vector<std::string> unjudged;
};

template <class IsJudged>
Judged judge(const std::vector<Requirement>& requirements, const Json& metrics,
             const IsJudged& is_judged) {
  Judged judged;
  for (const Requirement& requirement : requirements) {
    const Json* value = figure_at(metrics, requirement.figure);
    bool pass = false;
    Json line{{"require", requirement.text}};
    if (value != nullptr && value->is_number()) {
      pass = holds(requirement, value->get<double>());
      line["value"] = *value;
    } else if (value != nullptr && value->is_boolean()) {
      pass = holds(requirement, value->get<bool>() ? 1.0 : 0.0);
      line["value"] = *value;
    } else if (value != nullptr && value->is_string()) {
      pass = holds(requirement, value->get<std::string>());
      line["value"] = *value;
    }
    if (is_judged(requirement)) {
      line["pass"] = pass;
      judged.broken += pass ? 0 : 1;
    } else {
      line["pass"] = nullptr;
      judged.unjudged.push_back(requirement.text);
    }
    judged.lines.push_back(line);
  }
  return judged;
}

Json relative_pose_json(const RelativePoseError& error) {
  Json json = Json::object();
  if (error.translations > 0) {
    json["median_m"] = error.median_m;
    json["p95_m"] = error.p95_m;
  }
  if (error.rotations > 0) {
    json["median_deg"] = error.median_deg;
    json["p95_deg"] = error.p95_deg;
  }
  return json;
}

std::string fixed(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

std::string centimetres(double metres) { return fixed(100 * metres, 1) + " cm"; }

/// Of a replay that would have driven elsewhere no figure says anything of the driving.
bool is_driven(const FinishedRun& run) { return !run.end.commands_diverged_at; }

/// Whether a goal was set, one per true pose.
std::vector<bool> goals_set(const FinishedRun& run, const std::vector<TruePose>& poses) {
  std::vector<bool> has_goal;
  std::size_t next = 0;
  for (const TruePose& pose : poses) {
    while (next < run.frames.size() && run.frames[next].stamp <= pose.stamp) {
      ++next;
    }
    has_goal.push_back(next > 0 && run.frames[next - 1].has_goal);
  }
  return has_goal;
}

std::string outcome_of(const FinishedRun& run, const RunFindings& f) {
  if (f.known == nullptr || !is_driven(run) || run.end.outcome != "completed") {
    return run.end.outcome;
  }
  const bool all_there = std::all_of(f.goals.begin(), f.goals.end(), [](const GoalFigures& goal) {
    return goal.reached || !goal.said_reached;
  });
  const Truth& truth = f.known->truth;
  return f.known->touches_known && collisions(truth) > 0        ? "collision"
         : ends_stuck(truth.poses, goals_set(run, truth.poses)) ? "stuck"
         : all_there                                            ? "completed"
                                                                : "failed";
}

void put_drive(Json& metrics, const FinishedRun& run, const RunFindings& f) {
  if (f.known == nullptr) {
    std::vector<Pose2> trajectory;
    for (const FinishedRun::Frame& frame : run.frames) {
      trajectory.push_back(frame.T_odom_body);
    }
    metrics["distance_m"] = trajectory.empty() ? 0 : path_lengths_m(trajectory).back();
    return;
  }
  const Truth& truth = f.known->truth;
  metrics["distance_m"] = truth.path_m;
  metrics["T_scene_map"] = {{"x_m", f.T_scene_map.x_m},
                            {"y_m", f.T_scene_map.y_m},
                            {"theta_deg", rad_to_deg(f.T_scene_map.theta_rad)}};
  if (!is_driven(run)) {
    return;
  }
  if (f.known->touches_known) {
    metrics["collisions"] = collisions(truth);
    metrics["collisions_while_stopped"] = collisions_while_stopped(truth);
    put(metrics, "min_clearance_m", min_clearance_m(truth));
  }
  metrics["stuck_s"] = stuck_s(truth.poses, goals_set(run, truth.poses));
}

void put_trajectory(Json& metrics, const RunFindings& f) {
  if (f.known == nullptr || f.T_map_body.empty()) {
    return;
  }
  const PathError ate = path_error(f.T_scene_estimate, f.true_T_scene_body);
  const Vec2 start_scene = f.known->truth.poses.front().T_scene_body.position();
  metrics["trajectory"] = {
      {"ate_rmse_m", ate.rmse_m},
      {"ate_max_m", ate.max_m},
      {"ate_start_aligned_m", rotated_rmse_m(f.T_scene_estimate, f.true_T_scene_body, start_scene)},
      {"odometry_ate_rmse_m", path_error(f.T_scene_odometry, f.true_T_scene_body).rmse_m}};
  if (const auto points = checkpoints(f.T_scene_estimate, f.true_T_scene_body, start_scene)) {
    metrics["checkpoints"] = {{"count", points->keyframes.size()},
                              {"error_mean_m", points->error_mean_m},
                              {"error_max_m", points->error_max_m}};
  }
}

void put_odometry(Json& metrics, const FinishedRun& run, const RunFindings& f) {
  if (f.known == nullptr || run.frames.empty()) {
    return;
  }
  std::vector<Pose2> T_odom_body;
  std::vector<Pose2> true_T_scene_body;
  for (const FinishedRun::Frame& frame : run.frames) {
    T_odom_body.push_back(frame.T_odom_body);
    true_T_scene_body.push_back(true_pose_at(f.known->truth.poses, frame.stamp));
  }
  const OdometryError error = odometry_error(T_odom_body, true_T_scene_body);
  if (error.share) {
    metrics["odometry"]["error_percent"] = 100 * *error.share;
  }
  metrics["odometry"]["heading_error_deg"] = rad_to_deg(error.heading_rad);
}

Json edge_errors_json(const EdgeErrors& errors) {
  Json e = {{"count", errors.count}};
  if (errors.heading_bias_rad_per_m) {
    e["heading_bias_deg_per_m"] = rad_to_deg(*errors.heading_bias_rad_per_m);
  }
  if (errors.heading_bias_share_of_turn) {
    e["heading_bias_percent_of_turn"] = 100 * *errors.heading_bias_share_of_turn;
  }
  if (errors.count > 0) {
    e["heading_rms_deg"] = rad_to_deg(errors.heading_rms_rad);
    e["position_rms_m"] = errors.position_rms_m;
    e["nees"] = errors.nees;
  }
  return e;
}

Json edges_json(const FinishedRun& run, const RunFindings& f) {
  const EdgeFigures edges = edge_figures(run.result.graph, f.true_T_scene_body);
  return {{"spins", edge_errors_json(edges.spins)}, {"driving", edge_errors_json(edges.driving)}};
}

/// What the robot truly is against what it believes to be.
void put_platform(Json& metrics, const FinishedRun& run, const RunFindings& f) {
  if (f.known == nullptr) {
    return;
  }
  const Truth& truth = f.known->truth;
  if (truth.rig && run.info.rig) {
    metrics["platform_truth"]["cameras"] = camera_errors(*truth.rig, *run.info.rig);
  }
  if (truth.wheels && run.info.body) {
    metrics["platform_truth"]["wheels"] = wheel_errors(*truth.wheels, *run.info.body);
  }
}

/// What the run has learned of the robot, against what it believed.
void put_learned(Json& metrics, const FinishedRun& run, const RunFindings& f) {
  if (!run.result.rig) {
    return;
  }
  const Truth* truth = f.known == nullptr ? nullptr : &f.known->truth;
  if (run.info.rig) {
    const Rig* true_rig = truth != nullptr && truth->rig ? &*truth->rig : nullptr;
    Json rig = rig_json(learned_cameras(*run.result.rig, *run.info.rig, true_rig));
    Json knocks = Json::array();
    for (const KnockReport& knock : run.result.rig->knocks) {
      Json& camera = rig[knock.camera];
      camera["knocks"] = camera.value("knocks", 0) + 1;
      camera["knocked_s"] = to_seconds(knock.found.time_since_epoch());
      knocks.push_back({{"time_s", to_seconds(knock.found.time_since_epoch())},
                        {"since_s", to_seconds(knock.since.time_since_epoch())},
                        {"camera", knock.camera},
                        {"turned_deg", rad_to_deg(knock.turned_rad)},
                        {"shifted_m", knock.shifted_m},
                        {"done", "mounting learned anew"}});
    }
    if (!knocks.empty()) {
      rig["knocks"] = std::move(knocks);
    }
    if (!rig.empty()) {
      metrics["rig"] = std::move(rig);
    }
  }
  if (run.info.body) {
    Json wheels = wheels_json(learned_wheels(*run.result.rig, run.info.body->wheel_base_m));
    if (truth != nullptr && truth->wheels) {
      put_wheel_errors(wheels, *truth->wheels);
    }
    if (!wheels.empty()) {
      metrics["wheels"] = std::move(wheels);
    }
  }
}

Json loops_json(const RunFindings& f) {
  const LoopFigures loops = loop_figures(f.closures, f.true_T_scene_body, f.path_m);
  Json l = {{"accepted", loops.accepted}};
  const auto& t = loops.against_truth;
  if (f.known != nullptr) {
    l["correct"] = t.correct;
    l["false"] = t.wrong;
  }
  l["same_heading"] = loops.same_heading;
  l["opposite_heading"] = loops.opposite_heading;
  if (loops.other_heading > 0) {
    l["other_heading"] = loops.other_heading;
  }
  if (f.known == nullptr) {
    return l;
  }
  Json pose_error = Json::object();
  for (const Heading heading : {Heading::kSame, Heading::kOpposite}) {
    Json of_class = relative_pose_json(heading == Heading::kSame ? t.error_same : t.error_opposite);
    if (!of_class.empty()) {
      pose_error[name_of(heading)] = std::move(of_class);
    }
  }
  if (!pose_error.empty()) {
    l["pose_error"] = std::move(pose_error);
  }
  l["revisits_same"] = t.revisits_same;
  l["revisits_opposite"] = t.revisits_opposite;
  if (t.revisits_same > 0) {
    l["recall_same"] = static_cast<double>(t.recalled_same) / t.revisits_same;
  }
  if (t.revisits_opposite > 0) {
    l["recall_opposite"] = static_cast<double>(t.recalled_opposite) / t.revisits_opposite;
  }
  return l;
}

Json map_json(const FinishedRun& run, const RunFindings& f) {
  Json m = {{"cell_m", run.result.map.cell_m}, {"mapped_free_m2", f.coverage.back().mapped_m2}};
  if (f.known == nullptr) {
    return m;
  }
  if (f.reachable) {
    m["radius_m"] = kReachRadius_m;
    m["reachable_m2"] = area_m2(*f.reachable);
  }
  put(m, "coverage", f.coverage.back().coverage);
  const MapQuality quality = map_quality(f.known->truth, run.result.map, f.T_scene_map);
  put(m, "free_iou", quality.free_iou);
  put(m, "free_precision", quality.free_precision);
  put(m, "obstacle_recall", quality.obstacle_recall);
  if (const auto leaked = leak(f.known->truth.floor, run.result.map, f.T_scene_map)) {
    m["leaked_m2"] = leaked->area_m2;
    put(m, "leaked_share", leaked->share);
  }
  return m;
}

Json exploration_json(const FinishedRun& run, const RunFindings& f) {
  Json exploration = Json::object();
  if (f.covered_throughout()) {
    put(exploration, "t50_s", time_of_coverage_s(f.coverage, 0.50));
    put(exploration, "t90_s", time_of_coverage_s(f.coverage, 0.90));
    put(exploration, "t97_s", time_of_coverage_s(f.coverage, 0.97));
  }
  if (run.end_delay) {
    exploration["end_delay_s"] = rounded_seconds(*run.end_delay);
  }
  return exploration;
}

/// Where the finished map has the body at every frame set; nowhere without keyframes.
std::vector<Pose2> estimated_trajectory(const FinishedRun& run) {
  std::vector<Pose2> trajectory;
  const std::vector<KeyframePose>& keyframes = run.result.keyframes;
  std::size_t next = 1;  // what comes before the first keyframe is carried back from it
  for (const FinishedRun::Frame& frame : run.frames) {
    while (next < keyframes.size() && keyframes[next].stamp <= frame.stamp) {
      ++next;
    }
    if (!keyframes.empty()) {
      const KeyframePose& last = keyframes[next - 1];
      trajectory.push_back(last.T_map_body * last.T_odom_body.inverse() * frame.T_odom_body);
    }
  }
  return trajectory;
}

/// Which run it is, and how it ended.
Json identity(const FinishedRun& run, const std::string& outcome) {
  Json metrics;
  metrics["schema"] = "panoptes.metrics/1";
  metrics["command"] = run.info.command;
  metrics["version"] = run.info.version;
  metrics["seed"] = run.info.seed;
  metrics["mission"] = run.info.mission;
  metrics["outcome"] = outcome;
  if (outcome == "completed") {
    metrics["end_reason"] = run.end.end_reason;
  }
  if (!run.end.warnings.empty()) {
    metrics["warnings"] = run.end.warnings;
  }
  if (!run.end.fault.empty()) {
    metrics["fault"] = as_utf8(run.end.fault);
  }
  return metrics;
}

std::string text_of(const Json& metrics) {
  return metrics.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// All but what it cost, and the verdicts on the requirements.
Json figures(const FinishedRun& run, const RunFindings& f,
             const std::vector<RecognitionRow>& places) {
  Json metrics = identity(run, outcome_of(run, f));
  put(metrics, "start_unix_ns", run.info.start_unix_ns);
  metrics["requirements"] = Json::array();  // judged last, over all of the figures
  if (!is_driven(run)) {
    metrics["replay"] = {{"commands_diverged_at_s",
                          rounded_seconds(run.end.commands_diverged_at->time_since_epoch())}};
  }
  metrics["run_s"] = rounded_seconds(run.last_step.time_since_epoch());
  metrics["frames"] = run.frames.size();
  metrics["keyframes"] = run.result.keyframes.size();
  put_drive(metrics, run, f);
  put_trajectory(metrics, f);
  put_odometry(metrics, run, f);
  put_platform(metrics, run, f);
  put_learned(metrics, run, f);
  metrics["loops"] = loops_json(f);
  if (f.known != nullptr && !f.true_T_scene_body.empty()) {
    metrics["edges"] = edges_json(run, f);
  }
  for (const RecognitionRow& row : places) {
    Json found = Json::object();
    put(found, "recall", row.recall());
    put(found, "recall_same", row.recall_same());
    put(found, "recall_opposite", row.recall_opposite());
    metrics["places"][row.histogram][row.distance][row.pictures] = std::move(found);
  }
  metrics["map"] = map_json(run, f);
  if (is_driven(run)) {
    metrics["exploration"] = exploration_json(run, f);
    if (!f.goals.empty()) {
      metrics["goals"] = goals_json(f.goals);
    }
  }
  for (const auto& [name, report] : run.end.cameras) {
    metrics["cameras"][name] = {{"missing", report.missing},
                                {"late", report.late},
                                {"frozen", report.frozen},
                                {"dark", report.dark},
                                {"saturated", report.saturated},
                                {"covered", report.covered},
                                {"lost_s", rounded_seconds(report.lost)}};
  }
  if (!run.end.devices.empty()) {
    metrics["devices"] = run.end.devices;
  }
  return metrics;
}

/// "camera front: dark 40, lost for 2.7 s", and what that means; one a camera that was lost.
std::vector<std::string> camera_lines(const FinishedRun& run) {
  std::vector<std::string> lines;
  for (const auto& [name, report] : run.end.cameras) {
    if (report.lost == Duration{}) {
      continue;
    }
    std::string counts;
    const auto count = [&counts](const char* what, int pictures) {
      if (pictures > 0) {
        counts += (counts.empty() ? "" : ", ") + std::to_string(pictures) + " " + what;
      }
    };
    count("missing", report.missing);
    count("late", report.late);
    count("frozen", report.frozen);
    count("dark", report.dark);
    count("saturated", report.saturated);
    count("covered", report.covered);
    lines.push_back("camera " + name + ": lost for " + fixed(to_seconds(report.lost), 1) +
                    " s, pictures " + counts + "; meanwhile " +
                    (report.is_floor  ? "no floor was mapped by it"
                     : report.is_loop ? "no loops could be closed"
                                      : "nobody needed it"));
  }
  return lines;
}

std::string map_line(const RunFindings& f) {
  std::string line = "map: " + fixed(f.coverage.back().mapped_m2, 1) + " m2 free";
  if (f.coverage.back().coverage) {
    line += ", " + fixed(100 * *f.coverage.back().coverage, 1) + " % of the reachable floor";
  }
  return line;
}

std::string position_line(const Json& metrics) {
  const Json& t = metrics["trajectory"];
  std::string line = "position: " + centimetres(t["ate_rmse_m"].get<double>()) +
                     " rms from the truth, wheels alone " +
                     centimetres(t["odometry_ate_rmse_m"].get<double>());
  if (metrics.contains("checkpoints")) {
    line += "; checkpoints " + centimetres(metrics["checkpoints"]["error_mean_m"].get<double>()) +
            " mean, " + centimetres(metrics["checkpoints"]["error_max_m"].get<double>()) +
            " at most";
  }
  return line;
}

std::string odometry_line(const Json& metrics) {
  const Json& odometry = metrics["odometry"];
  return "wheels: " +
         (odometry.contains("error_percent")
              ? fixed(odometry["error_percent"].get<double>(), 2) + " % of the way off, "
              : std::string()) +
         "heading up to " + fixed(odometry["heading_error_deg"].get<double>(), 2) + " degrees off";
}

std::vector<std::string> summary_of(const FinishedRun& run, const RunFindings& f,
                                    const Json& metrics, const Judged& judged) {
  std::vector<std::string> s;
  const Json& loops = metrics["loops"];
  const auto outcome = metrics["outcome"].get<std::string>();
  s.push_back(outcome + (run.end.end_reason.empty() ? "" : " (" + run.end.end_reason + ")") +
              " after " + fixed(metrics["run_s"].get<double>(), 0) +
              " s: " + fixed(metrics["distance_m"].get<double>(), 1) + " m driven, " +
              std::to_string(run.result.keyframes.size()) + " keyframes, " +
              loops["accepted"].dump() + " loops closed" +
              (f.known != nullptr ? ", " + loops["false"].dump() + " wrong" : ""));
  s.insert(s.end(), run.end.warnings.begin(), run.end.warnings.end());
  if (is_driven(run)) {
    for (std::size_t i = 0; i < f.goals.size(); ++i) {
      s.push_back(goal_line(i + 1, f.goals[i]));
    }
  }
  if (run.info.judged || f.coverage.back().mapped_m2 > 0) {  // a recording need not map
    s.push_back(map_line(f));
  }
  if (metrics.contains("trajectory")) {
    s.push_back(position_line(metrics));
  }
  if (metrics.contains("odometry")) {
    s.push_back(odometry_line(metrics));
  }
  if (metrics.contains("collisions")) {
    std::string contacts = metrics["collisions"].dump() + " collisions";
    if (const auto clearance = min_clearance_m(f.known->truth)) {
      contacts += ", " + centimetres(*clearance) + " clear at the closest";
    }
    s.push_back(contacts);
  }
  for (const std::string& line : camera_lines(run)) {
    s.push_back(line);
  }
  if (!is_driven(run)) {
    s.push_back("replayed: with these settings the robot would have driven differently from " +
                fixed(to_seconds(*run.end.commands_diverged_at), 1) +
                " s on; no figures are given that driving decides");
  }
  s.push_back(fixed(metrics.value("real_time_factor", 0.0), 1) + " times real time, " +
              fixed(metrics.value("peak_memory_mb", 0.0), 0) + " MB");
  if (!judged.unjudged.empty()) {
    s.push_back("not judged: " + joined(judged.unjudged) +
                (is_driven(run) && !run.goals.empty() ? " (figures that exploring decides)"
                 : run.info.judged                    ? " (figures that driving decides)"
                                                      : " (it is not for what this command does)"));
  }
  for (std::size_t i = 0; i < run.info.require.size(); ++i) {
    const Json& line = judged.lines[i];
    if (line["pass"] == false) {
      s.push_back(
          "broken: " + run.info.require[i].text +
          (line.contains("value") ? ", it is " + line["value"].dump() : ", no such figure"));
    }
  }
  return s;
}

}  // namespace

bool RunFindings::covered_throughout() const {
  return std::all_of(coverage.begin(), coverage.end(),
                     [](const CoverageSample& s) { return s.coverage.has_value(); });
}

RunFindings find_out(const FinishedRun& run, const RunTruth* known) {
  RunFindings f;
  std::vector<Pose2> T_odom_body;
  for (const KeyframePose& keyframe : run.result.keyframes) {
    f.T_map_body.push_back(keyframe.T_map_body);
    T_odom_body.push_back(keyframe.T_odom_body);
  }
  f.T_map_frame = estimated_trajectory(run);
  for (const auto& [stamp, closure] : run.closures) {
    f.closures.push_back(closure);
  }
  f.path_m = path_lengths_m(T_odom_body);
  if (known != nullptr && !known->truth.poses.empty()) {
    f.known = known;
    const Truth& truth = known->truth;
    const Pose2 true_start = truth.poses.front().T_scene_body;
    f.T_scene_map = run.info.T_scene_map.value_or(true_start);
    f.true_T_scene_body = true_keyframes(run.result.keyframes, truth);
    const Pose2 T_scene_odom =
        run.frames.empty() ? true_start : true_start * run.frames.front().T_odom_body.inverse();
    for (std::size_t i = 0; i < f.T_map_body.size(); ++i) {
      f.T_scene_estimate.push_back(f.T_scene_map * f.T_map_body[i]);
      f.T_scene_odometry.push_back(T_scene_odom * T_odom_body[i]);
    }
    // along every frame set, since keyframes cut corners
    std::vector<Pose2> trajectory;
    for (const TruePose& pose : truth.poses) {
      trajectory.push_back(pose.T_scene_body);
    }
    const std::vector<double> path_m = path_lengths_m(trajectory);
    for (std::size_t i = 0; i < f.path_m.size(); ++i) {
      const auto at =
          std::lower_bound(truth.poses.begin(), truth.poses.end(), run.result.keyframes[i].stamp,
                           [](const TruePose& pose, Time t) { return pose.stamp < t; });
      f.path_m[i] = at == truth.poses.end()
                        ? path_m.back()
                        : path_m[static_cast<std::size_t>(at - truth.poses.begin())];
    }
    if (!truth.body.cells.empty()) {
      f.reachable = reachable_floor(truth.body, true_start.position());
    }
  }
  f.goals = goal_figures(run, f.known != nullptr ? &known->truth : nullptr, f.T_scene_map,
                         f.reachable ? &*f.reachable : nullptr);
  const auto sample = [&](Time stamp, double mapped_m2, const OccupancyMap* map) {
    CoverageSample s{stamp, mapped_m2, std::nullopt};
    if (f.reachable && map != nullptr) {
      s.coverage = coverage(*f.reachable, *map, f.T_scene_map);
    }
    return s;
  };
  for (const FinishedRun::Snapshot& snapshot : run.snapshots) {
    if (snapshot.stamp < run.last_step) {
      f.coverage.push_back(
          sample(snapshot.stamp, snapshot.mapped_m2, snapshot.map ? &*snapshot.map : nullptr));
    }
  }
  f.coverage.push_back(sample(run.last_step, run.result.map.area_m2(Cell::kFree), &run.result.map));
  return f;
}

RunVerdict judge_run(const FinishedRun& run, const RunFindings& findings,
                     const std::vector<RecognitionRow>& places, std::string_view others) {
  Json metrics = figures(run, findings, places);
  const Json known_already = Json::parse(others);
  for (const auto& [key, value] : known_already.items()) {
    if (!metrics.contains(key)) {
      metrics[key] = value;
    }
  }
  const Judged judged = judge(run.info.require, metrics, [&](const Requirement& requirement) {
    return run.info.judged && (is_driven(run) || !is_of_driving(requirement.figure)) &&
           (run.goals.empty() || !is_of_exploring(requirement.figure, metrics));
  });
  metrics["requirements"] = judged.lines;
  const auto outcome = metrics["outcome"].get<std::string>();
  RunVerdict verdict;
  verdict.metrics_json = text_of(metrics);
  verdict.exit_status = outcome == "interrupted"                       ? 130
                        : outcome == "device_lost"                     ? 3
                        : outcome == "completed" && judged.broken == 0 ? 0
                                                                       : 1;
  verdict.summary = summary_of(run, findings, metrics, judged);
  return verdict;
}

RunVerdict bare_verdict(const FinishedRun& run) {
  return {text_of(identity(run, run.end.outcome)), 1, {run.end.outcome}};
}

}  // namespace panoptes
