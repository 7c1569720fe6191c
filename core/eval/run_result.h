// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/graph/pose_graph.h"
#include "core/map/occupancy.h"
#include "core/motion/rig_estimate.h"

namespace panoptes {

/// A keyframe as the navigator left it at the end.
struct KeyframePose {
  Time stamp;
  Pose2 T_map_body;   ///< after the last relaxation
  Pose2 T_odom_body;  ///< as the wheels said
};

/// What a run's navigator knows at the end; what the figures are about.
struct RunResult {
  std::vector<KeyframePose> keyframes;  ///< in order of time
  PoseGraph graph;                      ///< node i is keyframe i
  OccupancyMap map;                     ///< all of it, 1 cm cells
  std::optional<RigEstimate> rig = {};  ///< empty where nobody learned of it
};

}  // namespace panoptes
