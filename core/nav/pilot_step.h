// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/plan/dwa.h"

namespace panoptes {

enum class PilotState { kDriving, kRecovering, kStopped };

/// What who drives decided at one observation, and why.
struct PilotStep {
  Twist2 command_body;
  PilotState state = PilotState::kStopped;
  std::string reason;        ///< why it drives, recovers or stands
  bool camera_lost = false;  ///< a camera that it steers by is lost: it stands, as fast as it can
  std::optional<Vec2> goal_map;
  std::optional<Vec2> lookahead_odom;
  std::vector<WindowScore> window;  ///< empty when nothing was planned, or is not kept
  double mapped_free_m2 = 0;        ///< of the map that was planned on last
  bool frontier_reachable = false;  ///< something is left to explore
};

}  // namespace panoptes
