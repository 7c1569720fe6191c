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
  std::string keep = "all";
  int jobs = 1;
  std::string junit;
  std::string shard;
  bool merge = false;
  std::string engine;
  SlurmOptions slurm;
  CommonArguments common;
};

// What is to be run is said by mission files or by a study, which says what is varied, too.
void check_words(const TrialsArguments& args) {
  if (args.study.empty() && args.missions.empty() && !args.common.out_dir) {
    throw ConfigError(
        "MISSION is missing; name mission files, a study with --study FILE, or trials that were "
        "begun with --out DIR");
  }
  const int ways =
      (args.shard.empty() ? 0 : 1) + (args.merge ? 1 : 0) + (args.engine.empty() ? 0 : 1);
  if (ways > 1) {
    throw ConfigError("--shard, --merge and --engine: only one of them may be given");
  }
  if (args.engine.empty() &&
      (args.slurm.resume || args.slurm.wait || args.slurm.chunk || !args.slurm.words.empty())) {
    throw ConfigError("--resume, --wait, --chunk and --sbatch: are of --engine slurm");
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

std::filesystem::path default_out_dir(const TrialsArguments& args) {
  return "runs/trials-" +
         std::filesystem::path(args.study.empty() ? args.missions.front() : args.study)
             .stem()
             .string();
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
  options.keep = args.keep == "metrics" ? Keep::kMetrics : Keep::kAll;
  options.out_dir =
      args.common.out_dir ? std::filesystem::path(*args.common.out_dir) : default_out_dir(args);
  options.resolve = [&](const std::string& command, const std::string& file,
                        const std::vector<std::string>& set) {
    keep_inputs();
    const auto mission = load_mission<ExploreMission>(file, set, needs_of(command));
    if (takes_terminal(mission)) {
      throw ConfigError(file + ": drive: " + std::string(name_of(mission.drive)) +
                        " cannot be tried many times; record it once and give the dataset");
    }
    return ResolvedMission{mission.name, mission_text(options.version, write_settings(mission)),
                           inputs(), mission.until.duration_s};
  };
  if (!args.shard.empty()) {
    return run_shard(options, parse_shard(args.shard));
  }
  if (args.merge) {
    return merge_trials(options);
  }
  return args.engine.empty() ? run_trials(options) : submit_trials(options, args.slurm);
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
  sub->add_option("--keep", args->keep,
                  "what stays of each run: all, or its metrics, settings and inputs alone (all)")
      ->type_name("all|metrics")
      ->check(CLI::IsMember({"all", "metrics"}));
  sub->add_option("--shard", args->shard,
                  "make one part of the runs, and no table: on as many machines as there are "
                  "parts that share the folder")
      ->type_name("I/N");
  sub->add_flag("--merge", args->merge,
                "the tables of the runs that are there, and what is missing");
  sub->add_option("--engine", args->engine, "submit the runs as an array of jobs, and their merge")
      ->type_name("slurm")
      ->check(CLI::IsMember({"slurm"}));
  sub->add_flag("--resume", args->slurm.resume, "with --engine: submit what is missing");
  sub->add_flag("--wait", args->slurm.wait,
                "with --engine: until all is merged; round after round of a race");
  sub->add_option("--chunk", args->slurm.chunk,
                  "with --engine: runs a task (as many as take a minute; 1000 tasks at most)")
      ->type_name("N")
      ->check(CLI::Range(1, 1'000'000));
  sub->add_option("--sbatch", args->slurm.words,
                  "with --engine: words for sbatch, as '--partition=long --account=lab'")
      ->type_name("WORDS");
  sub->add_option("--junit", args->junit, "the verdicts for a CI server, as JUnit XML")
      ->type_name("FILE")
      ->check([](const std::string& file) {
        return file.empty() ? "must name a file" : std::string();
      });
  add_common(*sub, args->common);
  sub->get_option("--threads")
      ->description(
          "of each run, that draw (1 or 2, as there are cores; 1 with more jobs than one)");
  sub->footer(
      table_legend() +
      "\nExample: panoptes trials scenes/missions/explore-office.yaml --seeds 1-5 --jobs 2 "
      "--out runs/trials\n"
      "         panoptes trials --study scenes/studies/ladder.yaml --seeds 1-2 --jobs 2 "
      "--out runs/ladder\n"
      "         panoptes trials --out runs/ladder --jobs 2   # goes on with it\n"
      "         panoptes trials --study scenes/studies/ladder.yaml --seeds 1-2 --engine slurm "
      "--out runs/ladder");
  sub->callback([args, &chosen] { chosen = [args] { return trials(*args); }; });
}

}  // namespace panoptes
