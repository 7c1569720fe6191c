// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "apps/mission/drive.h"
#include "apps/recognition/recognition_study.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/eval/requirement.h"
#include "core/geometry/body.h"
#include "core/nav/navigator.h"
#include "hw/replay/recorded_robot.h"
#include "hw/standin/controller.h"
#include "sim/simulated_robot.h"

namespace panoptes {

/// When a run ends, whatever it is doing.
struct StopOptions {
  double duration_s = 600;
  std::optional<int> keyframes;
  double camera_lost_s = 1;  ///< at its end, of a camera that is not good, makes it device_lost:
                             ///< the time within which a robot that steers by it stands; a few
                             ///< pictures lost just before are no lost camera
};
void bind(Fields& f, StopOptions& o);

struct ExploreMission;

constexpr std::string_view kStandInPty = "standin:pty";
constexpr std::string_view kStandInTcp = "standin:tcp";

/// A Pioneer with cameras, at the end of real wires. A stand-in is a simulated robot served in this
/// process: its motion goes over the wire, its pictures come by memory, and time is the simulated
/// robot's own.
struct PioneerOptions {
  static constexpr std::string_view kName = "pioneer";
  enum class Cameras { kNone, kStandIn };

  std::string base;  ///< serial:/dev/ttyUSB0, tcp:host:8101, standin:pty or standin:tcp
  Cameras cameras = Cameras::kNone;
  std::shared_ptr<ExploreMission> standin;  ///< whose simulated platform is served
  hw::StandInOptions controller;            ///< of the stand-in
};
void bind(Fields& f, PioneerOptions& o);

using PlatformOptions = std::variant<sim::SimulatedOptions, hw::RecordedOptions, PioneerOptions>;

/// For whom a rig must have what the navigator needs: a camera that looks ahead, one that looks
/// back and one that sees the floor.
enum class CameraRequirement {
  kNavigator,  ///< the command always maps
  kDriver,     ///< it maps where it can, and must where the navigator drives
  kNothing     ///< it only looks
};

/// Of a command of a study.
CameraRequirement needs_of(const std::string& command);

/// A mission of `panoptes explore`. On a recorded platform rig, robot and seed are the recording's
/// where the mission says nothing of them, and it lasts as long as there is something to replay; on
/// a stand-in rig and robot are the stand-in's likewise.
struct ExploreMission {
  std::string name;  ///< the mission file's name without folder and ending, where it is not given
  Rig rig;           ///< as written, before the survey
  Body robot;
  PlatformOptions platform;
  std::uint64_t seed = 1;
  StopOptions until;
  DriveOptions drive;
  std::vector<std::string> require;
  NavigatorOptions navigator;
  std::optional<RecognitionStudyOptions>
      places;                        ///< compared on the pictures of the drive's keyframes
  double frame_deadline_s = 1;       ///< longest wait for a frame set
  double command_valid_for_s = 0.4;  ///< the robot stops by itself when commands stop coming

  CameraRequirement needs = CameraRequirement::kDriver;  ///< of the command, not of the file
};
void bind(Fields& f, ExploreMission& o);

/// Reads a mission with everything it refers to, checks it wholly and throws ConfigError with every
/// fault. `overrides` are `key.path=value`. The folder of a dataset is the mission it was recorded
/// with, on the recording; of one without mission.yaml a mission with every setting's default.
template <class Mission>
Mission load_mission(const std::string& file, const std::vector<std::string>& overrides = {},
                     CameraRequirement needs = CameraRequirement::kDriver);
template <>
ExploreMission load_mission(const std::string& file, const std::vector<std::string>& overrides,
                            CameraRequirement needs);

/// The rig has every camera that the navigator needs.
bool can_navigate(const Rig& rig);

/// The mission's `require:` lines, which its bind has checked.
std::vector<Requirement> requirements(const ExploreMission& mission);

/// `runs/<mission>-<seed>`
std::string default_out_dir(const ExploreMission& mission);

}  // namespace panoptes
