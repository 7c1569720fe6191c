// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/calib/turning.h"
#include "core/calib/wheel_readings.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A motion that does not tell how a camera is mounted; in words, with what to do.
class HandEyeError : public ConfigError {
 public:
  using ConfigError::ConfigError;
};

/// The camera's path and the wheels' are not those of one body.
class PathsDisagree : public HandEyeError {
 public:
  using HandEyeError::HandEyeError;
};

/// How a camera is mounted, by its own path beside the odometry's.
struct PlanarHandEye {
  Pose3 T_body_camera;        ///< its height as it was believed: no motion over a floor shows it
  double clock_offset_s = 0;  ///< as in RigCamera
  double map_metre_m = 1;     ///< true metres in one of the map's
  Pose3 T_start_map;          ///< of points in metres: T_start_map * (map_metre_m * p_map);
                              ///< start is the body at the first camera's instant
  double yaw_sigma_rad = 0;
  double position_sigma_m = 0;  ///< along x and y, the larger
};

/// Mounting, clock, metre and place of a camera on a robot that drives over a floor, as far as the
/// two paths tell (planar hand-eye calibration: Guo, Mirzaei and Roumeliotis 2012; Heng, Li and
/// Pollefeys 2013): roll and pitch by the axis that all turns are about, the clock by when it
/// turns, yaw, place and metre by what the body moves between the camera's instants. Nothing is
/// assumed of the mounting but its height, unless the motion leaves yaw, place and metre open (a
/// turn on the spot, a circle): then they are nearest to what is believed, and their sigmas large.
/// Throws HandEyeError for a motion without turns, and PathsDisagree for paths that do not fit one
/// another.
PlanarHandEye planar_hand_eye(const std::vector<StampedCamera>& path, const WheelReadings& wheels,
                              const RigCamera& believed);

}  // namespace panoptes
