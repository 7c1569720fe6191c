// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera/rig.h"
#include "core/eval/calibratability.h"
#include "core/eval/rig_scores.h"
#include "core/eval/rig_sensitivity.h"
#include "core/geometry/body.h"

namespace panoptes {

/// A rig on a robot, and what it can do for it.
struct PlacedRig {
  std::string file;
  std::string name;  ///< of the file, without folder and ending; made different from the others'
  Rig rig;
  RigScores scores;
  std::optional<Calibratability> calibratability;  ///< empty where it was not asked for
  std::optional<RigSensitivity> sensitivity;       ///< likewise
};

/// What a programmed motion in the room of these scores would leave of the rig's mountings.
Calibratability calibratability(const RigScoreOptions& scores, const Rig& rig, const Body& robot);

/// As scores of a table; without values where there is none.
std::vector<NamedScore> named_scores(const std::optional<Calibratability>& left);

/// What `panoptes place` is told beside the rigs.
struct PlaceOptions {
  RigScoreOptions scores;
  Body robot;
};

/// Of `--set`: `scores.` and `robot.` are settings of these, `rig.` of every rig. Reads the robot's
/// file where one is named. Throws ConfigError with every fault.
PlaceOptions read_place_options(const std::string& robot_file,
                                const std::vector<std::string>& overrides);

/// Reads and checks the rigs: a file that is none, and a rig that cannot be on this robot are
/// refused with the reason, all at once. Nothing is scored yet.
std::vector<PlacedRig> read_rigs(const std::vector<std::string>& files, const Body& robot,
                                 const std::vector<std::string>& overrides);

}  // namespace panoptes
