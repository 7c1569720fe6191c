// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/command/command.h"
#include "apps/command/out_dir.h"
#include "apps/draw/pictures.h"
#include "apps/place/place_metrics.h"
#include "apps/place/placed_rig.h"
#include "apps/place/score_table.h"
#include "apps/place/sight_picture.h"
#include "apps/process/fault.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

struct PlaceArguments {
  std::vector<std::string> rigs;
  std::string robot;
  std::string out;
  std::vector<std::string> set;
  bool quick = false;
};

// What rigs can do for a robot by geometry alone, side by side.
int place(const PlaceArguments& args) {
  const PlaceOptions options = read_place_options(args.robot, args.set);
  std::vector<PlacedRig> rigs = read_rigs(args.rigs, options.robot, args.set);
  std::optional<OutDir> out;
  if (!args.out.empty()) {
    out.emplace(args.out);
  }
  for (PlacedRig& placed : rigs) {
    placed.scores = score_rig(options.scores, placed.rig, options.robot);
    if (!args.quick) {
      CalibratabilityOptions of_drive;
      of_drive.plan.room_m = options.scores.motion.room_m;
      placed.calibratability = calibratability(of_drive, placed.rig, options.robot);
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
      "place", "What can a rig do for a robot, by geometry alone? Scores one, or compares two");
  sub->add_option("RIG", args->rigs, "the rig file; a second one to compare it with")
      ->required()
      ->expected(1, 2)
      ->type_name("RIG [RIG]");
  sub->add_option("--robot", args->robot,
                  "the robot file: its body hides what is behind it, its speed decides how far it "
                  "must see; a Pioneer P3-DX")
      ->type_name("FILE");
  sub->add_option("--out", args->out,
                  "where metrics.json and a picture of each rig's floor from above go; nothing is "
                  "written without it")
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
  sub->add_flag("--quick", args->quick,
                "without how well a programmed motion would calibrate the rig, which takes "
                "seconds");
  sub->footer(
      "One rig:\n"
      "  panoptes place scenes/rigs/front-back-floor.yaml --out runs/rig\n"
      "Two of them, the second against the first:\n"
      "  panoptes place scenes/rigs/front-back-floor.yaml scenes/rigs/four-corners.yaml\n"
      "A camera tilted otherwise, on a slower bus:\n"
      "  panoptes place scenes/rigs/front-back-floor.yaml --set rig.cameras.floor.tilt_deg=40 "
      "--set "
      "scores.bus=firewire400");
  sub->callback([args, &chosen] { chosen = [args] { return place(*args); }; });
}

}  // namespace panoptes
