// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/time.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// One camera's picture: 8-bit BGR, never written again after delivery.
struct Picture {
  Time stamp;
  cv::Mat bgr;
};

/// What the wheels say, dead reckoned in `odom` (the body at the first observation).
struct Odometry {
  Pose2 T_odom_body;
  Twist2 twist_body;
  bool extrapolated = false;  ///< nobody has reported of this instant yet
};

struct Health {
  bool bumper_pressed = false;
  bool motors_enabled = true;
  std::string held_by;  ///< what keeps the robot from moving until somebody acknowledges it
  /// Where it is pressed, in the body, 0 ahead; none where the platform does not tell.
  std::vector<double> bumper_bearings_rad = {};
};

/// What the robot perceived at one instant: the pictures of one frame set (none at a deadline; one
/// may be missing by name), the odometry at that instant, and the state of the platform.
struct Observation {
  Time stamp;
  std::map<std::string, Picture> pictures;  ///< by the camera's name in the rig
  Odometry odometry;
  Health health;
};

/// Where the body was when a picture of the set was taken, seen from where it is at the set's
/// stamp, by the velocity that the wheels tell.
inline Pose2 T_body_then(const Observation& seen, Time stamp) {
  return exp_twist(seen.odometry.twist_body, to_seconds(stamp - seen.stamp));
}

}  // namespace panoptes
