// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/mission/mission.h"
#include "apps/run/mission_run.h"
#include "core/config/inputs.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

struct ExploreArguments {
  std::string mission;
  std::string inputs;
  CommonArguments common;
};

// Explores an unknown world until nothing is left to explore, and reports how well it went.
int explore(const ExploreArguments& args) {
  if (!args.inputs.empty()) {
    keep_inputs();
    note_input("/proc/self/exe");
  }
  const auto mission = load_mission<ExploreMission>(args.mission, args.common.overrides(),
                                                    CameraRequirement::kNavigator);
  const int status = run_mission(
      mission,
      {"explore", args.common.out_dir.value_or(default_out_dir(mission)), args.common.quiet, {}});
  if (!args.inputs.empty()) {
    write_file(args.inputs, inputs_text(inputs()));
  }
  return status;
}

}  // namespace

void add_explore(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<ExploreArguments>();
  CLI::App* sub =
      app.add_subcommand("explore", "Map a world that nobody has described to the robot");
  sub->add_option("MISSION", args->mission, "the mission file, or a dataset to be mapped again")
      ->required()
      ->type_name("FILE");
  sub->add_option("--inputs", args->inputs,
                  "keep what the run was made of: every file that was read, and the program, with "
                  "its SHA-256, as sha256sum -c reads it")
      ->type_name("FILE");
  add_common(*sub, args->common);
  sub->footer(
      "Example: panoptes explore scenes/missions/explore-office.yaml --seed 1 --out runs/office");
  sub->callback([args, &chosen] { chosen = [args] { return explore(*args); }; });
}

}  // namespace panoptes
