// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "core/graph/closure.h"
#include "core/plan/dwa.h"

namespace panoptes {

enum class NavState { kDriving, kRecovering, kStopped };

/// Everything the navigator decided at one observation, and why.
struct NavStep {
  Time stamp;
  Pose2 T_map_body;
  Pose2 T_odom_body;
  Twist2 command_body;
  NavState state = NavState::kStopped;
  std::string reason;        ///< why it drives, recovers or stands
  std::string cameras_told;  ///< what is wrong with them, in words; empty when nothing is
  bool blind = false;        ///< a camera that it steers by is lost: it stands, as fast as it can
  std::optional<Vec2> goal_map;
  std::optional<Vec2> carrot_odom;
  std::vector<WindowScore> window;      ///< empty when nothing was planned
  std::optional<int> keyframe_made;     ///< its index
  std::vector<ClosureReport> closures;  ///< tried at this step
  bool relaxed = false;
  cv::Mat floor_log_ratio;          ///< CV_32F, the floor camera's picture; empty without one
  double mapped_free_m2 = 0;        ///< of the global map, kept up to date now and then
  bool frontier_reachable = false;  ///< something is left to explore
};

}  // namespace panoptes
