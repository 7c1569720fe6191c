// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/calibrate/lens_stage.h"
#include "apps/calibrate/map_stage.h"
#include "apps/calibrate/plan_stage.h"
#include "apps/calibrate/recorded_here.h"
#include "apps/calibrate/rig_stage.h"
#include "apps/command/command.h"
#include "core/base/error.h"
#include "core/config/inputs.h"
#include "core/io/file.h"
#include "sim/render/renderer.h"

namespace panoptes {
namespace {

struct CalibrateArguments {
  LensStage lens;
  MapStage maps;
  RigStage rig;
  PlanStage plan;
  bool is_plan = false;
  std::string stage;
  std::string features = "sift";
  std::string method = "guided";
  CommonArguments drive;  ///< of a mission: only what is said of it
  std::string inputs;
};

FeatureMethod method_of(const std::string& word) {
  for (const FeatureMethod method :
       {FeatureMethod::kSift, FeatureMethod::kAkaze, FeatureMethod::kOrb, FeatureMethod::kSurf}) {
    if (name(method) == word) {
      const std::string fault = feature_method_fault(method);
      if (!fault.empty()) {
        throw ConfigError("--features: " + fault);
      }
      return method;
    }
  }
  return FeatureMethod::kSift;
}

RigMethod rig_method_of(const std::string& word) {
  for (const RigMethod method : {RigMethod::kThesis, RigMethod::kCycles}) {
    if (name(method) == word) {
      return method;
    }
  }
  return RigMethod::kGuided;
}

bool is_file(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

int calibrate(CalibrateArguments args) {
  if (!args.inputs.empty()) {
    keep_inputs();
    note_input("/proc/self/exe");
  }
  if (args.is_plan) {
    args.plan.mission = args.lens.pictures;
    args.plan.overrides = args.drive.overrides();
    args.plan.rig = args.lens.rig;
    args.plan.cameras = args.maps.cameras;
    args.plan.out = args.lens.out;
    return plan_calibration_of(args.plan);
  }
  args.rig.method = rig_method_of(args.method);
  const bool draws = args.rig.method != RigMethod::kGuided;
  const bool by_mission =
      is_file(args.lens.pictures) && args.stage.empty() && args.lens.board.empty();
  args.rig.seed = args.drive.seed.value_or(0);
  if (!by_mission && draws) {
    args.drive.seed.reset();
  }
  if (!by_mission && !args.drive.overrides().empty()) {
    throw ConfigError(
        "--seed, --duration and --set are of a mission that is recorded first; give its file in "
        "place of " +
        args.lens.pictures);
  }
  if (!by_mission && args.lens.board.empty() && args.lens.threads) {
    throw ConfigError(
        "--threads is of boards, and of a mission that is recorded first; give --board, or a "
        "mission's file in place of " +
        args.lens.pictures);
  }
  if (!by_mission && !args.inputs.empty()) {
    throw ConfigError(
        "--inputs is of a mission that is recorded first; give its file in place of " +
        args.lens.pictures);
  }
  if (args.stage == "maps") {
    args.maps.dataset = args.lens.pictures;
    args.maps.rig = args.lens.rig;
    args.maps.out = args.lens.out;
    args.maps.slam.features = method_of(args.features);
    args.maps.quiet = args.lens.quiet;
    return calibrate_maps(args.maps);
  }
  if (!args.lens.board.empty()) {
    return calibrate_lenses(args.lens);
  }
  args.rig.dataset = args.lens.pictures;
  if (by_mission) {
    if (args.lens.threads) {
      sim::set_render_threads(*args.lens.threads);
    }
    const DriveToRecord drive{args.lens.pictures, args.drive.overrides(), args.lens.out,
                              args.lens.quiet};
    if (const int status = record_here(drive); status != 0) {
      return status;
    }
    if (!args.inputs.empty()) {  // before its own recording is read
      write_file(args.inputs, inputs_text(inputs()));
    }
    args.rig.dataset = drive.dataset().string();
  }
  args.rig.rig = args.lens.rig;
  args.rig.cameras = args.maps.cameras;
  args.rig.out = args.lens.out;
  args.rig.slam.features = method_of(args.features);
  args.rig.by_maps.joined =
      args.rig.method == RigMethod::kCycles ? MapsJoined::kGraph : MapsJoined::kChain;
  args.rig.quiet = args.lens.quiet;
  return calibrate_rig_of(args.rig);
}

}  // namespace

void add_calibrate(CLI::App& app, Command& chosen) {
  auto args = std::make_shared<CalibrateArguments>();
  CLI::App* sub = app.add_subcommand("calibrate",
                                     "How the cameras of a rig are mounted, by a recorded drive; "
                                     "what lenses are, by pictures of a "
                                     "chessboard");
  sub->add_option(
         "PICTURES", args->lens.pictures,
         "a dataset, or the file of a mission, whose drive is recorded first; with --board "
         "also a folder of one camera's pictures, or a folder with one such folder for "
         "each camera")
      ->required()
      ->type_name("DIR|MISSION");
  CLI::Option* board = sub->add_option("--board", args->lens.board,
                                       "the chessboard: inner corners along and down, side of a "
                                       "square in metres")
                           ->type_name("9x6x0.025");
  CLI::Option* stage =
      sub->add_option("--stage", args->stage,
                      "maps: each camera's own map of the room, by MonoSLAM, from a dataset of a "
                      "drive that turns all round")
          ->check(CLI::IsMember({"maps"}))
          ->excludes(board);
  CLI::Option* plan =
      sub->add_flag("--plan", args->is_plan,
                    "says what a mission's programmed motion will show, and to what sigma, before "
                    "anything is driven or recorded; needs no --out")
          ->excludes(board)
          ->excludes(stage);
  sub->add_option("--room", args->plan.room,
                  "the room that a plan assumes, in metres; the robot starts in the middle, along "
                  "the length; 5.5x5.5x2.6")
      ->needs(plan)
      ->type_name("LENGTHxWIDTHxHEIGHT");
  sub->add_option("--lens", args->lens.lens,
                  "auto (what explains the corners better), brown_conrady or equidistant")
      ->check(CLI::IsMember({"auto", "brown_conrady", "equidistant"}))
      ->needs(board);
  sub->add_option("--cameras", args->maps.cameras,
                  "of a dataset, which are calibrated or mapped, the one first that the others are "
                  "told relative to; all")
      ->delimiter(',')
      ->type_name("NAME,...")
      ->excludes(board);
  sub->add_option("--features", args->features,
                  "what points are recognised by: sift, akaze (the nearest to surf), orb, or surf "
                  "where the OpenCV at hand has it")
      ->check(CLI::IsMember({"sift", "akaze", "orb", "surf"}))
      ->excludes(board);
  sub->add_option(
         "--method", args->method,
         "how a rig is told: guided (by the wheels, and points sought in every camera's "
         "pictures), thesis (by maps that are laid on each other by what looks alike, in a "
         "chain; without a metre) or cycles (the same, cycles of maps checked); of the "
         "latter two --seed N draws otherwise")
      ->check(CLI::IsMember({"guided", "thesis", "cycles"}))
      ->excludes(board)
      ->excludes(stage)
      ->excludes(plan);
  sub->add_flag("--odometry", args->maps.slam.motion_is_told,
                "the wheels say how the camera moves between pictures, and what a metre is")
      ->needs(stage);
  sub->add_option("--rig", args->lens.rig,
                  "the rig file: what the lenses are, or where they are put in; of a dataset its "
                  "own, where it has one")
      ->type_name("FILE");
  sub->add_option(
         "--out", args->lens.out,
         "where the results go: rig_calibrated.yaml, the same for Kalibr (camchain.yaml) and ROS "
         "(camera_info/CAMERA.yaml, rig.urdf), the pictures rig.png, matches_CAMERA_CAMERA.png and "
         "reprojection_rig_CAMERA.png, the recording of a mission, and each "
         "camera's map, so that an interrupted calibration goes on when it is started again; with "
         "--board "
         "rig_calibrated.yaml (lenses.yaml without a rig), boards_CAMERA.png and boards.csv, with "
         "--stage maps map_CAMERA.png, "
         "growth_CAMERA.png, search_CAMERA.png, reprojection_CAMERA.png, points_CAMERA.csv and "
         "path_CAMERA.tum; metrics.json")
      ->type_name("DIR");
  sub->add_option("--threads", args->lens.threads,
                  "to look for boards with, or to draw what a mission records; changes no result")
      ->check(CLI::Range(1, 64))
      ->excludes(plan);
  sub->add_option("--inputs", args->inputs,
                  "of a mission: keep what it was made of: every file that was read, and the "
                  "program, with its SHA-256, as sha256sum -c reads it")
      ->type_name("FILE")
      ->excludes(plan);
  add_overrides(*sub, args->drive);
  sub->add_flag("--quiet", args->lens.quiet, "no progress");
  sub->footer(
      "A rig, by a drive that turns by more than a whole turn and has legs, or a rose:\n"
      "  panoptes record scenes/missions/record-room.yaml --out runs/rose\n"
      "  panoptes calibrate runs/rose --out runs/rig\n"
      "Both at once, the recording goes to runs/rig/recording:\n"
      "  panoptes calibrate scenes/missions/record-room.yaml --seed 1 --out runs/rig\n"
      "As the thesis does it, by the same recording:\n"
      "  panoptes calibrate runs/rose --method thesis --seed 3 --out runs/thesis\n"
      "What a drive will show, before it is driven:\n"
      "  panoptes calibrate scenes/missions/record-room.yaml --plan\n"
      "Lenses by a board: hold a stiff board still in 20 to 40 places: all over the picture, near "
      "enough to fill a "
      "third of it,\nslanted by up to 45 degrees each way, and wholly in the picture.\n"
      "  panoptes calibrate pictures/ --board 9x6x0.025 --out runs/lens\n"
      "A map for each camera by itself:\n"
      "  panoptes calibrate runs/rose --stage maps --out runs/maps");
  sub->callback([args, sub, &chosen] {
    if (!args->is_plan && sub->count("--out") == 0) {
      throw CLI::RequiredError("--out");
    }
    chosen = [args] { return calibrate(*args); };
  });
}

}  // namespace panoptes
