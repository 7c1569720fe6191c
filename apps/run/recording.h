// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "apps/mission/mission.h"

namespace panoptes {

/// Drives a mission and keeps all that the robot perceived and was told in a dataset, which is the
/// run's directory, too. What the mission requires of a whole run, a recording of any part of it
/// need not meet. The exit status.
int record_mission(const ExploreMission& mission, const std::filesystem::path& out_dir, bool quiet);

}  // namespace panoptes
