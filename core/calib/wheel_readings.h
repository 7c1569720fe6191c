// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// What the wheels say at an instant of the odometry's clock. Empty where they do not reach.
using WheelReadings = std::function<std::optional<Odometry>(Time)>;

/// Whether a drive tells a metre: it has led away from where it began. What wheels wander in a turn
/// on the spot does not.
bool tells_metre(const std::vector<std::optional<Pose2>>& T_odom_body);

}  // namespace panoptes
