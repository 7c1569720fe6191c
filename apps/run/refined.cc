// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/refined.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <variant>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "apps/report/run_files.h"
#include "core/base/error.h"
#include "core/base/text.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

std::string refined_file(const std::string& run) {
  std::error_code ignored;
  if (!fs::is_directory(run, ignored)) {
    throw ConfigError(run + ": --refined: no such folder; name the directory that a run has left");
  }
  const std::string file = (fs::path(run) / kRefinedRig).string();
  if (!fs::exists(file, ignored)) {
    throw ConfigError(file +
                      ": --refined: no such file; name a run that has mapped, of this version or "
                      "a later one");
  }
  return file;
}

std::string cameras_of(const Rig& rig) {
  std::vector<std::string> all;
  for (const auto& [name, camera] : rig.cameras) {
    all.push_back(
        fmt::format("{} ({} x {})", name, camera.intrinsics.width_px, camera.intrinsics.height_px));
  }
  return all.empty() ? "none" : joined(all);
}

// Of its rig as written, and of the platform's; none where the mission can only be read with the
// rig that it is to be given.
std::vector<std::string> cameras_of(const std::string& mission_file,
                                    const std::vector<std::string>& overrides,
                                    CameraRequirement needs) {
  try {
    const auto mission = load_mission<ExploreMission>(mission_file, overrides, needs);
    std::vector<std::string> all{cameras_of(mission.rig)};
    const auto* simulated = std::get_if<sim::SimulatedOptions>(&mission.platform);
    if (simulated != nullptr && simulated->nominal_rig) {
      all.push_back(cameras_of(*simulated->nominal_rig));
    }
    return all;
  } catch (const ConfigError&) {
    return {};
  }
}

}  // namespace

void add_refined(CLI::App& subcommand, std::optional<std::string>& run) {
  subcommand
      .add_option("--refined", run,
                  "believe what an earlier run has learned of the rig, from its rig_refined.yaml")
      ->type_name("RUN");
}

std::vector<std::string> with_refined(const std::optional<std::string>& run,
                                      const std::string& mission_file,
                                      std::vector<std::string> overrides, CameraRequirement needs) {
  if (!run) {
    return overrides;
  }
  for (const std::string& said : overrides) {
    if (said.starts_with("rig=")) {
      throw ConfigError("--refined " + *run + ": must not be given beside --set " + said +
                        ", for both say which rig is believed; leave one of them out");
    }
  }
  const std::string file = refined_file(*run);
  const std::string cameras = cameras_of(read_settings<Rig>(file));
  const std::vector<std::string> known = cameras_of(mission_file, overrides, needs);
  if (!known.empty() && std::find(known.begin(), known.end(), cameras) == known.end()) {
    throw ConfigError(fmt::format(
        "{}: --refined: is of the cameras {}, but {} has {}; name a run with the mission's cameras",
        file, cameras, mission_file, known.back()));
  }
  overrides.insert(overrides.begin(), "rig=" + in_quotes(fs::absolute(file).string()));
  return overrides;
}

}  // namespace panoptes
