// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/calib/turning.h"
#include "core/calib/wheel_readings.h"
#include "core/camera/rig.h"

namespace panoptes {

/// How the body moves by a camera's own path over a floor, where no wheels have been read: as if
/// the camera were mounted as it is believed to be and a metre of its map were `map_metre_m` long.
/// `odom` is the body at the first pose, by a clock that the camera's is off by as it is believed
/// to be. Empty before the path, after it, and where the camera lost its way. Up to lengths and to
/// where the body is beside the camera, which no path shows, it is as true as the path is.
WheelReadings path_as_wheels(const std::vector<StampedCamera>& path, const RigCamera& believed,
                             double map_metre_m);

}  // namespace panoptes
