// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

#include "core/base/time.h"
#include "core/camera/observation.h"

namespace panoptes {

/// What the wheels say at an instant of the odometry's clock. Empty where they do not reach.
using WheelReadings = std::function<std::optional<Odometry>(Time)>;

}  // namespace panoptes
