// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes::hw {

/// What the numbers of one kind of robot mean. A controller announces its subclass; taking the
/// wrong one for it changes the scale of the odometry without a word.
struct PioneerModel {
  std::string_view subclass;
  double distance_m = 1e-3;             ///< a count of position
  double speed_mps = 1e-3;              ///< a count of wheel velocity
  double turn_rad_per_m = 5.6;          ///< (right - left) / 2 times this is the turn
  double angle_rad = 0.00153398078789;  ///< a count of heading, 2 pi / 4096
  double range_m = 1e-3;                ///< a count of a sonar's range
  double wheel_speed_mps = 0.02;        ///< a count of kWheelVelocities
};

/// Null for one that nobody has entered here.
const PioneerModel* find_model(std::string_view subclass);
std::vector<std::string> known_models();

}  // namespace panoptes::hw
