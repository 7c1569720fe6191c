// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/recording.h"

#include <memory>
#include <string>
#include <utility>

#include "apps/run/mission_run.h"
#include "hw/replay/recording_robot.h"

namespace panoptes {

int record_mission(const ExploreMission& mission, const std::filesystem::path& out_dir,
                   bool quiet) {
  const auto keep_all = [&mission](OpenRobot& open, const std::filesystem::path& folder) {
    auto robot = std::make_unique<hw::RecordingRobot>(
        std::move(open.robot), folder,
        RecordingInfo{std::string(kDatasetSchema), PANOPTES_VERSION, mission.name, mission.seed},
        open.rig, mission.robot, open.true_pictures,
        open.recorded == nullptr || open.recorded->touches_known());
    open.finish = [recording = robot.get()] { recording->finish(); };
    open.robot = std::move(robot);
  };
  return run_mission(mission, {"record", out_dir, quiet, keep_all, false});
}

}  // namespace panoptes
