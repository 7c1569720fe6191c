// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "apps/command/command.h"
#include "apps/mission/file_kind.h"
#include "apps/mission/mission.h"
#include "apps/mission/open_robot.h"
#include "apps/place/rig_sweep.h"
#include "apps/study/placement_study.h"
#include "apps/study/study.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/geometry_fields.h"
#include "core/io/dataset.h"
#include "core/io/dataset_gaps.h"
#include "core/io/keyframe_files.h"
#include "core/io/map_server.h"
#include "hw/replay/tracked_truth.h"
#include "sim/world/load.h"

namespace panoptes {
namespace {

using CheckFile = void (*)(const std::string& file);

// Missions under each rig and rung, as far as it can be told without a seed.
void check_cells(const std::vector<StudyCell>& cells) {
  std::vector<std::string> faults;
  for (const StudyCell& cell : cells) {
    try {
      load_mission<ExploreMission>(cell.mission_file, cell.settings.set, needs_of(cell.command));
    } catch (const ConfigError& error) {
      for (const std::string& line : with_places(cell.settings, error.lines())) {
        if (std::find(faults.begin(), faults.end(), line) == faults.end()) {
          faults.push_back(line);
        }
      }
    }
  }
  if (!faults.empty()) {
    throw ConfigError(faults);
  }
}

void check_study(const std::string& file) { check_cells(cells_of(read_study(file))); }

// What the rigs it finds are driven through, by the rig that they are compared with.
std::vector<StudyCell> drives_of(const PlacementStudy& placement) {
  if (!placement.drive) {
    return {};
  }
  const PlacementDrives& drive = *placement.drive;
  Study study;
  study.missions = drive.missions;
  study.settings = drive.settings;
  study.rigs.emplace_back();
  study.rigs.front().file = drive.against.empty() ? placement.rig : drive.against;
  study.rungs = drive.rungs.empty() ? std::vector(1, StudyRung()) : drive.rungs;
  return cells_of(study);
}

void check_placements(const std::string& file) {
  const PlacementStudy study = read_placement_study(file);
  check_placement_study(study);
  check_cells(drives_of(study));
}

void check_rig(const std::string& file) {
  for (const std::string& doubt : read_settings<Rig>(file).doubts) {
    std::printf("%s: its calibration is not to be trusted: %s\n", file.c_str(), doubt.c_str());
  }
}

CheckFile check_of(const FileKind& kind) {
  static const std::map<std::string, CheckFile> kChecks{
      {"mission",
       [](const std::string& file) { check_platform(load_mission<ExploreMission>(file)); }},
      {"world", [](const std::string& file) { sim::load_world(file); }},
      {"rig", check_rig},
      {"robot", [](const std::string& file) { read_settings<Body>(file); }},
      {"route", [](const std::string& file) { read_settings<sim::Route>(file); }},
      {"map", [](const std::string& file) { read_turned_map_server(file); }},
      {"study", check_study},
      {"placement study", check_placements},
  };
  return kChecks.at(kind.name);
}

// A mesh or a picture is named in a world, and judged there.
void refuse_what_is_no_settings(const std::string& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    throw ConfigError(file + ": is no dataset and no run with keyframes; name the files in it");
  }
  const std::string suffix = std::filesystem::path(file).extension().string();
  if (std::filesystem::exists(file, ignored) && suffix != ".yaml" && suffix != ".yml") {
    throw ConfigError(file +
                      ": is not a settings file (.yaml); meshes and pictures are checked with the "
                      "world that names them");
  }
}

const FileKind& told_kind_of(const std::string& file) {
  refuse_what_is_no_settings(file);
  if (const FileKind* kind = kind_of(file)) {
    return *kind;
  }
  throw ConfigError(
      file +
      ": cannot tell what this is; a mission has platform:, a world objects:, boxes:, "
      "generate: or floor_plan:, a rig cameras:, a robot radius_m:, a route "
      "waypoints: or tour:, a map image: and occupied_thresh:, a study rungs:, a placement "
      "study parameters:");
}

// What was gathered from somebody else's dataset.
void tell_gathered(const Dataset& dataset, const Rig& rig) {
  std::vector<std::string> rates;
  for (const auto& [name, rate] : picture_rates(dataset, rig)) {
    rates.push_back(
        fmt::format("{} {:.1f} pictures a second, {} missing", name, rate.rate_hz(), rate.missing));
  }
  const auto sets = std::count_if(dataset.observations.begin(), dataset.observations.end(),
                                  [](const auto& seen) { return !seen.pictures.empty(); });
  fmt::print("{}: {} frame sets in {:.1f} s gathered: {}; odometry interpolated from {} rows\n",
             dataset.folder, sets, to_seconds(dataset.observations.back().now), joined(rates),
             dataset.odometry_rows.size());
}

// A recorded run as it is replayed; one that no rig is known of as far as it can be read.
std::vector<std::string> check_replay(const std::string& folder, Rig& rig) {
  std::error_code ignored;
  const bool has_mission =
      std::filesystem::exists(std::filesystem::path(folder) / "mission.yaml", ignored);
  const std::string own_mission = "platform: {kind: recorded, dataset: " + folder + "}";
  if (!has_mission && !read_beliefs(folder).rig) {
    Dataset dataset = read_dataset(folder);
    check_pictures(dataset, rig);
    hw::truth_of(folder, dataset);
    dataset.warnings.push_back(folder +
                               ": has no rig.yaml; to replay it, put one there, or write a mission "
                               "with rig: and " +
                               own_mission);
    return dataset.warnings;
  }
  const auto mission = load_mission<ExploreMission>(
      folder, {}, has_mission ? CameraRequirement::kDriver : CameraRequirement::kNothing);
  OpenRobot open = open_robot(mission, Rng(mission.seed));
  rig = open.rig;
  if (!has_mission) {
    open.warnings.push_back(
        folder +
        ": has no mission.yaml; it is replayed with every setting's default, or "
        "by a mission with " +
        own_mission);
  }
  if (!has_mission && !can_navigate(rig)) {
    open.warnings.push_back(folder +
                            "/rig.yaml: has no camera with a role that begins with loop_, or none "
                            "with the role floor; panoptes explore cannot map with it");
  }
  return open.warnings;
}

// The exit status.
int check_dataset(const std::string& folder) {
  Rig rig;
  const std::vector<std::string> warnings = check_replay(folder, rig);
  const Dataset dataset = read_dataset(folder, rig);
  if (!dataset.ours) {
    tell_gathered(dataset, rig);
  }
  for (const std::string& warning : warnings) {
    std::printf("%s\n", warning.c_str());
  }
  return gap_lines(dataset, rig).empty() ? 0 : 1;
}

// What a run keeps of its places.
void check_keyframes(const std::string& run_dir) {
  const std::size_t keyframes = read_keyframes(run_dir).all.size();
  const std::filesystem::path folder = std::filesystem::path(run_dir) / "keyframes";
  const double bytes = static_cast<double>(file_size(folder / "signatures.bin") +
                                           file_size(folder / "features.bin"));
  std::printf("%s: %zu keyframes, %.1f kB of signatures and features each\n",
              folder.string().c_str(), keyframes,
              bytes / 1000 / static_cast<double>(std::max<std::size_t>(1, keyframes)));
}

// The exit status that the file alone would give.
int check_file(const std::string& file) {
  try {
    std::error_code ignored;
    const bool run =
        std::filesystem::is_directory(std::filesystem::path(file) / "keyframes", ignored);
    const bool dataset =
        std::filesystem::is_directory(std::filesystem::path(file) / "mav0", ignored);
    const int status = dataset ? check_dataset(file) : 0;
    if (run) {
      check_keyframes(file);
    }
    if (run || dataset) {
      std::printf("%s: %s (%s)\n", file.c_str(), status == 0 ? "ok" : "has gaps",
                  dataset ? "dataset" : "run");
      return status;
    }
    const FileKind& kind = told_kind_of(file);
    check_of(kind)(file);
    std::printf("%s: ok (%s)\n", file.c_str(), kind.name.c_str());
    return 0;
  } catch (const ConfigError& error) {
    std::printf("%s\n", error.what());
    return 2;
  } catch (const IoError& error) {
    std::printf("%s\n", error.what());
    return 3;
  }
}

// What the user wrote is told before what the machine lacks.
int check(const std::vector<std::string>& files) {
  int status = 0;
  for (const std::string& file : files) {
    const int one = check_file(file);
    status = one == 2 || status == 0 || (one == 3 && status == 1) ? one : status;
  }
  return status;
}

}  // namespace

void add_check(CLI::App& app, Command& chosen) {
  auto files = std::make_shared<std::vector<std::string>>();
  CLI::App* sub = app.add_subcommand("check", "Is this configuration right?");
  sub->add_option("files", *files,
                  "missions, worlds, rigs, robots, routes, maps, studies, datasets, runs")
      ->required()
      ->type_name("FILE...");
  sub->footer("Example: panoptes check scenes/missions/*.yaml scenes/worlds/*.yaml");
  sub->callback([files, &chosen] { chosen = [files] { return check(*files); }; });
}

}  // namespace panoptes
