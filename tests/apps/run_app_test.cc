// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run_app.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <CLI/CLI.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/doctor/doctor.h"
#include "core/io/file.h"
#include "tests/support/run_here.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kScenes = PANOPTES_SOURCE_DIR "/scenes/";
const std::string kOffice = kScenes + "missions/explore-office.yaml";

std::string write(const fs::path& file, const std::string& text) {
  std::ofstream(file) << text;
  return file.string();
}

std::string mission_with(const std::string& world) {
  return "rig: " + kScenes + "rigs/front-back-floor.yaml\nrobot: " + kScenes +
         "robots/pioneer3dx.yaml\nplatform: {kind: simulated, world: " + world + "}\n";
}

class RunApp : public ScratchTest {};

TEST_F(RunApp, EverySubcommandHasHelpWithAnExample) {
  for (const char* subcommand : {"explore", "navigate", "teleop", "serve", "record", "trials",
                                 "loops", "relax", "render", "check", "doctor"}) {
    const Said said = run_here({subcommand, "--help"});
    EXPECT_EQ(said.status, 0);
    EXPECT_THAT(said.out, HasSubstr(std::string("Example: panoptes ") + subcommand));
  }
  EXPECT_EQ(run_here({"--help"}).status, 0);
  EXPECT_THAT(run_here({"--version"}).out, StartsWith("panoptes "));
}

TEST_F(RunApp, BadUsageIsOneLineAndStatus2) {
  Said said = run_here({});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "panoptes: A subcommand is required; see panoptes --help\n");
  said = run_here({"explor"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "panoptes: explor is no subcommand; did you mean explore?\n");
  said = run_here({"explore"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "panoptes: MISSION is required; see panoptes explore --help\n");
  said = run_here({"explore", kOffice, "--seed", "x"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "panoptes: Could not convert: --seed = x; see panoptes explore --help\n");
  said = run_here({"explore", kOffice, "--seed", "-1"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err,
            "panoptes: --seed: must not be negative, got -1; see panoptes explore --help\n");
}

TEST_F(RunApp, GoalsThatAreNonePointsAreStatus2) {
  const std::string out = (folder_ / "out").string();
  const auto told = [&](const std::string& goals) {
    const Said said = run_here({"navigate", kOffice, "--goals", goals, "--out", out});
    EXPECT_EQ(said.status, 2) << goals;
    EXPECT_FALSE(fs::exists(out));
    return said.err;
  };
  EXPECT_EQ(told(""),
            "--goals: must name a place at least: x,y in metres, as in --goals '2,1; 4,3'\n");
  EXPECT_EQ(told("1,0; 2"), "--goals: goal 2 must be x,y in metres, got '2'\n");
  EXPECT_EQ(told("1,2,3"), "--goals: goal 1 must be x,y in metres, got '1,2,3'\n");
  EXPECT_EQ(told("a,b"), "--goals: goal 1 must be x,y in metres, got 'a,b'\n");
  EXPECT_EQ(told("nan,0"), "--goals: goal 1 must be x,y in metres, got 'nan,0'\n");
  EXPECT_EQ(told("0,-inf"), "--goals: goal 1 must be x,y in metres, got '0,-inf'\n");
  EXPECT_EQ(told("1,0;"), "--goals: goal 2 must be x,y in metres, got ''\n");
  for (const std::string far : {"1,-20000", "1e300,0"}) {
    EXPECT_EQ(told(far),
              "--goals: goal 1 must lie within 10000 m of the start, got '" + far + "'\n");
  }
  EXPECT_EQ(run_here({"navigate", kOffice}).err,
            "panoptes: --goals is required; see panoptes navigate --help\n");
}

TEST_F(RunApp, AMissingMissionIsStatus2) {
  const Said said = run_here({"explore", "nowhere.yaml"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "nowhere.yaml: no such file\n");
}

TEST_F(RunApp, AMissionThatCannotBeReadIsStatus2) {
  const Said said = run_here({"explore", folder_.string()});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr(": not a file\n"));
}

TEST_F(RunApp, AFileThatTheUserNamedAndThatIsMissingIsStatus2AndOneOfOursStatus3) {
  const std::string mission = write(folder_ / "m.yaml", mission_with("w.yaml"));
  Said said = run_here({"explore", mission, "--out", (folder_ / "out").string()});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, mission + ":3:36: platform.world: no such file: " +
                          (folder_ / "w.yaml").string() + "\n");
  const std::string world =
      write(folder_ / "w.yaml", "name: w\nobjects:\n  - {name: desk, mesh: desk.gltf}\n");
  said = run_here({"explore", mission, "--out", (folder_ / "out").string()});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, world + ":3:24: platform.world.objects[0].mesh: no such file: " +
                          (folder_ / "desk.gltf").string() + "\n");
  EXPECT_FALSE(fs::exists(folder_ / "out"));
  write(folder_ / "w.yaml", "name: w\nobjects:\n  - {name: desk, mesh: data:office/dusk.gltf}\n");
  EXPECT_EQ(run_here({"explore", mission, "--out", (folder_ / "out").string()}).status, 3);
}

TEST_F(RunApp, EveryCommandGivesStatus2ForAFileThatIsNotThere) {
  const std::string none = (folder_ / "none").string();
  const std::string out = (folder_ / "out").string();
  const std::string run = (folder_ / "run").string();
  fs::create_directories(folder_ / "run");
  write(folder_ / "run" / "metrics.json", "{}");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"explore", none},
                                             {"record", none},
                                             {"navigate", none, "--goals", "1,0"},
                                             {"teleop", none},
                                             {"serve", none},
                                             {"trials", none},
                                             {"render", none, "--pose", "1,1,0"},
                                             {"check", none},
                                             {"check", none + ".yaml"},
                                             {"relax", none, "--out", out + ".g2o"},
                                             {"relax", folder_.string(), "--out", out + ".g2o"},
                                             {"loops", none, "--out", out},
                                             {"evaluate", none, "--truth", none},
                                             {"evaluate", run, "--truth", none}}) {
    const Said said = run_here(words);
    EXPECT_EQ(said.status, 2) << words[0] << ": " << said.err << said.out;
    EXPECT_EQ(said.err.find("a bug"), std::string::npos) << said.err;
  }
}

TEST_F(RunApp, WhatIsNoMissionSaysWhatItIs) {
  Said said = run_here({"explore", kScenes + "worlds/office.yaml"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, kScenes +
                          "worlds/office.yaml: is a world, not a mission; a mission names it as "
                          "platform: {kind: simulated, world: FILE}, see scenes/missions\n");
  said = run_here({"trials", kScenes + "rigs/front-back-floor.yaml"});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr("is a rig, not a mission"));
  write(folder_ / "mission.yaml", "seed: 1\n");
  said = run_here({"render", folder_.string(), "--pose", "1,1,0"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, folder_.string() +
                          ": is the folder of a run, not a mission; the mission of that run is " +
                          (folder_ / "mission.yaml").string() + "\n");
}

TEST_F(RunApp, RelaxWritesOverNothing) {
  const std::string graph =
      write(folder_ / "a.g2o",
            "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  const std::string beside = write(folder_ / "b.metrics.json", "mine");
  const Said said = run_here({"relax", graph, "--out", (folder_ / "b.g2o").string()});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "--out " + (folder_ / "b.g2o").string() + ": " + beside +
                          " is there already; remove it or name another file\n");
  EXPECT_FALSE(fs::exists(folder_ / "b.g2o"));
}

TEST_F(RunApp, NamesThatAreNotUtf8AreToldBeforeAnythingRuns) {
  const std::string name = folder_.string() + "/caf\xe9.yaml";
  write(name, mission_with(kScenes + "worlds/office.yaml"));
  Said said = run_here({"check", name});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.out, HasSubstr(": name: must be given, for the file's own name is not UTF-8"));
  said =
      run_here({"check", write(folder_ / "m.yaml",
                               "name: caf\xe9\n" + mission_with(kScenes + "worlds/office.yaml"))});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.out,
            (folder_ / "m.yaml").string() + ":1:10: not UTF-8 text; save it again as UTF-8\n");
}

TEST_F(RunApp, CheckRefusesWhatCouldNotRun) {
  const std::string mission =
      write(folder_ / "m.yaml", mission_with(kScenes + "worlds/office.yaml, start: {x_m: 4.95, "
                                                       "y_m: 4.0, theta_deg: -90}"));
  const auto refusal = [&](const std::string& more) {
    const std::string file = write(folder_ / "n.yaml", read_file(mission) + more);
    const Said said = run_here({"check", file});
    EXPECT_EQ(said.status, 2) << said.out;
    return said.out;
  };
  EXPECT_EQ(run_here({"check", mission}).status, 0);
  EXPECT_THAT(refusal("require: [\"map.coverag >= 0.5\"]\n"),
              HasSubstr("no run has a figure 'map.coverag'; did you mean map.coverage?"));
  EXPECT_THAT(refusal("require: [\"outcome == complete\"]\n"),
              HasSubstr("did you mean completed?"));
  EXPECT_THAT(refusal("drive: {route: {waypoints: [{x_m: 4.95, y_m: 3}, {x_m: 44, y_m: 2}]}}\n"),
              HasSubstr("drive.route.waypoints[1]: x_m: 44.000, y_m: 2.000 is outside of the "
                        "world"));
  EXPECT_THAT(
      refusal("drive: {route: {waypoints: [{x_m: 2.1, y_m: 2}]}}\n"),
      HasSubstr("drive.route.waypoints[0]: x_m: 2.100, y_m: 2.000 cannot be reached: on the "
                "straight way there the robot would run into "));
}

TEST_F(RunApp, CheckRefusesCamerasThatCouldNotServe) {
  const auto refusal = [&](const std::string& from, const std::string& to) {
    std::string rig = read_file(kScenes + "rigs/front-back-floor.yaml");
    rig.replace(rig.find(from), from.size(), to);
    write(folder_ / "rig.yaml", rig);
    const std::string file =
        write(folder_ / "m.yaml", "rig: rig.yaml\nplatform: {kind: simulated, world: " + kScenes +
                                      "worlds/office.yaml}\n");
    const Said said = run_here({"check", file});
    EXPECT_EQ(said.status, 2) << said.out;
    return said.out;
  };
  EXPECT_THAT(refusal("at_m: [0, 0, 0.79]", "at_m: [0, 10, 0.79]"),
              HasSubstr("rig.cameras.front: is mounted 10.000 m from the robot's middle, but the "
                        "robot reaches 0.250 m"));
  EXPECT_THAT(refusal("size_px: [320, 240]", "size_px: [2, 2]"),
              HasSubstr("rig.cameras.front.size_px: must be at least 48 either way"));
}

TEST_F(RunApp, ASeedThatNoNumberHoldsIsRefused) {
  const Said said = run_here({"explore", kOffice, "--seed", "18446744073709551616"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err,
            "panoptes: --seed: must be at most 18446744073709551615, got 18446744073709551616; "
            "see panoptes explore --help\n");
}

TEST_F(RunApp, OverridesOnNothingAreStatus2) {
  const Said said = run_here({"explore", kOffice, "--set", "navigator.drivr.lookahead_m=1"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(
      said.err,
      "--set navigator.drivr.lookahead_m: navigator.drivr: unknown key; did you mean driver?\n");
}

TEST_F(RunApp, AFolderThatIsNotEmptyIsRefusedBeforeAnythingRuns) {
  write(folder_ / "x", "x");
  const Said said = run_here({"explore", kOffice, "--out", folder_.string()});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr("is not empty"));
}

TEST_F(RunApp, ServingWhereItCannotIsToldBeforeAnythingRuns) {
  const auto serve = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"serve", kOffice, "--quiet", "--out", (folder_ / "s").string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_here(words);
  };
  Said said = serve({"--host", "192.0.2.1"});
  EXPECT_EQ(said.status, 3);
  EXPECT_EQ(said.err,
            "tcp:192.0.2.1:8101: Cannot assign requested address; give --host an address of this "
            "machine\n");
  said = serve({"--link", folder_.string()});
  EXPECT_EQ(said.status, 3);
  EXPECT_THAT(said.err, HasSubstr("; name another path by --link\n"));
  EXPECT_EQ(serve({"--port", "65536"}).status, 2);
  EXPECT_FALSE(fs::exists(folder_ / "s"));
}

TEST_F(RunApp, AFolderThatCannotBeWrittenIsStatus2) {
  const Said said = run_here({"explore", kOffice, "--out", "/proc/nowhere"});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, StartsWith("/proc/nowhere: "));
}

TEST_F(RunApp, AStartInsideFurnitureIsStatus2) {
  const Said said = run_here({"check", kOffice});
  EXPECT_EQ(said.status, 0);
  const std::string mission =
      write(folder_ / "m.yaml",
            mission_with(kScenes + "worlds/office.yaml, start: {x_m: 0.1, y_m: 0.1}"));
  const Said refused = run_here({"check", mission});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.out, StartsWith(mission + ":3:"));
  EXPECT_THAT(refused.out, HasSubstr("platform.start: x_m: 0.100, y_m: 0.100 is inside "));
}

TEST_F(RunApp, CheckKnowsEveryKindOfFile) {
  const std::string route = write(folder_ / "r.yaml", "waypoints: [{x_m: 1, y_m: 2}]\n");
  const std::string robot = write(folder_ / "b.yaml", "radius_m: 0.3\n");
  const std::string rig = kScenes + "rigs/front-back-floor.yaml";
  const std::string placements = kScenes + "placements/floor-camera.yaml";
  Said said = run_here({"check", route, robot, rig, placements});
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(said.out, route + ": ok (route)\n" + robot + ": ok (robot)\n" + rig + ": ok (rig)\n" +
                          placements + ": ok (placement study)\n");
  const std::string broken = write(folder_ / "c.yaml", "radius_m: 0.3\nheigth_m: 1\n");
  said = run_here({"check", robot, broken});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.out, robot + ": ok (robot)\n" + broken +
                          ":2:1: heigth_m: unknown key; did you mean height_m?\n");
  const std::string odd = write(folder_ / "d.yaml", "a: b\n");
  said = run_here({"check", odd});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.out,
            odd +
                ": cannot tell what this is; a mission has platform:, a world objects:, boxes:, "
                "generate: or floor_plan:, a rig cameras:, a robot radius_m:, a route waypoints: "
                "or tour:, a map image: and occupied_thresh:, a study rungs:, a placement study "
                "parameters:\n");
}

TEST_F(RunApp, CheckReadsWhatAPlacementStudyDrives) {
  const std::string text = "rig: " + kScenes + "rigs/front-and-back.yaml\n" +
                           "parameters:\n"
                           "  tilt_deg: {set: ['cameras.front.tilt_deg={}'], values: [5, 50]}\n"
                           "drive:\n"
                           "  missions: [{name: office, mission: " +
                           kOffice + "}]\n";
  const std::string study = write(folder_ / "p.yaml", text + "  set: [until.durations_s=300]\n");
  Said said = run_here({"check", study});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.out, study + ":6:9: until.durations_s: unknown key; did you mean duration_s?\n");
  write(folder_ / "p.yaml", text + "  set: [until.duration_s=300]\n");
  said = run_here({"check", study});
  EXPECT_EQ(said.out, study + ": ok (placement study)\n");
}

TEST_F(RunApp, EveryStudyThatIsHereIsRight) {
  for (const auto& entry : fs::directory_iterator(kScenes + "placements")) {
    const std::string study = entry.path().string();
    EXPECT_EQ(run_here({"check", study}).out, study + ": ok (placement study)\n");
  }
  for (const auto& entry : fs::directory_iterator(kScenes + "studies")) {
    const std::string study = entry.path().string();
    EXPECT_EQ(run_here({"check", study}).out, study + ": ok (study)\n");
  }
}

TEST_F(RunApp, TrialsTakeNoPerson) {
  const Said said = run_here({"trials", kOffice, "--set", "drive=teleop", "--out", folder_ / "t"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, kOffice +
                          ": drive: teleop cannot be tried many times; record it once and give "
                          "the dataset\n");
}

TEST_F(RunApp, TrialsTakeMissionsOrAStudy) {
  const std::string study = kScenes + "studies/ladder.yaml";
  const auto refused = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "trials");
    const Said said = run_here(words);
    EXPECT_EQ(said.status, 2);
    return said.err;
  };
  EXPECT_EQ(
      refused({}),
      "MISSION is missing; name mission files, a study with --study FILE, or trials that were "
      "begun with --out DIR\n");
  EXPECT_EQ(refused({kOffice, "--merge", "--shard", "1/2"}),
            "--shard, --merge and --engine: only one of them may be given\n");
  EXPECT_EQ(refused({kOffice, "--resume"}),
            "--resume, --wait, --chunk and --sbatch: are of --engine slurm\n");
  EXPECT_EQ(refused({kOffice, "--study", study}),
            "--study " + study + ": missions must not be given beside it, got " + kOffice +
                "; the study names its missions and what is varied\n");
  EXPECT_EQ(refused({"--vary", "a=1", "--study", study}),
            "--study " + study +
                ": --vary must not be given beside it, got a=1; the study names "
                "its missions and what is varied\n");
  EXPECT_EQ(refused({"--study", kOffice}),
            kOffice +
                ": is a mission, not a study; a study has missions:, rigs: and rungs:, see "
                "scenes/studies\n");
  EXPECT_EQ(refused({study}),
            study +
                ": is a study, not a mission; panoptes trials --study FILE runs all of its "
                "missions\n");
}

TEST_F(RunApp, DoctorAsksAtAPortWhereSomebodyCan) {
  CLI::App app;
  Command chosen;
  add_doctor(app, chosen, [](const std::string& address) {
    EXPECT_EQ(address, "tcp:robot:8101");
    return hw::PioneerIdentity{"one", "Pioneer", "p3dx", "2.9", 12.5, 0};
  });
  app.parse("doctor --port tcp:robot:8101");
  testing::internal::CaptureStdout();
  EXPECT_EQ(chosen(), 0);
  EXPECT_EQ(testing::internal::GetCapturedStdout(),
            "tcp:robot:8101: Pioneer p3dx \"one\", firmware 2.9, battery 12.5 V\n");
}

TEST_F(RunApp, DoctorRefusesWhatIsNoAddress) {
  for (const char* port : {"", "/dev/ttyUSB0", "tcp:127.0.0.1", "tcp:127.0.0.1:99999"}) {
    const Said said = run_here({"doctor", "--port", port});
    EXPECT_EQ(said.status, 2);
    EXPECT_THAT(said.err, HasSubstr(std::string("--port '") + port + "': "));
  }
}

TEST_F(RunApp, DoctorFindsWhatTheTestsNeed) {
  const Said said = run_here({"doctor"});
  EXPECT_EQ(said.status, 0) << said.out;
  EXPECT_THAT(said.out, StartsWith("ok      renderer"));
  EXPECT_THAT(said.out, HasSubstr("serial port"));
  EXPECT_THAT(said.out, HasSubstr("gamepads"));
}

}  // namespace
}  // namespace panoptes
