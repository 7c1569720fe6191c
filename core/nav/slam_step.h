// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/geometry/pose2.h"
#include "core/loops/closure.h"
#include "core/map/floor_mapper.h"
#include "core/map/occupancy.h"
#include "core/odometry/odometry_source.h"

namespace panoptes {

/// What one observation told of where the robot is and of what is around it.
struct SlamStep {
  Time stamp;
  Pose2 T_map_body;
  Pose2 T_odom_body;  ///< by wheels and the pictures' headings: does not jump when a loop closes
  int keyframe = 0;   ///< the last one
  std::optional<int> keyframe_made;     ///< its index
  std::vector<ClosureReport> closures;  ///< tried at this step
  bool relaxed = false;                 ///< all keyframes may have moved in map
  FloorReading floor;                   ///< of the foremost floor camera; empty without its picture
  OccupancyMap local_odom;              ///< the last keyframes and the open one, about the robot
  std::string cameras_told;          ///< what is wrong with them, in words; empty when nothing is
  std::optional<Odometry> odometry;  ///< as its source tells it: what jumped goes on from where it
                                     ///< was; empty of an observation that is passed over
  std::string passed_over;  ///< why nothing was learned from the observation; empty: it was
};

/// What the odometry tells of an observation: by its source where somebody maps, else as the
/// platform says it; empty where it tells nothing.
inline std::optional<Odometry> told_odometry(const Observation& seen, const SlamStep& at) {
  if (at.odometry || !at.passed_over.empty()) {
    return at.odometry;
  }
  return is_finite(seen.odometry) ? std::optional(seen.odometry) : std::nullopt;
}

}  // namespace panoptes
