// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/config/fields.h"
#include "core/config/word.h"
#include "core/geometry/body.h"
#include "core/plan/motion_program.h"
#include "sim/route.h"

namespace panoptes {

/// What a pilot cannot drive without.
enum class DriveNeed {
  kSlam,     ///< where the robot is and what is mapped: a rig with what SLAM needs
  kTruth,    ///< the true pose: a simulated platform, or the recording of one
  kTerminal  ///< a person at a terminal or a gamepad, but for a recording
};
struct DriveNeeds {
  bool slam = false;
  bool truth = false;
  bool terminal = false;
};
constexpr DriveNeeds all_of(std::same_as<DriveNeed> auto... needs) {
  return {((needs == DriveNeed::kSlam) || ...), ((needs == DriveNeed::kTruth) || ...),
          ((needs == DriveNeed::kTerminal) || ...)};
}

/// By the pilots that apps/CMakeLists.txt lists, a line each with what it needs.
template <Word Name>
constexpr DriveNeeds kDriveNeeds;
#define PANOPTES_PILOT(name, ...)                       \
  template <>                                           \
  inline constexpr DriveNeeds kDriveNeeds<#name> = [] { \
    using enum DriveNeed;                               \
    return all_of(__VA_ARGS__);                         \
  }();
#include "apps/mission/pilots.inc"
#undef PANOPTES_PILOT

template <Word Name>
struct DriveTraits {
  static constexpr std::string_view kName = Name.text;
  static constexpr DriveNeeds kNeeds = kDriveNeeds<Name>;
};

/// Who drives: `drive: NAME` of a mission, with the settings of that word. Slam maps in any case.
template <Word Name>
struct Drive : DriveTraits<Name> {};
template <Word Name>
void bind(Fields& /*f*/, Drive<Name>& /*o*/) {}

constexpr double kFarthestGoal_m = 1e4;

/// A place to drive to, in `map`, whose origin is where the robot starts, x ahead.
struct DriveGoalPoint {
  double x_m = 0;
  double y_m = 0;
};
void bind(Fields& f, DriveGoalPoint& o);

template <>
struct Drive<"goals"> : DriveTraits<"goals"> {
  static constexpr std::string_view kShort = "points";
  std::vector<DriveGoalPoint> points;  ///< in turn
};
template <>
void bind(Fields& f, Drive<"goals">& o);

template <>
struct Drive<"route"> : DriveTraits<"route"> {
  static constexpr std::string_view kShort = "file";
  sim::Route route;  ///< written inline: a replay needs no file but the dataset's
};
template <>
void bind(Fields& f, Drive<"route">& o);

template <>
struct Drive<"program"> : DriveTraits<"program"> {
  static constexpr std::string_view kShort = "program";
  MotionProgramOptions motion;
};
template <>
void bind(Fields& f, Drive<"program">& o);

/// Kept clear about the outline of a body that a program drives.
constexpr double kProgramMargin_m = 0.1;

/// "clear floor for 0.85 m ahead of where the robot starts, ..."
std::string room_told(const Drive<"program">& drive, const Body& body);

template <class /*before the first comma*/, class... Drives>
using DriveVariant = std::variant<Drives...>;

/// By hand (`teleop`) is at a keyboard or a gamepad, and on a recorded platform as it was driven
/// then.
#define PANOPTES_PILOT(name, ...) , Drive<#name>
using DriveOptions = DriveVariant<void
#include "apps/mission/pilots.inc"
                                  >;
#undef PANOPTES_PILOT

std::string_view name_of(const DriveOptions& drive);
DriveNeeds needs_of(const DriveOptions& drive);

/// The words of those who drive a robot whose true pose nobody knows: "navigator or teleop or
/// none".
std::string drives_on_any_robot(bool with_cameras);

}  // namespace panoptes
