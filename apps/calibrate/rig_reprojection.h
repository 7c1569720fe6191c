// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/calib/rig_bundle.h"
#include "core/calib/wheel_readings.h"

namespace panoptes {

/// Where a rig's state draws a point in the view that shows it: the body is where it was at the
/// view's instant, moved on by the wheels to when the picture was taken. Empty where the point is
/// not in front of the camera, or the wheels do not reach.
std::optional<Vec2> drawn_px(const RigTracks& tracks, const RigBundleState& state,
                             const WheelReadings& wheels, const RigSeen& seen);

/// How far points of a camera's views are drawn from where they were seen: sqrt(mean(dx^2 + dy^2))
/// of what is believed.
struct ReprojectionRms {
  double own_px = 0;
  double other_px = 0;  ///< of points of other cameras' maps; 0 where there are none
  int own = 0;
  int other = 0;
};
ReprojectionRms reprojection_rms(const RigTracks& tracks, const RigBundleState& state,
                                 const WheelReadings& wheels, std::size_t camera);

}  // namespace panoptes
