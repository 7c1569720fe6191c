// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "apps/command.h"
#include "apps/run/keyframes.h"
#include "apps/run/loop.h"
#include "apps/run/mission.h"
#include "apps/run/open_robot.h"
#include "apps/run/progress.h"
#include "apps/run/recorder.h"
#include "apps/run/stage_clock.h"
#include "apps/run/until.h"
#include "core/base/error.h"

namespace panoptes {
namespace {

struct ExploreArguments {
  std::string mission;
  CommonArguments common;
};

// Explores an unknown world until nothing is left to explore, and reports how well it went.
int explore(const ExploreArguments& args) {
  const auto mission = load_mission<ExploreMission>(args.mission, args.common.overrides());
  const std::string out_dir =
      args.common.out_dir.empty() ? default_out_dir(mission) : args.common.out_dir;
  claim_out_dir(out_dir);
  Until until(mission.until);
  Rng rng(mission.seed);
  auto [robot, rig, route_done] = open_robot(mission, rng.fork("robot"));
  StageClock clock;
  Navigator navigator(mission.navigator, mission.robot, rig, rng.fork("navigator"),
                      listener(clock));
  Recorder recorder(out_dir, run_info("explore", mission), &clock);
  Progress progress(from_seconds(mission.until.duration_s), args.common.quiet);

  try {
    while (!finished(mission.drive, navigator, route_done) &&
           !until.reached(robot->now(), navigator.keyframes().size())) {
      const Observation seen = observe(*robot, mission, clock);
      const NavStep step = navigate(navigator, seen, mission.drive, clock);
      refuse_bad_start(mission, navigator);
      robot->drive(step.command_body, from_seconds(mission.command_valid_for_s));
      recorder.add(seen, step);
      if (recorder.snapshot_due(seen.stamp)) {
        recorder.add_snapshot(seen.stamp, navigator.planning_map());
      }
      progress.show(seen.stamp, doing(navigator, step));
      clock.end_frame();
    }
    robot->stop();
  } catch (const DeviceError& error) {  // what was done until then is kept
    until.lose_device(error);
  }
  const RunReport report = recorder.write_report(
      robot->truth(), run_result(navigator), run_end(until, robot->now(), navigator, mission.robot),
      kept_keyframes(navigator));
  print(report);
  return report.exit_status;
}

}  // namespace

void add_explore(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<ExploreArguments>();
  CLI::App* sub =
      app.add_subcommand("explore", "Map a world that nobody has described to the robot");
  sub->add_option("MISSION", args->mission, "the mission file")->required()->type_name("FILE");
  add_common(*sub, args->common);
  sub->footer(
      "Example: panoptes explore scenes/missions/explore-office.yaml --seed 1 --out runs/office");
  sub->callback([args, &chosen] { chosen = [args] { return explore(*args); }; });
}

}  // namespace panoptes
