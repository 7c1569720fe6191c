// SPDX-License-Identifier: BSD-3-Clause
#include "core/odometry/make_odometry.h"

namespace panoptes {

std::unique_ptr<OdometrySource> make_wheels_odometry(const OdometryParts& parts) {
  return std::make_unique<WheelOdometry>(parts.wheels, parts.body);
}

}  // namespace panoptes
