// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/recorded_here.h"

#include <cstdio>
#include <optional>
#include <system_error>
#include <variant>

#include <fmt/format.h>

#include "apps/calibrate/stage_metrics.h"
#include "apps/command/folder_lock.h"
#include "apps/command/out_dir.h"
#include "apps/mission/mission.h"
#include "apps/report/recorder.h"
#include "apps/run/recording.h"
#include "core/base/error.h"
#include "core/io/dataset_rows.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMissionFile = "mission.yaml";

/// Whether what lies there is this mission's, whole. A simulated drive that was cut short is to be
/// driven again: it begins the same. Throws for what else is no whole recording of it.
bool is_whole(const fs::path& recording, const ExploreMission& mission) {
  const std::string as_it_is =
      fmt::format("calibrate it as it is with panoptes calibrate {} --out DIR", recording.string());
  const std::string outcome = told_in_metrics(recording, "outcome").value_or("killed");
  const bool is_cut_short = outcome != "completed";
  const bool is_same = read_part(recording / kMissionFile) ==
                       mission_text(PANOPTES_VERSION, write_settings(mission));
  if (is_cut_short && is_same && std::holds_alternative<sim::SimulatedOptions>(mission.platform)) {
    return false;
  }
  if (is_cut_short) {
    throw ConfigError(fmt::format("{}: was cut short ({}); remove it to record it anew, or {}",
                                  recording.string(), outcome, as_it_is));
  }
  if (!is_same) {
    throw ConfigError(
        fmt::format("{}: is of another mission, other settings or another version; name another "
                    "folder with --out, or {}",
                    recording.string(), as_it_is));
  }
  return true;
}

}  // namespace

fs::path DriveToRecord::dataset() const { return out / "recording"; }

int record_here(const DriveToRecord& drive) {
  const auto mission = load_mission<ExploreMission>(drive.mission, drive.overrides);
  const fs::path recording = drive.dataset();
  std::error_code ignored;
  const bool is_begun = fs::exists(recording, ignored) && !fs::is_empty(recording, ignored);
  const auto keep_settings = [&] {
    fs::copy_file(recording / kMissionFile, drive.out / kMissionFile,
                  fs::copy_options::overwrite_existing);
  };
  if (is_begun && is_whole(recording, mission)) {
    keep_settings();
    return 0;
  }
  // Refused before anything is removed or driven.
  { const OutDir free(drive.out, {recording.filename().string(), kMissionFile}); }
  if (is_begun) {
    const auto lock = FolderLock::take(recording);
    if (!lock) {
      throw ConfigError(recording.string() +
                        ": another panoptes is recording there; wait for it, or name another "
                        "folder with --out");
    }
    std::fprintf(stderr, "%s: was cut short, and is recorded anew\n", recording.c_str());
    fs::remove_all(recording);
  }
  const int status = record_mission(mission, recording, drive.quiet);
  if (status != 0) {
    std::fprintf(stderr,
                 "%s: the drive was cut short, and no rig is calibrated by it; what was recorded "
                 "is kept\n",
                 recording.c_str());
    return status;
  }
  keep_settings();
  return 0;
}

}  // namespace panoptes
