// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/command/out_file.h"
#include "apps/mission/mission.h"
#include "apps/run/mission_run.h"
#include "apps/run/refined.h"
#include "core/config/inputs.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

struct ExploreArguments {
  std::string mission;
  std::string inputs;
  std::optional<std::string> refined;
  CommonArguments common;
};

bool is_inside(const std::filesystem::path& file, const std::filesystem::path& folder) {
  const std::filesystem::path from_there =
      std::filesystem::absolute(file).lexically_normal().lexically_relative(
          std::filesystem::absolute(folder).lexically_normal());
  return !from_there.empty() && *from_there.begin() != "..";
}

// Explores an unknown world until nothing is left to explore, and reports how well it went.
int explore(const ExploreArguments& args) {
  if (!args.inputs.empty()) {
    keep_inputs();
    note_input("/proc/self/exe");
  }
  constexpr CameraRequirement kNeeds = CameraRequirement::kNavigator;
  const auto mission = load_mission<ExploreMission>(
      args.mission, with_refined(args.refined, args.mission, args.common.overrides(), kNeeds),
      kNeeds);
  const std::filesystem::path out_dir = args.common.out_dir.value_or(default_out_dir(mission));
  if (!args.inputs.empty() && !is_inside(args.inputs, out_dir)) {  // which is not made yet
    check_out_file("--inputs", args.inputs);
  }
  const int status = run_mission(mission, {"explore", out_dir, args.common.quiet, {}});
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
  add_refined(*sub, args->refined);
  add_common(*sub, args->common);
  sub->footer(
      "Example: panoptes explore scenes/missions/explore-office.yaml --seed 1 --out runs/office\n"
      "and then, with what it has learned of its cameras: panoptes explore "
      "scenes/missions/explore-office.yaml --seed 2 --refined runs/office --out runs/again");
  sub->callback([args, &chosen] { chosen = [args] { return explore(*args); }; });
}

}  // namespace panoptes
