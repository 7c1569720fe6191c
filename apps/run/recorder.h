// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/run/finished_run.h"
#include "apps/run/place_study.h"
#include "apps/run/stage_clock.h"
#include "core/camera/observation.h"
#include "core/eval/run_result.h"
#include "core/eval/truth.h"
#include "core/io/csv.h"
#include "core/io/keyframe_files.h"
#include "core/nav/nav_step.h"

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
class Recorder {
 public:
  /// `out_dir` is there (OutDir). `clock` may be null, and outlives the recorder.
  Recorder(std::filesystem::path out_dir, RunInfo info, StageClock* clock);

  /// Once a step; a few microseconds.
  void add(const Observation& seen, const NavStep& step);

  /// Whether coverage over time wants the map as it is now: every 10 s.
  bool snapshot_due(Time now) const;
  void add_snapshot(Time now, OccupancyMap map);

  /// All that is left behind, metrics.json last. Without truth the figures that need it are absent.
  RunReport write_report(std::optional<Truth> truth, const RunResult& result, RunEnd end,
                         const std::vector<KeptKeyframe>& kept = {},
                         const PlaceStudy* places = nullptr);

 private:
  void keep_settings();

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
