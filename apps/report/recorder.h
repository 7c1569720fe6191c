// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/process/fault.h"
#include "apps/process/stage_clock.h"
#include "apps/recognition/recognition_study.h"
#include "apps/report/finished_run.h"
#include "apps/step/step_listener.h"
#include "core/camera/observation.h"
#include "core/eval/run_result.h"
#include "core/eval/truth.h"
#include "core/io/csv.h"
#include "core/io/keyframe_files.h"

namespace panoptes {

struct RunReport {
  int exit_status = 0;
  std::vector<std::string> summary;  ///< a few lines for people
  std::vector<std::filesystem::path> pictures;
};

/// What a run's mission.yaml holds: the version as a comment, and every setting.
std::string mission_text(const std::string& version, const std::string& mission_yaml);

/// Writes the run directory (its files and figures are a contract with other programs). Construct
/// it right before the loop: the real-time factor counts from there.
class Recorder : public StepListener {
 public:
  /// `out_dir` is there (OutDir). `clock` may be null, and outlives the recorder.
  Recorder(std::filesystem::path out_dir, RunInfo info, StageClock* clock);

  /// Once a step; a few microseconds.
  void add(const Observation& seen, const SlamStep& at, const PilotStep& step) override;

  /// Whether coverage over time wants the map as it is now: every 10 s.
  bool snapshot_due(Time now) const;
  void add_snapshot(Time now, OccupancyMap map);

  /// Leaves a metrics.json that says `failed`, until the report takes its place.
  void keep_ended();

  /// All that is left behind: what a picture can be made from first, then metrics.json, then the
  /// pictures, until `hurried` says that they are not waited for. Without truth the figures that
  /// need it are absent. `faults` are those of the run until here. Never throws for what cannot be
  /// found out or written: what can be is, and metrics.json, the exit status and stderr tell.
  RunReport write_report(std::optional<Truth> truth, const RunResult& result, RunEnd end,
                         const KeptKeyframes& kept = {}, const RecognitionStudy* places = nullptr,
                         Faults faults = {}, const std::function<bool()>& hurried = {});

 private:
  void keep_settings();
  void add_row(const Observation& seen, const SlamStep& at, const PilotStep& step);

  std::filesystem::path out_dir_;
  FinishedRun run_;  ///< as far as it is known
  StageClock* clock_;
  double loop_from_s_;
  bool settings_kept_ = false;
  CsvWriter steps_;
  std::optional<Time> now_;  ///< of the last step
  std::optional<Time> last_frontier_;
  std::optional<Time> next_snapshot_;
};

}  // namespace panoptes
