// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/drives.h"

#include <algorithm>

#include <fmt/format.h>

#include "apps/place/placed_rig.h"
#include "core/base/text.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

struct DrivenRig {
  std::string name;
  std::string what;  // of its parameters
  Rig rig;
};

std::string values_text(const PlacementStudy& study, const PlacementPoint& point) {
  std::vector<std::string> words;
  std::size_t i = 0;
  for (const auto& [name, parameter] : study.parameters) {
    words.push_back(name + " " + point.values[i++]);
  }
  return joined(words);
}

std::vector<DrivenRig> driven_rigs(const PlacementStudy& study, const RigSweep& sweep) {
  std::vector<DrivenRig> rigs;
  const std::string& against = study.drive->against.empty() ? study.rig : study.drive->against;
  rigs.push_back({fs::path(against).stem().string(), against, read_settings<Rig>(against)});
  for (const std::size_t k : promoted_rigs(sweep, static_cast<std::size_t>(study.drive->best))) {
    const PlacementPoint& point = sweep.rigs[k].point;
    rigs.push_back({fmt::format("rig-{}", k + 1), values_text(study, point), rig_of(study, point)});
  }
  return rigs;
}

// A list of one-line settings, as YAML has it.
std::string settings_text(const StudySettings& settings, const char* indent) {
  std::string text;
  for (const std::string& setting : settings.set) {
    text += fmt::format("{}- {}\n", indent, in_quotes(setting));
  }
  return text;
}

std::string score_text(const StudyScore& score) {
  return fmt::format("{}: {}", score.less_is_better() ? "least" : "most",
                     in_quotes(score.figure()));
}

std::vector<StudyRung> rungs_of(const PlacementDrives& drive) {
  if (!drive.rungs.empty()) {
    return drive.rungs;
  }
  StudyRung calibrated;
  calibrated.name = "calibrated";
  return {calibrated};
}

}  // namespace

void write_drives(const fs::path& out_dir, const PlacementStudy& study, const RigSweep& sweep,
                  const std::function<void(double done)>& progress) {
  const std::vector<DrivenRig> rigs = driven_rigs(study, sweep);
  fs::create_directories(out_dir / "rigs");
  std::string text = fmt::format(
      "# What the best rigs of {} do to navigation, against the first one:\n"
      "#   panoptes trials --study {} --seeds 1-8 --jobs 2 --out {}\n"
      "# What a programmed motion would leave of how its cameras sit stands in a rig's file, as "
      "sigmas and covariance; so far,\n"
      "# as drawn by the seed, its true cameras are off, but for what a rung says.\n"
      "missions:\n",
      study.file, (out_dir / "drives.yaml").string(), (out_dir / "drives").string());
  for (const StudyMission& mission : study.drive->missions) {
    text += fmt::format("  - name: {}\n    mission: {}\n", in_quotes(mission.name),
                        in_quotes(fs::absolute(mission.file).string()));
    if (!mission.settings.set.empty()) {
      text += "    set:\n" + settings_text(mission.settings, "      ");
    }
  }
  if (!study.drive->settings.set.empty()) {
    text += "set:\n" + settings_text(study.drive->settings, "  ");
  }
  text += "rigs:\n";
  for (std::size_t i = 0; i < rigs.size(); ++i) {
    const Calibratability known = calibratability(study.scores, rigs[i].rig, study.robot);
    write_file(out_dir / "rigs" / (rigs[i].name + ".yaml"),
               "# " + rigs[i].what + "\n" + write_settings(known.left));
    text +=
        fmt::format("  - name: {0}  # {1}\n    rig: rigs/{0}.yaml\n", rigs[i].name, rigs[i].what);
    progress(static_cast<double>(i + 1) / static_cast<double>(rigs.size()));
  }
  text += "rungs:\n";
  for (const StudyRung& rung : rungs_of(*study.drive)) {
    // What is off otherwise goes together otherwise.
    const bool has_own = std::any_of(
        rung.settings.set.begin(), rung.settings.set.end(),
        [](const std::string& setting) { return setting.starts_with("platform.mounting_error"); });
    text += fmt::format(
        "  - name: {}\n    set:\n      - {}\n", in_quotes(rung.name),
        has_own ? "rig.covariance=null" : "\"platform.mounting_error={as_known: true}\"");
    text += settings_text(rung.settings, "      ");
  }
  if (!study.drive->against_first.empty()) {
    text += "against_first:\n";
    for (const std::string& line : study.drive->against_first) {
      text += fmt::format("  - {}\n", in_quotes(line));
    }
  }
  if (!study.drive->scores.empty()) {
    text += "scores:\n";
    for (const StudyScore& score : study.drive->scores) {
      text += fmt::format("  - {{{}}}\n", score_text(score));
    }
  }
  if (study.drive->halving) {
    const StudyHalving& halving = *study.drive->halving;
    text += fmt::format("halving: {{seeds: {}, keep: {}, {}}}\n", halving.seeds, halving.keep,
                        score_text(halving.score));
  }
  write_file(out_dir / "drives.yaml", text);
}

void write_calibrations(const fs::path& out_dir, const PlacementStudy& study,
                        const RigSweep& sweep) {
  constexpr std::size_t kBest = 3;
  std::string text = fmt::format(
      "# The best rigs, mounted by hand, are truly recorded and calibrated. What geometry expects "
      "to "
      "be left is in rigs/*.yaml, as sigma.\n"
      "#   panoptes trials --study {} --seeds 1-3 --jobs 2 --out {}\n"
      "missions:\n"
      "  - {{name: calibrated, mission: data:missions/record-room.yaml, command: calibrate}}\n"
      "rigs:\n",
      (out_dir / "calibrations.yaml").string(), (out_dir / "calibrations").string());
  std::vector<std::size_t> rigs = promoted_rigs(sweep, static_cast<std::size_t>(study.drive->best));
  rigs.resize(std::min(kBest, rigs.size()));
  for (const std::size_t k : rigs) {
    text += fmt::format("  - {{name: rig-{0}, rig: rigs/rig-{0}.yaml}}\n", k + 1);
  }
  text +=
      "rungs:\n"
      "  - name: mounted to 1 degree and 5 mm\n"
      "    set:\n"
      "      - \"platform.mounting_error={sigma_deg: 1, sigma_m: 0.005}\"\n"
      "      - rig.covariance=null\n"
      "      - \"rig.cameras.*.sigma.rotation_rad=[0.0175, 0.0175, 0.0175]\"\n"
      "      - \"rig.cameras.*.sigma.position_m=[0.005, 0.005, 0.005]\"\n"
      "figure: cameras.*.T_body_camera.rotation_error_deg\n";
  write_file(out_dir / "calibrations.yaml", text);
}

}  // namespace panoptes
