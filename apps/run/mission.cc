// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/mission.h"

#include <filesystem>

#include "core/base/error.h"
#include "core/config/geometry_fields.h"

namespace panoptes {
namespace {

// What is wrong with a line of `require:`; empty when nothing is.
std::string fault_of(const std::string& line) {
  try {
    parse_requirement(line);
    return {};
  } catch (const ConfigError& error) {
    return error.what();
  }
}

}  // namespace

void bind(Fields& f, UntilOptions& o) {
  f("duration_s", o.duration_s, between(1e-3, 1e8));
  f("keyframes", o.keyframes, at_least(1));
}

void bind(Fields&, DriveByNavigator&) {}

void bind(Fields& f, DriveAlongRoute& o) {
  f.require(f.writing() || f.present("file"), "file", "missing; it must name a file of waypoints");
  f.file_or_inline("file", o.route, o.file);
}

void bind(Fields&, DriveNowhere&) {}

void bind(Fields& f, ExploreMission& o) {
  f("name", o.name);
  f.require(o.name.find('/') == std::string::npos, "name", "must not contain /");
  f.require(f.writing() || f.present("rig"), "rig", "missing; it must be given");
  f.file_or_inline("rig", o.rig);
  for (const char* role : {"loop_front", "loop_back", "floor"}) {
    f.require(o.rig.cameras.empty() || !o.rig.with_role(role).empty(), "rig",
              std::string("has no camera with the role ") + role +
                  "; the navigator needs loop_front, loop_back and floor");
  }
  f.file_or_inline("robot", o.robot);
  f.require(f.writing() || f.present("platform"), "platform", "missing; it must be given");
  f.choice("platform", o.platform);
  if (const auto* simulated = std::get_if<sim::SimulatedOptions>(&o.platform)) {
    const std::string fault = sim::rig_fault(*simulated, o.rig);
    f.require(fault.empty(), "platform", fault);
  }
  f("seed", o.seed);
  f("until", o.until);
  f.choice("drive", o.drive);
  f("require", o.require);
  for (const std::string& line : o.require) {
    const std::string fault = fault_of(line);
    f.require(fault.empty(), "require", fault);
  }
  f("navigator", o.navigator);
  f("frame_deadline_s", o.frame_deadline_s, between(0.01, 60));
  f("command_valid_for_s", o.command_valid_for_s, between(0.01, 10));
}

template <>
ExploreMission load_mission(const std::string& file, const std::vector<std::string>& overrides) {
  ExploreMission defaults;
  defaults.name = std::filesystem::path(file).stem().string();
  return read_settings(file, overrides, defaults);
}

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
