// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/mission/mission.h"

namespace CLI {
class App;
}

namespace panoptes {

/// `--refined RUN`: what an earlier run has learned of the rig is what the robot believes.
void add_refined(CLI::App& subcommand, std::optional<std::string>& run);

/// The overrides of a mission with the rig of that run as their first, so that `--set` reaches into
/// it; as they are without one. Throws ConfigError where there is no such run, where it has left no
/// rig, where that has other cameras than the mission, and where a `--set` names another rig.
std::vector<std::string> with_refined(const std::optional<std::string>& run,
                                      const std::string& mission_file,
                                      std::vector<std::string> overrides,
                                      CameraRequirement needs = CameraRequirement::kDriver);

}  // namespace panoptes
