// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/wheel_readings.h"

namespace panoptes {

bool tells_metre(const std::vector<std::optional<Pose2>>& T_odom_body) {
  constexpr double kLeastAway_m = 0.2;
  std::optional<Vec2> first;
  for (const std::optional<Pose2>& T : T_odom_body) {
    if (T) {
      first = first ? first : T->position();
      if ((T->position() - *first).norm() > kLeastAway_m) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace panoptes
