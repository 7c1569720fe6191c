// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "apps/mission/mission.h"
#include "apps/mission/open_robot.h"

namespace panoptes {

/// What differs between the commands that drive a mission from its start to its end.
struct MissionRun {
  std::string command;  ///< as metrics.json calls it
  std::filesystem::path out_dir;
  bool quiet = false;  ///< no progress

  /// Puts something between the robot and who drives it; may be empty.
  std::function<void(OpenRobot& open, const std::filesystem::path& out_dir)> wrap;

  bool judged = true;  ///< by the mission's `require:`
};

/// The one loop: the robot perceives, the navigator maps and says where to drive, the recorder
/// keeps what happened, until whoever drives has nothing left to do. Leaves a run directory, prints
/// what came out, and returns the exit status.
int run_mission(const ExploreMission& mission, const MissionRun& run);

}  // namespace panoptes
