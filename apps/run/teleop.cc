// SPDX-License-Identifier: BSD-3-Clause
#include "apps/teleop/teleop.h"

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/mission/mission.h"
#include "apps/run/mission_run.h"
#include "apps/run/refined.h"
#include "core/base/error.h"

namespace panoptes {
namespace {

struct TeleopArguments {
  std::string mission;
  std::optional<std::string> refined;
  CommonArguments common;
};

// Drives a mission's robot by hand; the navigator maps along where the rig lets it. What the
// mission requires of its own driver, a person's drive need not meet.
int teleop(const TeleopArguments& args) {
  std::vector<std::string> overrides = args.common.overrides();
  overrides.emplace_back("drive=teleop");
  const auto mission = load_mission<ExploreMission>(
      args.mission, with_refined(args.refined, args.mission, overrides));
  if (std::holds_alternative<hw::RecordedOptions>(mission.platform)) {
    throw ConfigError(args.mission +
                      ": platform: a recording cannot be driven; give a mission with another "
                      "platform, or map it again with panoptes explore");
  }
  return run_mission(mission, {"teleop",
                               args.common.out_dir.value_or(default_out_dir(mission)),
                               args.common.quiet,
                               {},
                               false});
}

}  // namespace

void add_teleop(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<TeleopArguments>();
  CLI::App* sub = app.add_subcommand("teleop", "Drive by keyboard or gamepad, mapping along");
  sub->add_option("MISSION", args->mission, "the mission file")->required()->type_name("FILE");
  add_refined(*sub, args->refined);
  add_common(*sub, args->common);
  sub->footer(std::string(kTeleopHelp) +
              "\nExample: panoptes teleop scenes/missions/explore-office.yaml --out runs/by-hand");
  sub->callback([args, &chosen] { chosen = [args] { return teleop(*args); }; });
}

}  // namespace panoptes
