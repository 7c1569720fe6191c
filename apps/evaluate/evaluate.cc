// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/command/folder_lock.h"
#include "apps/evaluate/given_truth.h"
#include "apps/evaluate/saved_run.h"
#include "apps/mission/mission.h"
#include "apps/run/loop.h"
#include "core/base/error.h"
#include "sim/world/load.h"
#include "sim/world/truth_layers.h"

namespace panoptes {
namespace {

struct EvaluateArguments {
  std::string run;
  std::string truth;
  std::string world;
};

// As high as the robot of the run says it is.
double body_height_m(const std::filesystem::path& run) {
  const std::filesystem::path mission = run / "mission.yaml";
  return std::filesystem::exists(mission)
             ? load_mission<ExploreMission>(mission.string(), {}, CameraRequirement::kNothing)
                   .robot.height_m
             : Body().height_m;
}

// Adds to a run all that can only be said by who knows the truth.
int evaluate(const EvaluateArguments& args) {
  const auto lock = FolderLock::take(args.run);
  if (!lock) {
    throw ConfigError(args.run + ": another panoptes is writing there; wait until it has ended");
  }
  const SavedRun saved = read_run(args.run);
  GivenTruth given = read_given_truth(args.truth);
  if (!args.world.empty() && !given.known.truth.body.cells.empty()) {
    throw ConfigError("--world: " + args.truth + " holds its world; leave --world out");
  }
  std::vector<std::string> warnings;
  RunTruth known = truth_during(saved.run, args.run, given, warnings);
  if (!args.world.empty()) {
    sim::TruthLayers layers =
        sim::truth_layers(sim::load_world(args.world), body_height_m(args.run));
    known.truth.floor = std::move(layers.floor);
    known.truth.body = std::move(layers.body);
  }
  for (const std::string& warning : warnings) {
    std::fprintf(stderr, "%s\n", warning.c_str());
  }
  const RunReport report = report_with(saved, known);
  print(report);
  return report.exit_status;
}

}  // namespace

void add_evaluate(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<EvaluateArguments>();
  CLI::App* sub = app.add_subcommand("evaluate", "What the truth says of a run that knew none");
  sub->add_option("RUN", args->run, "the directory of the run; its figures are replaced")
      ->required()
      ->type_name("DIR");
  sub->add_option("--truth", args->truth,
                  "the folder that panoptes serve has written, or a trajectory of the body")
      ->required()
      ->type_name("DIR|FILE.tum");
  sub->add_option("--world", args->world,
                  "the world that the trajectory lies in, for what was there to be mapped")
      ->type_name("FILE");
  sub->footer(
      "Example: panoptes evaluate runs/by-wire --truth runs/pioneer\n"
      "         panoptes evaluate runs/lab --truth tracked.tum --world lab.yaml");
  sub->callback([args, &chosen] { chosen = [args] { return evaluate(*args); }; });
}

}  // namespace panoptes
