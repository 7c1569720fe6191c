// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/placed_rig.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "apps/mission/file_kind.h"
#include "core/base/error.h"
#include "core/config/fields.h"
#include "core/config/geometry_fields.h"
#include "sim/world/body_faces.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kParts[] = {"rig.", "robot.", "scores."};

/// The overrides of one part, by their names within it.
std::vector<std::string> part_of(const std::vector<std::string>& overrides, std::string_view part) {
  std::vector<std::string> own;
  for (const std::string& override : overrides) {
    if (override.starts_with(part)) {
      own.push_back(override.substr(part.size()));
    }
  }
  return own;
}

/// What is said of an override, by the name that the user gave it.
std::vector<std::string> with_part(std::vector<std::string> lines, std::string_view part) {
  constexpr std::string_view kSet = "--set ";
  for (std::string& line : lines) {
    if (line.starts_with(kSet)) {
      line.insert(kSet.size(), part);
    }
  }
  return lines;
}

void refuse_other_parts(const std::vector<std::string>& overrides) {
  for (const std::string& override : overrides) {
    if (std::none_of(std::begin(kParts), std::end(kParts),
                     [&](std::string_view part) { return override.starts_with(part); })) {
      throw ConfigError(
          "--set " + override +
          ": must begin with rig., robot. or scores., as rig.cameras.floor.tilt_deg=30 "
          "or scores.latency_s=0.1");
    }
  }
}

/// With what the file is instead.
void refuse_other_than_rig(const std::string& file) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) {
    throw ConfigError(file + ": is a folder; give a rig file, as the rig_refined.yaml of a run");
  }
  if (!fs::exists(file, ignored)) {
    return;  // whoever reads it says so
  }
  const FileKind* kind = kind_by_keys(file);
  if (kind != nullptr && kind->name != "rig") {
    throw ConfigError(file + ": is a " + kind->name +
                      ", not a rig; give the file of a rig, see scenes/rigs");
  }
}

std::string name_of(const std::string& file, const std::vector<PlacedRig>& others) {
  const std::string stem = fs::path(file).stem().string();
  std::string name = stem;
  for (int n = 2; std::any_of(others.begin(), others.end(),
                              [&](const PlacedRig& other) { return other.name == name; });
       ++n) {
    name = stem + "-" + std::to_string(n);
  }
  return name;
}

}  // namespace

Calibratability calibratability(const RigScoreOptions& scores, const Rig& rig, const Body& robot) {
  CalibratabilityOptions motion;
  motion.plan.room_m = scores.motion.room_m;
  return calibratability(motion, rig, robot);
}

std::vector<NamedScore> named_scores(const std::optional<Calibratability>& left) {
  std::vector<NamedScore> all{
      {"calibratability.rotation_deg", "roll, pitch, yaw", "deg", 1, 3, Better::kLower, {}},
      {"calibratability.position_m", "x, y", "mm", 1000, 1, Better::kLower, {}}};
  if (left) {
    all[0].value = rad_to_deg(left->rotation_rad);
    all[1].value = left->position_m;
  }
  return all;
}

PlaceOptions read_place_options(const std::string& robot_file,
                                const std::vector<std::string>& overrides) {
  refuse_other_parts(overrides);
  PlaceOptions options;
  const std::vector<std::string> of_robot = part_of(overrides, "robot.");
  try {
    options.robot = robot_file.empty() ? read_settings_text<Body>("{}", "robot", of_robot)
                                       : read_settings<Body>(robot_file, of_robot);
  } catch (const ConfigError& error) {
    throw ConfigError(with_part(error.lines(), "robot."));
  }
  sim::read_body_faces(options.robot);
  try {
    options.scores =
        read_settings_text<RigScoreOptions>("{}", "scores", part_of(overrides, "scores."));
  } catch (const ConfigError& error) {
    throw ConfigError(with_part(error.lines(), "scores."));
  }
  return options;
}

std::vector<PlacedRig> read_rigs(const std::vector<std::string>& files, const Body& robot,
                                 const std::vector<std::string>& overrides) {
  std::vector<PlacedRig> rigs;
  std::vector<std::string> faults;
  for (const std::string& file : files) {
    try {
      refuse_other_than_rig(file);
      PlacedRig placed;
      placed.file = file;
      placed.name = name_of(file, rigs);
      placed.rig = read_settings<Rig>(file, part_of(overrides, "rig."));
      for (const std::string& fault : placement_faults(placed.rig, robot)) {
        faults.push_back(file + ": " + fault);
      }
      rigs.push_back(std::move(placed));
    } catch (const ConfigError& error) {
      const std::vector<std::string> lines = with_part(error.lines(), "rig.");
      faults.insert(faults.end(), lines.begin(), lines.end());
    }
  }
  if (!faults.empty()) {
    throw ConfigError(faults);
  }
  return rigs;
}

}  // namespace panoptes
