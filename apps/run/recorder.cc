// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/recorder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include <nlohmann/json.hpp>

#include "apps/run/pictures.h"
#include "apps/run/place_table.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/eval/drive.h"
#include "core/eval/loops.h"
#include "core/eval/trajectory.h"
#include "core/io/digits.h"
#include "core/io/g2o.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

constexpr Duration kSnapshotEvery = std::chrono::seconds(10);

/// The double nearest to the whole nanoseconds, which prints short.
double rounded_seconds(Duration d) { return static_cast<double>(d.count()) / 1e9; }

const char* name_of(NavState state) {
  switch (state) {
    case NavState::kDriving:
      return "driving";
    case NavState::kRecovering:
      return "recovering";
    case NavState::kStopped:
      return "stopped";
  }
  return "";
}

const char* name_of(Heading heading) { return heading == Heading::kSame ? "same" : "opposite"; }

/// A figure that could not be found is absent.
template <class T>
void put(Json& into, const char* key, const std::optional<T>& value) {
  if (value) {
    into[key] = *value;
  }
}

/// The figure at a dotted path; null when there is none.
const Json* figure_at(const Json& metrics, std::string_view path) {
  const Json* at = &metrics;
  while (true) {
    const auto dot = path.find('.');
    if (!at->is_object()) {
      return nullptr;
    }
    const auto found = at->find(std::string(path.substr(0, dot)));
    if (found == at->end()) {
      return nullptr;
    }
    at = &*found;
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

std::string fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string centimetres(double metres) { return fixed(100 * metres, 1) + " cm"; }

std::vector<Vec2> positions(const std::vector<Pose2>& poses) {
  std::vector<Vec2> all;
  all.reserve(poses.size());
  for (const Pose2& pose : poses) {
    all.push_back(pose.position());
  }
  return all;
}

/// Everything about a finished run that more than one file needs.
struct Findings {
  bool known = false;             ///< there is truth
  Pose2 T_scene_map;              ///< identity without truth
  std::vector<Pose2> T_map_body;  ///< of keyframes
  std::vector<Pose2> T_scene_estimate;
  std::vector<Pose2> T_scene_odometry;
  std::vector<Pose2> true_T_scene_body;
  std::vector<ClosureReport> closures;
  std::vector<CoverageSample> coverage;
};

}  // namespace

std::string mission_text(const std::string& version, const std::string& mission_yaml) {
  return "# panoptes " + version + "\n" + mission_yaml;
}

Recorder::Recorder(std::filesystem::path out_dir, RunInfo info, StageClock* clock)
    : out_dir_(std::move(out_dir)),
      info_(std::move(info)),
      clock_(clock),
      loop_from_s_(steady_s()),
      steps_(out_dir_ / "steps.csv",
             {"stamp_s", "x_m", "y_m", "theta_deg", "command_v_mps", "command_w_radps", "goal_x_m",
              "goal_y_m", "keyframe", "state", "why", "mapped_m2"}) {}

void Recorder::keep_settings() {
  if (!settings_kept_) {
    settings_kept_ = true;
    write_file(out_dir_ / "mission.yaml", mission_text(info_.version, info_.mission_yaml));
  }
}

void Recorder::add(const Observation& seen, const NavStep& step) {
  keep_settings();
  now_ = seen.stamp;
  if (!next_snapshot_) {
    next_snapshot_ = seen.stamp + kSnapshotEvery;
  }
  if (step.frontier_reachable) {
    last_frontier_ = seen.stamp;
  }
  for (const ClosureReport& closure : step.closures) {
    ClosureReport kept = closure;
    kept.contour_earlier = {};  // the largest part; NavStep is for showing it
    kept.contour_recent = {};
    closures_.emplace_back(seen.stamp, std::move(kept));
  }
  if (seen.pictures.empty()) {
    return;
  }
  frames_.push_back({seen.stamp, seen.odometry.T_odom_body, step.goal_map.has_value()});
  steps_ << seen.stamp << step.T_map_body.x_m << step.T_map_body.y_m
         << rad_to_deg(step.T_map_body.theta_rad) << step.command_body.v_mps
         << step.command_body.w_radps;
  if (step.goal_map) {
    steps_ << step.goal_map->x() << step.goal_map->y();
  } else {
    steps_.skip().skip();
  }
  if (step.keyframe_made) {
    steps_ << *step.keyframe_made;
  } else {
    steps_.skip();
  }
  steps_ << name_of(step.state) << step.reason << step.mapped_free_m2;
  steps_.end_row();
}

bool Recorder::snapshot_due(Time now) const { return next_snapshot_ && now >= *next_snapshot_; }

void Recorder::add_snapshot(Time now, OccupancyMap map) {
  snapshots_.push_back({now, std::move(map)});
  next_snapshot_ = now + kSnapshotEvery;
}

RunReport Recorder::write_report(const std::optional<Truth>& truth, const RunResult& result,
                                 RunEnd end, const std::vector<KeptKeyframe>& kept,
                                 const PlaceStudy* places) {
  const double loop_s = steady_s() - loop_from_s_;
  RunReport report;

  // what is known of the run
  Findings f;
  f.known = truth && !truth->poses.empty();
  for (const KeyframePose& keyframe : result.keyframes) {
    f.T_map_body.push_back(keyframe.T_map_body);
  }
  std::vector<Pose2> T_odom_body;
  for (const KeyframePose& keyframe : result.keyframes) {
    T_odom_body.push_back(keyframe.T_odom_body);
  }
  for (const auto& [stamp, closure] : closures_) {
    f.closures.push_back(closure);
  }
  std::optional<TruthLayer> reachable;
  if (f.known) {
    const Pose2 true_start = truth->poses.front().T_scene_body;
    f.T_scene_map = info_.T_scene_map.value_or(true_start);
    f.true_T_scene_body = true_keyframes(result.keyframes, *truth);
    const Pose2 T_scene_odom =
        frames_.empty() ? true_start : true_start * frames_.front().T_odom_body.inverse();
    for (std::size_t i = 0; i < f.T_map_body.size(); ++i) {
      f.T_scene_estimate.push_back(f.T_scene_map * f.T_map_body[i]);
      f.T_scene_odometry.push_back(T_scene_odom * T_odom_body[i]);
    }
    if (!truth->body.cells.empty()) {
      reachable = reachable_floor(truth->body, true_start.position());
    }
  }
  const auto sample = [&](Time stamp, const OccupancyMap& map) {
    CoverageSample s{stamp, map.free_m2(), std::nullopt};
    if (reachable) {
      s.coverage = coverage(*reachable, map, f.T_scene_map);
    }
    return s;
  };
  const Time end_stamp = now_.value_or(Time{});
  for (const Snapshot& snapshot : snapshots_) {
    if (snapshot.stamp < end_stamp) {
      f.coverage.push_back(sample(snapshot.stamp, snapshot.map));
    }
  }
  f.coverage.push_back(sample(end_stamp, result.map));

  // the figures
  Json metrics;
  metrics["schema"] = "panoptes.metrics/1";
  metrics["command"] = info_.command;
  metrics["version"] = info_.version;
  metrics["seed"] = info_.seed;
  metrics["mission"] = info_.mission;
  std::vector<bool> has_goal;  // one per true pose
  if (f.known) {
    std::size_t next = 0;
    for (const TruePose& pose : truth->poses) {
      while (next < frames_.size() && frames_[next].stamp <= pose.stamp) {
        ++next;
      }
      has_goal.push_back(next > 0 && frames_[next - 1].has_goal);
    }
  }
  // Of a replay that would have driven elsewhere no figure says anything of the driving.
  const bool driven = !end.commands_diverged_at;
  if (f.known && driven && end.outcome == "completed") {
    end.outcome = collisions(*truth) > 0               ? "collision"
                  : ends_stuck(truth->poses, has_goal) ? "stuck"
                                                       : "completed";
  }
  metrics["outcome"] = end.outcome;
  if (end.outcome == "completed") {
    metrics["end_reason"] = end.end_reason;
  }
  put(metrics, "start_unix_ns", info_.start_unix_ns);
  metrics["requirements"] = Json::array();  // judged last, over all of the figures
  if (!driven) {
    metrics["replay"] = {
        {"commands_diverged_at_s", rounded_seconds(end.commands_diverged_at->time_since_epoch())}};
  }
  const double run_s = rounded_seconds(end_stamp.time_since_epoch());
  metrics["run_s"] = run_s;
  metrics["frames"] = frames_.size();
  metrics["keyframes"] = result.keyframes.size();
  if (f.known) {
    metrics["distance_m"] = truth->path_m;
  } else {
    std::vector<Pose2> way;
    for (const Frame& frame : frames_) {
      way.push_back(frame.T_odom_body);
    }
    metrics["distance_m"] = way.empty() ? 0 : path_lengths_m(way).back();
  }
  if (f.known) {
    metrics["T_scene_map"] = {{"x_m", f.T_scene_map.x_m},
                              {"y_m", f.T_scene_map.y_m},
                              {"theta_deg", rad_to_deg(f.T_scene_map.theta_rad)}};
  }
  if (f.known && driven) {
    metrics["collisions"] = collisions(*truth);
    metrics["collisions_while_stopped"] = collisions_while_stopped(*truth);
    put(metrics, "min_clearance_m", min_clearance_m(*truth));
    metrics["stuck_s"] = stuck_s(truth->poses, has_goal);
  }
  if (f.known && !f.T_map_body.empty()) {
    const PathError ate = path_error(f.T_scene_estimate, f.true_T_scene_body);
    metrics["trajectory"] = {
        {"ate_rmse_m", ate.rmse_m},
        {"ate_max_m", ate.max_m},
        {"odometry_ate_rmse_m", path_error(f.T_scene_odometry, f.true_T_scene_body).rmse_m}};
    if (const auto points = checkpoints(f.T_scene_estimate, f.true_T_scene_body,
                                        truth->poses.front().T_scene_body.position())) {
      metrics["checkpoints"] = {{"count", points->keyframes.size()},
                                {"error_mean_m", points->error_mean_m},
                                {"error_max_m", points->error_max_m}};
    }
  }
  std::vector<double> path_m = path_lengths_m(T_odom_body);
  if (f.known) {  // along every frame set, since keyframes cut corners
    std::vector<Pose2> way;
    for (const TruePose& pose : truth->poses) {
      way.push_back(pose.T_scene_body);
    }
    const std::vector<double> way_m = path_lengths_m(way);
    for (std::size_t i = 0; i < path_m.size(); ++i) {
      const auto at =
          std::lower_bound(truth->poses.begin(), truth->poses.end(), result.keyframes[i].stamp,
                           [](const TruePose& pose, Time t) { return pose.stamp < t; });
      path_m[i] = at == truth->poses.end()
                      ? way_m.back()
                      : way_m[static_cast<std::size_t>(at - truth->poses.begin())];
    }
  }
  const LoopFigures loops = loop_figures(f.closures, f.true_T_scene_body, path_m);
  metrics["loops"] = {{"accepted", loops.accepted}};
  Json& l = metrics["loops"];
  if (f.known) {
    l["correct"] = loops.against_truth.correct;
    l["false"] = loops.against_truth.wrong;
  }
  l["same_heading"] = loops.same_heading;
  l["opposite_heading"] = loops.opposite_heading;
  if (f.known) {
    const auto& t = loops.against_truth;
    Json pose_error = Json::object();
    for (const Heading heading : {Heading::kSame, Heading::kOpposite}) {
      Json of_class =
          relative_pose_json(heading == Heading::kSame ? t.error_same : t.error_opposite);
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
  }
  std::vector<PlaceRow> place_rows;
  if (places != nullptr && f.known) {
    place_rows = places->rows(f.true_T_scene_body, path_m);
  }
  for (const PlaceRow& row : place_rows) {
    Json figures = Json::object();
    put(figures, "recall", row.recall());
    put(figures, "recall_same", row.recall_same());
    put(figures, "recall_opposite", row.recall_opposite());
    metrics["places"][row.histogram][row.distance][row.pictures] = std::move(figures);
  }
  metrics["map"] = {{"cell_m", result.map.cell_m}, {"mapped_free_m2", f.coverage.back().mapped_m2}};
  if (f.known) {
    Json& m = metrics["map"];
    if (reachable) {
      m["radius_m"] = kReachRadius_m;
      m["reachable_m2"] = area_m2(*reachable);
    }
    put(m, "coverage", f.coverage.back().coverage);
    const MapQuality quality = map_quality(*truth, result.map, f.T_scene_map);
    put(m, "free_iou", quality.free_iou);
    put(m, "free_precision", quality.free_precision);
    put(m, "obstacle_recall", quality.obstacle_recall);
  }
  Json exploration = Json::object();
  put(exploration, "t50_s", time_of_coverage_s(f.coverage, 0.50));
  put(exploration, "t90_s", time_of_coverage_s(f.coverage, 0.90));
  put(exploration, "t97_s", time_of_coverage_s(f.coverage, 0.97));
  exploration["end_delay_s"] =
      last_frontier_ ? rounded_seconds(end_stamp - *last_frontier_) : run_s;
  if (driven) {
    metrics["exploration"] = exploration;
  }

  // the files
  keep_settings();
  steps_.finish();
  write_map_server(out_dir_ / "map", result.map);
  std::vector<TumPose> trajectory;
  for (const KeyframePose& keyframe : result.keyframes) {
    trajectory.push_back({keyframe.stamp, on_floor(keyframe.T_map_body)});
  }
  write_tum(out_dir_ / "trajectory.tum", trajectory);
  std::vector<TumPose> odometry;
  for (const Frame& frame : frames_) {
    odometry.push_back({frame.stamp, on_floor(frame.T_odom_body)});
  }
  write_tum(out_dir_ / "odometry.tum", odometry);
  std::vector<Pose2> true_T_map_body;
  if (f.known) {
    const Pose2 T_map_scene = f.T_scene_map.inverse();
    std::vector<TumPose> ground_truth;
    for (const TruePose& pose : truth->poses) {
      true_T_map_body.push_back(T_map_scene * pose.T_scene_body);
      ground_truth.push_back({pose.stamp, on_floor(true_T_map_body.back())});
    }
    write_tum(out_dir_ / "ground_truth.tum", ground_truth);
  }
  write_g2o(out_dir_ / "graph.g2o", result.graph);
  if (!kept.empty()) {
    write_keyframes(out_dir_, kept);
  }

  if (!place_rows.empty()) {
    write_places(out_dir_ / "places.csv", place_rows);
  }

  CsvWriter loops_csv(out_dir_ / "loops.csv", {"stamp_s",
                                               "recent",
                                               "earlier",
                                               "class",
                                               "emd_grey",
                                               "diagonal_max_grey",
                                               "gate_sigma",
                                               "feature_inliers",
                                               "cameras_sigma",
                                               "flow_heading_deg",
                                               "contour_cost_m",
                                               "contour_overlap",
                                               "chi2_growth",
                                               "x_m",
                                               "y_m",
                                               "theta_deg",
                                               "true_x_m",
                                               "true_y_m",
                                               "true_theta_deg",
                                               "accepted",
                                               "correct",
                                               "verdict"});
  const auto number = [&](double value) {  // a check that was not reached leaves no number
    if (std::isfinite(value)) {
      loops_csv << value;
    } else {
      loops_csv.skip();
    }
  };
  for (const auto& [stamp, closure] : closures_) {
    loops_csv << stamp << closure.recent << closure.earlier << name_of(closure.heading);
    number(closure.emd_grey);
    number(closure.diagonal_max_grey);
    number(closure.gate_sigma);
    loops_csv << closure.feature_inliers;
    number(closure.cameras_sigma);
    number(rad_to_deg(closure.flow_heading_rad));
    number(closure.contour_cost_m);
    number(closure.contour_overlap);
    number(closure.chi2_growth);
    number(closure.T_earlier_recent.x_m);
    number(closure.T_earlier_recent.y_m);
    number(rad_to_deg(closure.T_earlier_recent.theta_rad));
    if (f.known) {
      const Pose2 T = f.true_T_scene_body[static_cast<std::size_t>(closure.earlier)].inverse() *
                      f.true_T_scene_body[static_cast<std::size_t>(closure.recent)];
      loops_csv << T.x_m << T.y_m << rad_to_deg(T.theta_rad);
    } else {
      loops_csv.skip().skip().skip();
    }
    loops_csv << (closure.accepted ? 1 : 0);
    if (f.known) {
      loops_csv << (is_correct(closure, f.true_T_scene_body) ? 1 : 0);
    } else {
      loops_csv.skip();
    }
    loops_csv << closure.verdict;
    loops_csv.end_row();
  }
  loops_csv.finish();

  CsvWriter exploration_csv(out_dir_ / "exploration.csv", {"stamp_s", "mapped_m2", "coverage"});
  for (const CoverageSample& s : f.coverage) {
    exploration_csv << s.stamp << s.mapped_m2;
    if (s.coverage) {
      exploration_csv << *s.coverage;
    } else {
      exploration_csv.skip();
    }
    exploration_csv.end_row();
  }
  exploration_csv.finish();

  // the pictures
  const auto picture = [&](const char* name, const cv::Mat& bgr) {
    write_file(out_dir_ / name, png(bgr));
    report.pictures.push_back(out_dir_ / name);
  };
  const std::string run_name = info_.mission + ", seed " + std::to_string(info_.seed);
  MapPicture map_picture{result.map, positions(f.T_map_body), positions(true_T_map_body), {}, {}};
  map_picture.title = run_name + ": " + fixed(f.coverage.back().mapped_m2, 1) + " m2 of floor in " +
                      fixed(run_s, 0) + " s";
  for (const ClosureReport& closure : f.closures) {
    if (closure.accepted) {
      map_picture.loops.push_back(
          {f.T_map_body[static_cast<std::size_t>(closure.earlier)].position(),
           f.T_map_body[static_cast<std::size_t>(closure.recent)].position(),
           f.known && !is_correct(closure, f.true_T_scene_body)});
    }
  }
  picture("map.png", draw_map(map_picture));

  if (!place_rows.empty()) {
    picture("places.png", draw_places({{run_name, place_rows}}));
  }

  Plot coverage_plot;
  coverage_plot.title = f.known ? "Share of the reachable floor that is mapped" : "Mapped floor";
  coverage_plot.x_label = "time [s]";
  coverage_plot.y_label = f.known ? "coverage [%]" : "free floor [m2]";
  Curve coverage_curve{"coverage", kEstimateColour, {{0, 0}}};
  for (const CoverageSample& s : f.coverage) {
    if (!f.known || s.coverage) {
      coverage_curve.points.emplace_back(to_seconds(s.stamp),
                                         f.known ? 100 * *s.coverage : s.mapped_m2);
    }
  }
  coverage_plot.curves = {coverage_curve};
  if (f.known) {
    coverage_plot.y_top = 100;
    coverage_plot.levels = {{50, "50 %"}, {90, "90 %"}, {97, "97 %"}};
  }
  picture("coverage.png", draw_plot(coverage_plot));

  if (f.known && !f.T_map_body.empty()) {
    Plot errors;
    errors.title = "Distance of keyframes from the truth";
    errors.x_label = "time [s]";
    errors.y_label = "error [cm]";
    Curve odometry_error{"wheels alone", kOdometryColour, {}};
    Curve estimate_error{"after relaxation", kEstimateColour, {}};
    for (std::size_t i = 0; i < f.T_scene_estimate.size(); ++i) {
      const double t_s = to_seconds(result.keyframes[i].stamp);
      const Vec2 p_scene = f.true_T_scene_body[i].position();
      estimate_error.points.emplace_back(t_s,
                                         100 * (f.T_scene_estimate[i].position() - p_scene).norm());
      odometry_error.points.emplace_back(t_s,
                                         100 * (f.T_scene_odometry[i].position() - p_scene).norm());
    }
    errors.curves = {odometry_error, estimate_error};
    bool any_wrong = false;
    for (const auto& [stamp, closure] : closures_) {
      if (closure.accepted) {
        const bool wrong = !is_correct(closure, f.true_T_scene_body);
        any_wrong = any_wrong || wrong;
        errors.ticks.push_back({to_seconds(stamp), wrong ? kWrongColour : kLoopColour});
      }
    }
    if (!errors.ticks.empty()) {
      errors.tick_names.emplace_back("loop closed", kLoopColour);
    }
    if (any_wrong) {
      errors.tick_names.emplace_back("wrongly", kWrongColour);
    }
    picture("errors.png", draw_plot(errors));
  }

  // what it cost, and the verdict
  const ProcessUse use = process_use();
  metrics["wall_s"] = use.wall_s;
  metrics["cpu_s"] = use.cpu_s;
  if (loop_s > 0) {
    metrics["real_time_factor"] = run_s / loop_s;
  }
  metrics["peak_memory_mb"] = use.peak_memory_mb;
  if (clock_ != nullptr) {
    Json timing_ms = Json::object();
    Json timing_cpu_ms = Json::object();
    for (const auto& [stage, t] : clock_->figures()) {
      timing_ms[stage] = {
          {"mean", t.mean_ms}, {"p50", t.p50_ms}, {"p99", t.p99_ms}, {"max", t.max_ms}};
      timing_cpu_ms[stage] = {{"mean", t.cpu_mean_ms}};
    }
    metrics["timing_ms"] = timing_ms;
    metrics["timing_cpu_ms"] = timing_cpu_ms;
  }
  const Judged judged = judge(info_.require, metrics, [&](const Requirement& requirement) {
    return info_.judged && (driven || !is_of_driving(requirement.figure));
  });
  metrics["requirements"] = judged.lines;
  write_file(out_dir_ / "metrics.json", metrics.dump(2) + "\n");

  report.exit_status = end.outcome == "interrupted"                       ? 130
                       : end.outcome == "device_lost"                     ? 3
                       : end.outcome == "completed" && judged.broken == 0 ? 0
                                                                          : 1;

  // in a few lines
  auto& s = report.summary;
  s.push_back(end.outcome + (end.end_reason.empty() ? "" : " (" + end.end_reason + ")") +
              " after " + fixed(run_s, 0) + " s: " + fixed(metrics["distance_m"].get<double>(), 1) +
              " m driven, " + std::to_string(result.keyframes.size()) + " keyframes, " +
              std::to_string(loops.accepted) + " loops closed" +
              (f.known ? ", " + std::to_string(loops.against_truth.wrong) + " wrong" : ""));
  std::string map_line = "map: " + fixed(f.coverage.back().mapped_m2, 1) + " m2 free";
  if (f.coverage.back().coverage) {
    map_line += ", " + fixed(100 * *f.coverage.back().coverage, 1) + " % of the reachable floor";
  }
  s.push_back(map_line);
  if (metrics.contains("trajectory")) {
    const Json& t = metrics["trajectory"];
    std::string line = "position: " + centimetres(t["ate_rmse_m"].get<double>()) +
                       " rms from the truth, wheels alone " +
                       centimetres(t["odometry_ate_rmse_m"].get<double>());
    if (metrics.contains("checkpoints")) {
      line += "; checkpoints " + centimetres(metrics["checkpoints"]["error_mean_m"].get<double>()) +
              " mean, " + centimetres(metrics["checkpoints"]["error_max_m"].get<double>()) +
              " at most";
    }
    s.push_back(line);
  }
  if (metrics.contains("collisions")) {
    std::string contacts = std::to_string(collisions(*truth)) + " collisions";
    if (const auto clearance = min_clearance_m(*truth)) {
      contacts += ", " + centimetres(*clearance) + " clear at the closest";
    }
    s.push_back(contacts);
  }
  if (!driven) {
    s.push_back("replayed: with these settings the robot would have driven differently from " +
                fixed(to_seconds(*end.commands_diverged_at), 1) +
                " s on; no figures are given that driving decides");
  }
  s.push_back(fixed(loop_s > 0 ? run_s / loop_s : 0, 1) + " times real time, " +
              fixed(use.peak_memory_mb, 0) + " MB");
  if (!judged.unjudged.empty()) {
    s.push_back("not judged: " + joined(judged.unjudged) +
                (info_.judged ? " (figures that driving decides)"
                              : " (a recording is done when it is recorded)"));
  }
  for (std::size_t i = 0; i < info_.require.size(); ++i) {
    const Json& line = judged.lines[i];
    if (line["pass"] == false) {
      s.push_back(
          "broken: " + info_.require[i].text +
          (line.contains("value") ? ", it is " + line["value"].dump() : ", no such figure"));
    }
  }
  return report;
}

}  // namespace panoptes
