// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/mission/file_kind.h"
#include "apps/mission/mission.h"
#include "apps/report/recorder.h"
#include "apps/run/loop.h"
#include "apps/study/study.h"
#include "apps/trials/run_trials.h"
#include "apps/trials/tables.h"
#include "core/base/error.h"
#include "core/config/inputs.h"

namespace panoptes {
namespace {

struct TrialsArguments {
  std::vector<std::string> missions;
  std::string study;
  std::string seeds = "1-5";
  std::vector<std::string> vary;
  int jobs = 1;
  std::string junit;
  CommonArguments common;
};

// What is to be run is said by mission files or by a study, which says what is varied, too.
void check_words(const TrialsArguments& args) {
  if (args.study.empty() && args.missions.empty()) {
    throw ConfigError("MISSION is missing; name mission files, or a study with --study FILE");
  }
  if (args.study.empty()) {
    return;
  }
  for (const auto& [word, values] :
       {std::pair{"missions", &args.missions}, {"--vary", &args.vary}}) {
    if (!values->empty()) {
      throw ConfigError("--study " + args.study + ": " + word +
                        " must not be given beside it, got " + values->front() +
                        "; the study names its missions and what is varied");
    }
  }
  std::error_code ignored;
  if (std::filesystem::is_regular_file(args.study, ignored)) {
    const FileKind* kind = kind_by_keys(args.study);
    if (kind != nullptr && kind->name != "study") {
      throw ConfigError(
          args.study + ": is a " + kind->name +
          ", not a study; a study has missions:, rigs: and rungs:, see scenes/studies");
    }
  }
}

// Runs missions under many seeds and settings, and says whether all of them met their requirements.
int trials(const TrialsArguments& args) {
  check_words(args);
  TrialsOptions options;
  if (!args.study.empty()) {
    options.study = read_study(args.study);
  }
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
      "runs/trials-" +
      std::filesystem::path(args.study.empty() ? args.missions.front() : args.study)
          .stem()
          .string());
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
  sub->add_option("MISSION", args->missions, "the mission files")->type_name("FILE...");
  sub->add_option("--study", args->study,
                  "in place of missions: a table of rungs, rigs and missions, and its limits")
      ->type_name("FILE");
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
              "--out runs/trials\n"
              "         panoptes trials --study scenes/studies/ladder.yaml --seeds 1-2 --jobs 2 "
              "--out runs/ladder");
  sub->callback([args, &chosen] { chosen = [args] { return trials(*args); }; });
}

}  // namespace panoptes
