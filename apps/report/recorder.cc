// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/recorder.h"

#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "apps/report/run_figures.h"
#include "apps/report/run_files.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

constexpr Duration kSnapshotEvery = std::chrono::seconds(10);

const char* name_of(PilotState state) {
  switch (state) {
    case PilotState::kDriving:
      return "driving";
    case PilotState::kRecovering:
      return "recovering";
    case PilotState::kStopped:
      return "stopped";
  }
  return "";
}

/// What the run cost, as JSON.
std::string costs(const StageClock* clock, double run_s, double loop_s) {
  const ProcessUse use = process_use();
  Json json{{"wall_s", use.wall_s}, {"cpu_s", use.cpu_s}};
  if (loop_s > 0) {
    json["real_time_factor"] = run_s / loop_s;
  }
  json["peak_memory_mb"] = use.peak_memory_mb;
  if (clock != nullptr) {
    Json timing_ms = Json::object();
    Json timing_cpu_ms = Json::object();
    for (const auto& [stage, t] : clock->figures()) {
      timing_ms[stage] = {
          {"mean", t.mean_ms}, {"p50", t.p50_ms}, {"p99", t.p99_ms}, {"max", t.max_ms}};
      timing_cpu_ms[stage] = {{"mean", t.cpu_mean_ms}, {"p99", t.cpu_p99_ms}};
    }
    json["timing_ms"] = timing_ms;
    json["timing_cpu_ms"] = timing_cpu_ms;
  }
  return json.dump();
}

}  // namespace

std::string mission_text(const std::string& version, const std::string& mission_yaml) {
  return "# panoptes " + version + "\n" + mission_yaml;
}

Recorder::Recorder(std::filesystem::path out_dir, RunInfo info, StageClock* clock)
    : out_dir_(std::move(out_dir)),
      clock_(clock),
      loop_from_s_(steady_s()),
      steps_(out_dir_ / "steps.csv",
             {"stamp_s", "x_m", "y_m", "theta_deg", "command_v_mps", "command_w_radps", "goal_x_m",
              "goal_y_m", "keyframe", "state", "why", "mapped_m2"}) {
  run_.info = std::move(info);
}

void Recorder::keep_settings() {
  if (!settings_kept_) {
    write_file(out_dir_ / "mission.yaml", mission_text(run_.info.version, run_.info.mission_yaml));
    settings_kept_ = true;
  }
}

void Recorder::add(const Observation& seen, const SlamStep& at, const PilotStep& step) {
  keep_settings();
  now_ = seen.stamp;
  if (!next_snapshot_) {
    next_snapshot_ = seen.stamp + kSnapshotEvery;
  }
  if (!step.goals.empty()) {
    run_.goals = step.goals;
  }
  if (step.frontier_reachable) {
    last_frontier_ = seen.stamp;
  }
  for (const ClosureReport& closure : at.closures) {
    ClosureReport kept = closure;
    kept.contour_earlier = {};  // the largest part; a step is for showing it
    kept.contour_recent = {};
    run_.closures.emplace_back(seen.stamp, std::move(kept));
  }
  // a deadline that comes just before a late report tells of an instant after the report's
  const bool later = run_.frames.empty() || seen.stamp > run_.frames.back().stamp;
  // pictures that do not come stop the robot, which has to be told
  const bool counts = run_.info.no_cameras || step.camera_lost;
  if (seen.pictures.empty() && !(counts && later)) {
    return;
  }
  const std::optional<Odometry> odometry = told_odometry(seen, at);
  const Pose2 T_odom_last = run_.frames.empty() ? Pose2() : run_.frames.back().T_odom_body;
  run_.frames.push_back(
      {seen.stamp, odometry ? odometry->T_odom_body : T_odom_last, step.goal_map.has_value()});
  try {
    add_row(seen, at, step);
  } catch (...) {  // tables of frame sets have the same ones
    run_.frames.pop_back();
    steps_.drop_row();
    throw;
  }
}

void Recorder::add_row(const Observation& seen, const SlamStep& at, const PilotStep& step) {
  steps_ << seen.stamp << at.T_map_body.x_m << at.T_map_body.y_m
         << rad_to_deg(at.T_map_body.theta_rad) << step.command_body.v_mps
         << step.command_body.w_radps;
  if (step.goal_map) {
    steps_ << step.goal_map->x() << step.goal_map->y();
  } else {
    steps_.skip().skip();
  }
  if (at.keyframe_made) {
    steps_ << *at.keyframe_made;
  } else {
    steps_.skip();
  }
  steps_ << name_of(step.state) << step.reason << step.mapped_free_m2;
  steps_.end_row();
}

bool Recorder::snapshot_due(Time now) const { return next_snapshot_ && now >= *next_snapshot_; }

void Recorder::add_snapshot(Time now, OccupancyMap map) {
  const double mapped_m2 = map.area_m2(Cell::kFree);
  run_.snapshots.push_back({now, mapped_m2, std::move(map)});
  next_snapshot_ = now + kSnapshotEvery;
}

// Until its figures are found: whatever ends the program first, there is one that says so.
void Recorder::keep_ended() {
  run_.end = {"failed", ""};
  run_.end.fault = "ended before its figures were found";
  write_file(out_dir_ / "metrics.json", bare_verdict(run_).metrics_json);
}

RunReport Recorder::write_report(std::optional<Truth> truth, const RunResult& result, RunEnd end,
                                 const KeptKeyframes& kept, const RecognitionStudy* places,
                                 Faults faults, const std::function<bool()>& hurried) {
  const double loop_s = steady_s() - loop_from_s_;
  faults.attempt([&] { keep_ended(); });
  run_.end = std::move(end);
  run_.last_step = now_.value_or(Time{});
  run_.end_delay = run_.last_step - last_frontier_.value_or(Time{});
  faults.attempt([&] { run_.result = result; });
  std::optional<RunTruth> known;
  if (truth) {
    known = RunTruth{std::move(*truth), run_.end.touches_known};
  }
  RunFindings findings;
  if (!faults.attempt([&] { findings = find_out(run_, known ? &*known : nullptr); })) {
    faults.attempt([&] { findings = find_out(run_, nullptr); });
  }
  if (findings.coverage.empty()) {
    findings.coverage.push_back({run_.last_step, 0, std::nullopt});
  }
  std::vector<RecognitionRow> place_rows;
  if (places != nullptr && findings.known != nullptr) {
    faults.attempt([&] { place_rows = places->rows(findings.true_T_scene_body, findings.path_m); });
  }

  faults.attempt([&] { keep_settings(); });
  faults.attempt([&] { steps_.finish(); });
  write_run_files(out_dir_, run_, findings, faults);
  if (!kept.all.empty()) {
    if (!faults.attempt([&] { write_keyframes(out_dir_, kept); })) {
      std::error_code ignored;  // of no use in part
      std::filesystem::remove_all(out_dir_ / "keyframes", ignored);
    }
  }
  if (!place_rows.empty()) {
    faults.attempt([&] { write_recognition_rows(out_dir_ / "places.csv", place_rows); });
  }
  RunReport report;
  RunVerdict verdict;
  const auto take_faults = [&] {
    run_.end.fault = faults.text();
    if (!faults.none() && run_.end.outcome == "completed") {
      run_.end.outcome = "failed";
      run_.end.end_reason.clear();
    }
  };
  const auto tell = [&] {
    take_faults();
    const bool judged = faults.attempt([&] {
      verdict =
          judge_run(run_, findings, place_rows, costs(clock_, to_seconds(run_.last_step), loop_s));
    });
    if (!judged) {
      take_faults();
      verdict = bare_verdict(run_);
    }
    faults.attempt([&] { write_file(out_dir_ / "metrics.json", verdict.metrics_json); });
  };
  tell();
  report.pictures = draw_run(out_dir_, run_, findings, place_rows, faults, hurried);
  tell();  // how long it took, and what could not be drawn
  report.exit_status = faults.none() ? verdict.exit_status : faults.status();
  report.summary = std::move(verdict.summary);
  return report;
}

}  // namespace panoptes
