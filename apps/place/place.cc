// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <variant>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/command/out_dir.h"
#include "apps/draw/pictures.h"
#include "apps/mission/file_kind.h"
#include "apps/mission/stop_condition.h"
#include "apps/place/drives.h"
#include "apps/place/pareto_picture.h"
#include "apps/place/place_metrics.h"
#include "apps/place/placed_rig.h"
#include "apps/place/rig_sweep.h"
#include "apps/place/score_table.h"
#include "apps/place/sight_picture.h"
#include "apps/place/sweep_report.h"
#include "apps/process/fault.h"
#include "apps/process/progress.h"
#include "core/base/error.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

struct PlaceArguments {
  std::vector<std::string> files;  ///< rigs, or one study
  std::string robot;
  std::string out;
  std::vector<std::string> set;
  int jobs = 1;
  bool quick = false;
  bool quiet = false;
};

bool is_study(const std::string& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) {
    return false;
  }
  const FileKind* kind = kind_by_keys(file);
  return kind != nullptr && kind->name == "placement study";
}

// What it will cost, by one rig. Of a short one there is nothing to say.
void say_cost(const PlacementStudy& study, int jobs) {
  constexpr double kShort_s = 5;
  const auto* search = std::get_if<Nsga2Sweep>(&study.sweep);
  std::vector<double> lows;
  for (const PlacementAxis& axis : axes_of(study)) {
    lows.push_back(axis.low);
  }
  const std::size_t rigs =
      search != nullptr ? static_cast<std::size_t>(search->rigs) : points_of(study).size();
  const Rig first = rig_of(study, point_at(study, lows));
  const auto began = std::chrono::steady_clock::now();
  score_rig(study.scores, first, study.robot);
  if (asks_calibratability(study)) {
    calibratability(study.scores, first, study.robot);
  }
  const std::chrono::duration<double> one = std::chrono::steady_clock::now() - began;
  const double all_s = one.count() * static_cast<double>(rigs) / jobs;
  if (all_s > kShort_s) {
    std::fprintf(stderr, "%s%zu rigs, about %.0f s\n", search != nullptr ? "at most " : "", rigs,
                 all_s);
  }
}

// All rigs of a study, the best of them as a file of its own.
int place_study(const PlaceArguments& args) {
  if (args.files.size() > 1) {
    throw ConfigError(args.files[0] + ": is a placement study, which stands alone; leave out " +
                      args.files[1]);
  }
  if (!args.set.empty() || !args.robot.empty()) {
    throw ConfigError(args.files[0] +
                      ": is a placement study, which says itself what --set and "
                      "--robot say of rigs; change it there");
  }
  const PlacementStudy study = read_placement_study(args.files[0]);
  std::optional<OutDir> out;
  if (!args.out.empty()) {
    out.emplace(args.out);
  }
  ProgressLine line(args.quiet);
  if (!args.quiet) {
    say_cost(study, args.jobs);
  }
  const StopCondition stop_condition{StopOptions()};
  const RigSweep sweep = sweep_rigs(
      study, args.jobs,
      [&line](double done) {
        if (line.due()) {
          line.show(share_line("rigs", done, line.wall_s()));
        }
      },
      [&] { return stop_condition.interrupted(); });
  std::printf("%s", sweep_table(study, sweep).c_str());
  const bool any_good = std::any_of(sweep.rigs.begin(), sweep.rigs.end(),
                                    [](const SweptRig& swept) { return swept.good(); });
  if (sweep.cut_short) {
    std::fprintf(stderr, "interrupted: %zu rigs were tried, and all that follows is of these%s\n",
                 sweep.rigs.size(), out ? "" : "; nothing is kept without --out");
  }
  const int status = sweep.cut_short ? kInterrupted : any_good ? 0 : 1;
  if (!out) {
    return status;
  }
  out->keep();
  Faults faults;
  faults.attempt([&] { write_sweep_csv(out->path() / "study.csv", study, sweep); });
  if (!sweep.ranked.empty()) {
    faults.attempt([&] { write_file(out->path() / "rig_best.yaml", best_rig_file(study, sweep)); });
    faults.attempt(
        [&] { write_file(out->path() / "pareto.png", png(pareto_picture(study, sweep))); });
  }
  if (study.drive && !sweep.ranked.empty() && !sweep.cut_short) {
    faults.attempt([&] {
      ProgressLine of_drives(args.quiet);
      write_drives(out->path(), study, sweep, [&](double done) {
        if (of_drives.due()) {
          of_drives.show(share_line("what calibrating leaves", done, of_drives.wall_s()));
        }
      });
    });
    std::printf("to drive them: panoptes trials --study %s --seeds 1-8 --jobs 2 --out %s\n",
                (out->path() / "drives.yaml").c_str(), (out->path() / "drives").c_str());
    faults.attempt([&] { write_calibrations(out->path(), study, sweep); });
    std::printf(
        "to record and calibrate three, on a Pioneer: panoptes trials --study %s --seeds 1-3 "
        "--jobs 2 --out %s\n",
        (out->path() / "calibrations.yaml").c_str(), (out->path() / "calibrations").c_str());
  }
  constexpr std::size_t kDrawn = 3;
  for (const std::size_t rig : promoted_rigs(sweep, kDrawn)) {
    faults.attempt([&] {
      const PlaceOptions options{study.scores, study.robot};
      PlacedRig placed;
      placed.name = "rig-" + std::to_string(rig + 1);
      placed.rig = rig_of(study, sweep.rigs[rig].point);
      placed.scores = score_rig(options.scores, placed.rig, options.robot);
      write_file(out->path() / ("floor_" + placed.name + ".png"),
                 png(sight_picture(placed, options)));
    });
  }
  faults.attempt([&] {
    write_file(out->path() / "metrics.json", sweep_metrics(study, sweep, PANOPTES_VERSION));
  });
  return !faults.none() ? faults.status() : status;
}

// What rigs can do for a robot by geometry alone, side by side.
int place(const PlaceArguments& args) {
  if (std::any_of(args.files.begin(), args.files.end(), is_study)) {
    return place_study(args);
  }
  const PlaceOptions options = read_place_options(args.robot, args.set);
  std::vector<PlacedRig> rigs = read_rigs(args.files, options.robot, args.set);
  std::optional<OutDir> out;
  if (!args.out.empty()) {
    out.emplace(args.out);
  }
  for (PlacedRig& placed : rigs) {
    placed.scores = score_rig(options.scores, placed.rig, options.robot);
    if (!args.quick) {
      placed.calibratability = calibratability(options.scores, placed.rig, options.robot);
      placed.sensitivity = rig_sensitivity({}, options.scores, placed.rig, options.robot);
    }
  }
  std::printf("%s", score_table(rigs).c_str());
  if (!out) {
    return 0;
  }
  out->keep();
  Faults faults;
  for (const PlacedRig& placed : rigs) {
    faults.attempt([&] {
      write_file(out->path() / ("floor_" + placed.name + ".png"),
                 png(sight_picture(placed, options)));
    });
  }
  faults.attempt([&] {
    write_file(out->path() / "metrics.json", place_metrics(rigs, options, PANOPTES_VERSION));
  });
  return faults.none() ? 0 : faults.status();
}

}  // namespace

void add_place(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<PlaceArguments>();
  CLI::App* sub = app.add_subcommand(
      "place",
      "What can a rig do for a robot, by geometry alone? Scores one, compares two, or tries "
      "many");
  sub->add_option("RIG", args->files,
                  "the rig file; a second one to compare it with; or a placement study, which "
                  "varies a rig")
      ->required()
      ->expected(1, 2)
      ->type_name("RIG [RIG] | STUDY");
  sub->add_option("--robot", args->robot,
                  "the robot file: its body hides what is behind it, its speed decides how far it "
                  "must see; a Pioneer P3-DX")
      ->type_name("FILE");
  sub->add_option(
         "--out", args->out,
         "where metrics.json and a picture of each rig's floor from above go, and of a study "
         "study.csv, pareto.png and rig_best.yaml; nothing is written without it")
      ->type_name("DIR");
  sub->add_option(
         "--set", args->set,
         "a setting: rig.KEY of both rigs, robot.KEY, or scores.KEY of what is counted "
         "(reach_m, cell_m, distances_m, latency_s, obstacle_px, around_m, room_m, features, "
         "feature_sigma_px, bus (firewire800, firewire400, gige), fixed_modes, "
         "dma_contexts, bits_per_px); repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  sub->add_flag(
      "--quick", args->quick,
      "without how well a programmed motion would calibrate the rig, and how scores change "
      "when cameras are mounted off, which take seconds");
  sub->add_option("--jobs", args->jobs, "of a study, rigs at a time; changes no result (1)")
      ->type_name("N")
      ->check(CLI::Range(1, 256));
  sub->add_flag("--quiet", args->quiet, "no progress");
  sub->footer(
      "One rig:\n"
      "  panoptes place scenes/rigs/front-back-floor.yaml --out runs/rig\n"
      "Two of them, the second against the first:\n"
      "  panoptes place scenes/rigs/front-back-floor.yaml scenes/rigs/four-corners.yaml\n"
      "A camera tilted otherwise, on a slower bus:\n"
      "  panoptes place scenes/rigs/front-back-floor.yaml --set rig.cameras.floor.tilt_deg=40 "
      "--set "
      "scores.bus=firewire400\n"
      "All tilts and heights of a floor camera, the best that hold what is required first:\n"
      "  panoptes place scenes/placements/floor-camera.yaml --jobs 2 --out runs/placement\n"
      "The same without steps, by a search:\n"
      "  panoptes place scenes/placements/floor-camera-search.yaml --jobs 2 --out runs/search");
  sub->callback([args, &chosen] { chosen = [args] { return place(*args); }; });
}

}  // namespace panoptes
