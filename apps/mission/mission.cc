// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/mission.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "apps/mission/file_kind.h"
#include "apps/report/figure_names.h"
#include "apps/study/study.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/config/geometry_fields.h"
#include "hw/pioneer/line.h"

namespace panoptes {
namespace {

constexpr double kForEver_s = 1e8;
constexpr int kLeastSide_px = 48;  // of a picture by which places are recognised

// What is wrong with a line of `require:`; empty when nothing is.
std::string fault_of(const std::string& line, const Rig& rig) {
  std::vector<std::string> cameras;
  for (const auto& [name, camera] : rig.cameras) {
    cameras.push_back(name);
  }
  try {
    return requirement_fault(parse_requirement(line), cameras);
  } catch (const ConfigError& error) {
    return error.what();
  }
}

// Of those that the navigator needs.
std::vector<std::string> missing_roles(const Rig& rig) {
  std::vector<std::string> missing;
  if (std::none_of(rig.cameras.begin(), rig.cameras.end(),
                   [](const auto& camera) { return camera.second.is_loop(); })) {
    missing.emplace_back("loop_front");
  }
  if (rig.with_role("floor").empty()) {
    missing.emplace_back("floor");
  }
  return missing;
}

bool is_standin(const PioneerOptions& o) { return o.base.starts_with("standin:"); }

bool is_dataset(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::is_directory(folder / "mav0", error);
}

/// A rig that may have no cameras, told from one that could not be read.
struct SaidRig {
  Rig rig;
  bool said = false;
};
void bind(Fields& f, SaidRig& o) {
  bind(f, o.rig);
  o.said = o.said || f.present("cameras");
}

std::string folder_name(const std::string& folder) {
  return std::filesystem::canonical(folder).filename().string();
}

}  // namespace

void bind(Fields& f, StopOptions& o) {
  f("duration_s", o.duration_s, between(1e-3, kForEver_s));
  f("keyframes", o.keyframes, at_least(1));
  f("camera_lost_s", o.camera_lost_s, not_negative);
}

void bind(Fields& f, PioneerOptions& o) {
  constexpr const char* kForms = "must be serial:PORT, tcp:HOST:PORT, standin:pty or standin:tcp";
  const bool given = f.writing() || f.present("base");
  f.require(given, "base", std::string("missing; it ") + kForms);
  f("base", o.base);
  const bool stands_in = is_standin(o);
  const bool known_standin = o.base == kStandInPty || o.base == kStandInTcp;
  const bool address = o.base.starts_with("serial:") || o.base.starts_with("tcp:");
  f.require(!given || known_standin || address, "base", kForms);
  if (address) {
    const std::string fault = hw::LineAddress::fault(o.base);
    f.require(fault.empty(), "base", fault);
  }
  f.word(
      "cameras", o.cameras,
      {{"none", PioneerOptions::Cameras::kNone}, {"standin", PioneerOptions::Cameras::kStandIn}});
  f.require(stands_in || o.cameras != PioneerOptions::Cameras::kStandIn, "cameras",
            "must be none with this base: a stand-in's pictures come with base: standin:pty or "
            "standin:tcp");
  if (f.writing() ? o.standin != nullptr : f.present("standin")) {
    ExploreMission served = o.standin == nullptr ? ExploreMission() : *o.standin;
    served.needs = CameraRequirement::kNothing;
    f.require(stands_in, "standin", "must not be given: this base is no stand-in");
    f.file_or_inline("standin", served);
    f.require(std::holds_alternative<sim::SimulatedOptions>(served.platform), "standin",
              "must be a mission whose platform is simulated");
    o.standin = std::make_shared<ExploreMission>(std::move(served));
  }
  if (stands_in) {
    f("controller", o.controller);
  }
  f.require(!stands_in || o.standin != nullptr, "standin",
            "missing; it must name the mission whose simulated robot stands in");
}

void bind(Fields& f, ExploreMission& o) {
  f("name", o.name);
  f.require(o.name.find('/') == std::string::npos, "name", "must not contain /");
  f.require(first_not_utf8(o.name) == std::string::npos, "name",
            "must be given, for the file's own name is not UTF-8");
  f.require(f.writing() || f.present("platform"), "platform", "missing; it must be given");
  f.choice("platform", o.platform);
  const auto* recorded = std::get_if<hw::RecordedOptions>(&o.platform);
  if (recorded != nullptr && !f.writing()) {
    o.rig = recorded->believed.rig.value_or(o.rig);
    o.robot = recorded->believed.robot.value_or(o.robot);
    o.seed = recorded->believed.info ? recorded->believed.info->seed : o.seed;
    o.until.duration_s = kForEver_s;
  }
  const auto* pioneer = std::get_if<PioneerOptions>(&o.platform);
  if (pioneer != nullptr && pioneer->standin != nullptr && !f.writing()) {
    o.rig = pioneer->standin->rig;
    o.robot = pioneer->standin->robot;
  }
  const bool without_cameras =
      pioneer != nullptr && pioneer->cameras == PioneerOptions::Cameras::kNone;
  f.require(f.writing() || f.present("rig") || !o.rig.cameras.empty() || without_cameras, "rig",
            recorded == nullptr ? "missing; it must be given"
                                : "missing; the dataset has no rig.yaml to take it from");
  SaidRig rig{o.rig, !o.rig.cameras.empty()};
  f.file_or_inline("rig", rig);
  o.rig = rig.rig;
  f.file_or_inline("robot", o.robot);
  if (auto* simulated = std::get_if<sim::SimulatedOptions>(&o.platform)) {
    // What `--set` says of the rig is believed: the robot is built by what the mission says.
    if (Rig nominal; !simulated->nominal_rig && f.file_or_inline_before_set("rig", nominal)) {
      simulated->nominal_rig = std::move(nominal);
    }
    for (const sim::KeyFault& fault : sim::rig_faults(*simulated, o.rig, o.robot)) {
      f.require(false, fault.key, fault.what);
    }
  }
  f("seed", o.seed);
  if (auto* simulated = std::get_if<sim::SimulatedOptions>(&o.platform)) {
    sim::draw_place(simulated->world, o.seed);
  }
  f("until", o.until);
  f.choice("drive", o.drive);
  const DriveNeeds drive_needs = needs_of(o.drive);
  f.require(pioneer == nullptr || !drive_needs.truth, "drive",
            "must not be " + std::string(name_of(o.drive)) +
                " on a pioneer: it drives by the true pose, which only a simulated platform "
                "knows; use " +
                drives_on_any_robot(!without_cameras));
  const std::vector<std::string> missing = missing_roles(o.rig);
  const bool maps = o.needs == CameraRequirement::kNavigator ||
                    (o.needs == CameraRequirement::kDriver && drive_needs.slam);
  f.require(!without_cameras || !maps, "platform",
            "has cameras: none, and SLAM needs pictures; drive it with drive: " +
                drives_on_any_robot(false));
  f.require(!maps || !rig.said || missing.empty(), "rig",
            "has no camera with the role " + joined(missing, " or ") + "; SLAM in '" + o.name +
                "' needs a camera for loops, whose role begins with loop_, and one for the floor");
  if (o.needs != CameraRequirement::kNothing) {
    for (const auto& [name, camera] : o.rig.cameras) {
      f.require(!camera.is_loop() || std::min(camera.intrinsics.width_px,
                                              camera.intrinsics.height_px) >= kLeastSide_px,
                "rig.cameras." + name + ".size_px",
                "must be at least " + std::to_string(kLeastSide_px) +
                    " either way, for the descriptors of features leave nothing of a smaller "
                    "picture to recognise a place by");
    }
  }
  f("require", o.require);
  for (const std::string& line : o.require) {
    const std::string fault = fault_of(line, o.rig);
    f.require(fault.empty(), "require", fault);
  }
  f("navigator", o.navigator);
  f("places", o.places);
  if (o.places && rig.said) {
    f.require(missing.empty(), "places",
              "must not be given with a rig that the navigator cannot use, for there are no "
              "keyframes then");
    const std::string fault = pictures_fault(*o.places, o.rig, recorded != nullptr);
    f.require(fault.empty(), "places.pictures", fault);
  }
  f("frame_deadline_s", o.frame_deadline_s, between(0.01, 60));
  f("command_valid_for_s", o.command_valid_for_s, between(0.01, 10));
}

template <>
ExploreMission load_mission(const std::string& file, const std::vector<std::string>& overrides,
                            CameraRequirement needs) {
  ExploreMission defaults;
  defaults.needs = needs;
  if (is_dataset(file)) {
    read_beliefs(file);  // tells what cannot be replayed
    if (first_not_utf8(file) != std::string::npos) {
      throw ConfigError(file + ": the name of a dataset must be UTF-8; rename it");
    }
    std::vector<std::string> replayed{"platform={kind: recorded, dataset: " + in_quotes(file) +
                                      "}"};
    replayed.insert(replayed.end(), overrides.begin(), overrides.end());
    const std::string mission = (std::filesystem::path(file) / "mission.yaml").string();
    if (std::filesystem::exists(mission)) {
      return read_settings(mission, replayed, defaults);
    }
    defaults.name = folder_name(file);
    return read_settings_text("{}", mission, replayed, defaults);  // somebody else's
  }
  refuse_other_than_mission(file);
  defaults.name = std::filesystem::path(file).stem().string();
  return read_settings(file, overrides, defaults);
}

CameraRequirement needs_of(const std::string& command) {
  return calibrates(command) ? CameraRequirement::kDriver : CameraRequirement::kNavigator;
}

bool can_navigate(const Rig& rig) { return missing_roles(rig).empty(); }

std::vector<Requirement> requirements(const ExploreMission& mission) {
  std::vector<Requirement> out;
  for (const std::string& line : mission.require) {
    out.push_back(parse_requirement(line));
  }
  return out;
}

std::string default_out_dir(const ExploreMission& mission) {
  return "runs/" + mission.name + "-" + std::to_string(mission.seed);
}

}  // namespace panoptes
