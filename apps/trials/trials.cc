// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/mission/mission.h"
#include "apps/report/recorder.h"
#include "apps/run/loop.h"
#include "apps/trials/run_trials.h"
#include "apps/trials/tables.h"
#include "core/base/error.h"
#include "core/config/inputs.h"

namespace panoptes {
namespace {

struct TrialsArguments {
  std::vector<std::string> missions;
  std::string seeds = "1-5";
  std::vector<std::string> vary;
  int jobs = 1;
  std::string junit;
  CommonArguments common;
};

// Runs missions under many seeds and settings, and says whether all of them met their requirements.
int trials(const TrialsArguments& args) {
  TrialsOptions options;
  options.missions = args.missions;
  options.seeds = args.common.seed ? std::vector{*args.common.seed} : parse_seeds(args.seeds);
  CommonArguments every_run = args.common;
  every_run.seed.reset();
  options.set = every_run.overrides();
  for (const std::string& vary : args.vary) {
    add_vary(options, parse_vary(vary));
  }
  options.jobs = args.jobs;
  options.threads = args.common.threads;
  options.junit = args.junit;
  options.quiet = args.common.quiet;
  options.version = PANOPTES_VERSION;
  options.out_dir = args.common.out_dir.value_or(
      "runs/trials-" + std::filesystem::path(args.missions.front()).stem().string());
  options.resolve = [&](const std::string& file, const std::vector<std::string>& set) {
    keep_inputs();
    const auto mission = load_mission<ExploreMission>(file, set, CameraRequirement::kNavigator);
    if (takes_terminal(mission)) {
      throw ConfigError(file + ": drive: " + std::string(name_of(mission.drive)) +
                        " cannot be tried many times; record it once and give the dataset");
    }
    return ResolvedMission{mission.name, mission_text(options.version, write_settings(mission)),
                           inputs()};
  };
  return run_trials(options);
}

}  // namespace

void add_trials(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<TrialsArguments>();
  CLI::App* sub = app.add_subcommand("trials", "Many runs, one table, one verdict");
  sub->add_option("MISSION", args->missions, "the mission files")->required()->type_name("FILE...");
  sub->add_option("--seeds", args->seeds, "numbers and ranges, as 1-5,101 (1-5)")
      ->type_name("LIST");
  sub->add_option("--vary", args->vary, "a setting to try at each of several values")
      ->type_name("KEY.PATH=V1,V2")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  sub->add_option("--jobs", args->jobs, "runs at once (1)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  sub->add_option("--junit", args->junit, "the verdicts for a CI server, as JUnit XML")
      ->type_name("FILE")
      ->check([](const std::string& file) {
        return file.empty() ? "must name a file" : std::string();
      });
  add_common(*sub, args->common);
  sub->get_option("--threads")
      ->description(
          "of each run, that draw (1 or 2, as there are cores; 1 with more jobs than one)");
  sub->footer(table_legend() +
              "\nExample: panoptes trials scenes/missions/explore-office.yaml --seeds 1-5 --jobs 2 "
              "--out runs/trials");
  sub->callback([args, &chosen] { chosen = [args] { return trials(*args); }; });
}

}  // namespace panoptes
