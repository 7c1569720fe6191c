// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>

#include "apps/run/mission.h"
#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "hw/robot.h"

namespace panoptes {

/// A robot ready to be observed, and the rig it believes in with its floor marks surveyed.
struct OpenRobot {
  std::unique_ptr<hw::Robot> robot;
  Rig rig;
  std::function<bool()> route_done;  ///< the way that the mission prescribes is driven
};

/// The robot of a mission's platform. Throws ConfigError for a start or a rig that it cannot have,
/// IoError for missing meshes and textures, DeviceError where nothing can draw.
OpenRobot open_robot(const ExploreMission& mission, const Rng& rng);

/// Whether the platform can be opened, without making its pictures.
void check_platform(const ExploreMission& mission);

}  // namespace panoptes
