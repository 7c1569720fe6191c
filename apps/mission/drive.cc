// SPDX-License-Identifier: BSD-3-Clause
#include "apps/mission/drive.h"

#include <vector>

#include "core/base/text.h"

namespace panoptes {

void bind(Fields& f, DriveGoalPoint& o) {
  const Rule near = between(-kFarthestGoal_m, kFarthestGoal_m);
  f.needed("x_m", o.x_m, near);
  f.needed("y_m", o.y_m, near);
}

template <>
void bind(Fields& f, Drive<"goals">& o) {
  f("points", o.points);
  f.require(!o.points.empty(), "points", "must hold at least one place to drive to");
}

template <>
void bind(Fields& f, Drive<"route">& o) {
  f.require(f.writing() || f.present("file"), "file", "missing; it must name a file of waypoints");
  f.file_or_inline("file", o.route);
}

template <>
void bind(Fields& f, Drive<"program">& o) {
  f.require(f.writing() || f.present("program"), "program",
            "missing; it must be one of legs_and_turns, sawtooth, rose, circle");
  f.choice("program", o.motion);
}

std::string room_told(const Drive<"program">& drive, const Body& body) {
  return "clear floor for " +
         told(floor_needed(poses_of(drive.motion), body.radius_m + kProgramMargin_m));
}

std::string_view name_of(const DriveOptions& drive) {
  return std::visit([](const auto& chosen) { return chosen.kName; }, drive);
}

DriveNeeds needs_of(const DriveOptions& drive) {
  return std::visit([](const auto& chosen) { return chosen.kNeeds; }, drive);
}

std::string drives_on_any_robot(bool with_cameras) {
  std::vector<std::string> words;
  const auto add = [&](const char* word, const DriveNeeds& needs) {
    if (!needs.truth && (with_cameras || !needs.slam)) {
      words.emplace_back(word);
    }
  };
#define PANOPTES_PILOT(name, ...) add(#name, kDriveNeeds<#name>);
#include "apps/mission/pilots.inc"
#undef PANOPTES_PILOT
  return joined(words, " or ");
}

}  // namespace panoptes
