// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/eval/requirement.h"
#include "core/eval/run_result.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "core/loops/closure.h"
#include "core/map/occupancy.h"
#include "core/nav/pilot_step.h"
#include "core/vision/camera_health.h"

namespace panoptes {

/// What a run is, before it starts.
struct RunInfo {
  std::string command = "explore";
  std::string version;
  std::string mission;  ///< the mission's file name without its folder
  std::uint64_t seed = 0;
  std::string mission_yaml;  ///< every setting as resolved
  std::vector<Requirement> require;
  bool no_cameras = false;           ///< without cameras: every observation is a frame set
  bool judged = true;                ///< whether `require` decides the exit status
  std::optional<Pose2> T_scene_map;  ///< of the run that founded the map; else this one's start
  std::optional<std::int64_t> start_unix_ns;  ///< physical and served runs
  std::optional<Rig> rig = {};                ///< as believed; empty where that is not known
  std::optional<Body> body = {};              ///< likewise
};

/// How it ended.
struct RunEnd {
  std::string outcome = "completed";  ///< becomes `collision` or `stuck` where the run was that
  std::string end_reason;             ///< of a completed run; else what happened, for the summary
  std::optional<Time> commands_diverged_at = {};  ///< a replay that would have driven elsewhere
  std::map<std::string, std::map<std::string, double>> devices =
      {};                                  ///< what each of them counted, by its name
  CameraReports cameras = {};              ///< empty where nobody watched them
  bool touches_known = true;               ///< the truth, where there is one, tells of contacts
  std::vector<std::string> warnings = {};  ///< what the user ought to know of it, in words
  std::string fault = {};  ///< what cut it short or kept a file from being written, a line each
};

/// A run that is over, as plain values: all that its figures are made of but the truth.
struct FinishedRun {
  struct Frame {  ///< a frame set
    Time stamp;
    Pose2 T_odom_body;  ///< by the wheels alone
    bool has_goal = false;
  };
  struct Snapshot {  ///< the map on the way
    Time stamp;
    double mapped_m2 = 0;
    std::optional<OccupancyMap> map;  ///< where it was kept
  };

  RunInfo info;
  RunEnd end;
  RunResult result;
  std::vector<Frame> frames;
  std::vector<Snapshot> snapshots;
  std::vector<std::pair<Time, ClosureReport>> closures;  ///< accepted and rejected
  std::vector<GoalProgress> goals;  ///< that it was told to drive to, as it says itself
  Time last_step{};
  std::optional<Duration> end_delay;  ///< from the last frontier to the end
};

}  // namespace panoptes
