// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/mission/mission.h"
#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/camera/rig.h"
#include "hw/replay/recorded_robot.h"
#include "hw/replay/recording_robot.h"
#include "hw/robot.h"

namespace panoptes {

/// A robot ready to be observed, and the rig it believes in with its floor marks surveyed.
struct OpenRobot {
  std::unique_ptr<hw::Robot> robot;
  Rig rig;
  std::function<void()> finish;       ///< waits until all that it writes is written; may be empty
  std::function<bool()> route_done;   ///< who drives in the navigator's place is done
  hw::TruePictures true_pictures;     ///< empty where nobody knows them
  Capture capture;                    ///< empty where no camera can be asked
  Duration length = Duration::max();  ///< of a recording
  bool real_time = true;  ///< its time goes by as fast as the wall's, not as fast as it is observed
  std::vector<std::string> warnings;            ///< what the user ought to know before it runs
  const hw::RecordedRobot* recorded = nullptr;  ///< the robot, or what is inside of it
};

/// The robot of a mission's platform. Throws ConfigError for a start, a rig or a dataset that it
/// cannot have, IoError for missing meshes and textures, DeviceError where nothing can draw, and
/// what the renderer's options throw.
OpenRobot open_robot(const ExploreMission& mission, const Rng& rng,
                     const sim::RendererOptions& renderer = {});

/// The same robot of a simulated platform, without cameras: nothing is drawn.
std::unique_ptr<hw::Robot> open_robot_without_cameras(const ExploreMission& mission,
                                                      const Rng& rng);

/// Whether the platform can be opened, without making its pictures.
void check_platform(const ExploreMission& mission);

}  // namespace panoptes
