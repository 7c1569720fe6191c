// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "apps/mission/mission.h"
#include "apps/mission/open_robot.h"
#include "apps/pilots/pilot.h"
#include "apps/report/recorder.h"
#include "apps/step/step_listener.h"
#include "core/nav/slam.h"

namespace panoptes {

/// A run that is about to begin. All that it leads to outlives its listeners.
struct ListenedRun {
  const ExploreMission& mission;
  const OpenRobot& open;
  const Pilot& pilot;
  Slam* slam;  ///< null where nothing is mapped
  Recorder& recorder;
  bool quiet;
};

/// Who listens to it beside the recorder and the study of recognition, in the order of
/// apps/listeners/CMakeLists.txt. A listener NAME is a file with
/// `std::unique_ptr<StepListener> make_NAME(const ListenedRun& run)`, which gives null where there
/// is nothing to listen for, and a line there.
std::vector<std::unique_ptr<StepListener>> make_listeners(const ListenedRun& run);

}  // namespace panoptes
