// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/mission/mission.h"
#include "apps/run/recording.h"
#include "apps/run/refined.h"

namespace panoptes {
namespace {

struct RecordArguments {
  std::string mission;
  bool depth = false;
  bool labels = false;
  std::optional<std::string> refined;
  CommonArguments common;
};

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
  return record_mission(mission, args.common.out_dir.value_or(default_out_dir(mission)),
                        args.common.quiet);
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
