// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/plan/dwa.h"

namespace panoptes {

enum class PilotState { kDriving, kRecovering, kStopped };

/// A place that it was told to drive to, and what has become of that.
struct GoalProgress {
  enum class State { kWaiting, kPursued, kReached, kRefused };

  Vec2 goal_map = Vec2::Zero();
  State state = State::kWaiting;
  std::string why;            ///< it was refused
  std::optional<Time> began;  ///< to be pursued
  std::optional<Time> ended;  ///< reached or refused, and at rest
};

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
  std::vector<GoalProgress> goals;  ///< all that it was told to drive to, in turn
};

}  // namespace panoptes
