// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/run/place_study.h"
#include "apps/run/stage_clock.h"
#include "core/camera/observation.h"
#include "core/eval/coverage.h"
#include "core/eval/requirement.h"
#include "core/eval/run_result.h"
#include "core/eval/truth.h"
#include "core/io/csv.h"
#include "core/io/keyframe_files.h"
#include "core/nav/nav_step.h"

namespace panoptes {

/// What a run is, before it starts.
struct RunInfo {
  std::string command = "explore";
  std::string version;
  std::string mission;  ///< the mission's file name without its folder
  std::uint64_t seed = 0;
  std::string mission_yaml;  ///< every setting as resolved
  std::vector<Requirement> require;
  bool judged = true;                ///< whether `require` decides the exit status
  std::optional<Pose2> T_scene_map;  ///< of the run that founded the map; else this one's start
  std::optional<std::int64_t> start_unix_ns;  ///< physical and served runs
};

/// How it ended.
struct RunEnd {
  std::string outcome = "completed";  ///< becomes `collision` or `stuck` where the run was that
  std::string end_reason;             ///< of a completed run; else what happened, for the summary
  std::optional<Time> commands_diverged_at = {};  ///< a replay that would have driven elsewhere
};

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
  RunReport write_report(const std::optional<Truth>& truth, const RunResult& result, RunEnd end,
                         const std::vector<KeptKeyframe>& kept = {},
                         const PlaceStudy* places = nullptr);

 private:
  void keep_settings();

  struct Frame {
    Time stamp;
    Pose2 T_odom_body;  ///< by the wheels alone
    bool has_goal = false;
  };
  struct Snapshot {
    Time stamp;
    OccupancyMap map;
  };

  std::filesystem::path out_dir_;
  RunInfo info_;
  StageClock* clock_;
  double loop_from_s_;
  bool settings_kept_ = false;
  CsvWriter steps_;
  std::vector<Frame> frames_;
  std::vector<Snapshot> snapshots_;
  std::vector<std::pair<Time, ClosureReport>> closures_;
  std::optional<Time> now_;  ///< of the last step
  std::optional<Time> last_frontier_;
  std::optional<Time> next_snapshot_;
};

}  // namespace panoptes
