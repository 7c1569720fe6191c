// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/file_kind.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "core/base/error.h"
#include "core/config/fields.h"

namespace panoptes {

namespace fs = std::filesystem;

const std::vector<FileKind>& file_kinds() {
  static const std::vector<FileKind> kKinds{
      {"placement study",  // it names a rig and has lines of require: as a mission has
       "placements",
       {"parameters", "sweep", "objectives"},
       "panoptes place FILE scores all of its rigs"},
      {"mission", "missions", {"platform", "rig", "until", "drive", "navigator", "require"}, ""},
      {"world",
       "worlds",
       {"objects", "boxes", "lights", "ambient", "generate", "floor_plan", "people", "include"},
       "a mission names it as platform: {kind: simulated, world: FILE}, see scenes/missions"},
      {"rig", "rigs", {"cameras"}, "a mission names it as rig: FILE, see scenes/missions"},
      {"robot",
       "robots",
       {"radius_m", "height_m", "wheel_base_m", "wheel_radius_m", "max_speed_mps"},
       "a mission names it as robot: FILE, see scenes/missions"},
      {"route",
       "routes",
       {"waypoints", "tour"},
       "a mission names it as drive: {route: FILE}, see scenes/missions"},
      {"map",
       "maps",
       {"occupied_thresh", "free_thresh"},
       "a mission names it as platform: {kind: simulated, world: {floor_plan: {map: FILE}}}, see "
       "scenes/missions"},
      {"study",
       "studies",
       {"missions", "rigs", "rungs", "limits"},
       "panoptes trials --study FILE runs all of its missions"},
  };
  return kKinds;
}

const FileKind* kind_by_keys(const std::string& file) {
  const std::vector<std::string> keys = settings_keys(file);
  for (const FileKind& kind : file_kinds()) {
    if (std::find_first_of(keys.begin(), keys.end(), kind.keys.begin(), kind.keys.end()) !=
        keys.end()) {
      return &kind;
    }
  }
  return nullptr;
}

const FileKind* kind_of(const std::string& file) {
  if (const FileKind* kind = kind_by_keys(file)) {
    return kind;
  }
  const std::string folder = fs::path(file).parent_path().filename().string();
  for (const FileKind& kind : file_kinds()) {
    if (folder == kind.folder) {
      return &kind;
    }
  }
  return nullptr;
}

void refuse_other_than_mission(const std::string& file) {
  std::error_code ignored;
  const fs::path mission = fs::path(file) / "mission.yaml";
  if (fs::is_directory(file, ignored) && fs::exists(mission, ignored)) {
    throw ConfigError(file +
                      ": is the folder of a run, not a mission; the mission of that run is " +
                      mission.string());
  }
  if (!fs::is_regular_file(file, ignored)) {
    return;
  }
  const FileKind* kind = nullptr;
  try {
    kind = kind_by_keys(file);
  } catch (const ConfigError&) {
    return;  // whoever reads it whole says more
  }
  if (kind != nullptr && !kind->use.empty()) {
    throw ConfigError(file + ": is a " + kind->name + ", not a mission; " + kind->use);
  }
}

}  // namespace panoptes
