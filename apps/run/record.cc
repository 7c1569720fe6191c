// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <optional>
#include <utility>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/mission/mission.h"
#include "apps/run/mission_run.h"
#include "apps/run/refined.h"
#include "hw/replay/recording_robot.h"

namespace panoptes {
namespace {

struct RecordArguments {
  std::string mission;
  bool depth = false;
  bool labels = false;
  std::optional<std::string> refined;
  CommonArguments common;
};

// Drives a mission and keeps all that the robot perceived and was told in a dataset. What the
// mission requires of a whole run, a recording of any part of it need not meet.
int record(const RecordArguments& args) {
  std::vector<std::string> overrides = args.common.overrides();
  if (args.depth) {
    overrides.emplace_back("platform.truth.depth=true");
  }
  if (args.labels) {
    overrides.emplace_back("platform.truth.labels=true");
  }
  const auto mission = load_mission<ExploreMission>(
      args.mission, with_refined(args.refined, args.mission, overrides));
  const auto keep_all = [&mission](OpenRobot& open, const std::filesystem::path& folder) {
    auto robot = std::make_unique<hw::RecordingRobot>(
        std::move(open.robot), folder,
        RecordingInfo{std::string(kDatasetSchema), PANOPTES_VERSION, mission.name, mission.seed},
        open.rig, mission.robot, open.true_pictures,
        open.recorded == nullptr || open.recorded->touches_known());
    open.finish = [recording = robot.get()] { recording->finish(); };
    open.robot = std::move(robot);
  };
  return run_mission(mission, {"record", args.common.out_dir.value_or(default_out_dir(mission)),
                               args.common.quiet, keep_all, false});
}

}  // namespace

void add_record(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<RecordArguments>();
  CLI::App* sub = app.add_subcommand("record", "Keep what the robot sees, to be replayed");
  sub->add_option("MISSION", args->mission, "the mission file")->required()->type_name("FILE");
  sub->add_flag("--depth", args->depth, "the true depth of every picture as well");
  sub->add_flag("--labels", args->labels,
                "which thing (16 bit, its number in mav0/things.csv), and whether floor, every "
                "pixel truly shows");
  add_refined(*sub, args->refined);
  add_common(*sub, args->common);
  sub->footer(
      "Example: panoptes record scenes/missions/explore-office.yaml --duration 60 --out "
      "runs/recorded\n"
      "and then: panoptes explore runs/recorded --set navigator.driver.dwa.margin_s=0.2 --out "
      "runs/again");
  sub->callback([args, &chosen] { chosen = [args] { return record(*args); }; });
}

}  // namespace panoptes
