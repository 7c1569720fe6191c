// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run_app.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kScenes = std::string(PANOPTES_SOURCE_DIR) + "/scenes/";
const std::string kOffice = kScenes + "missions/explore-office.yaml";

struct Said {
  int status = 0;
  std::string out;
  std::string err;
};

Said run(std::vector<std::string> words) {
  words.insert(words.begin(), "panoptes");
  std::vector<const char*> argv;
  for (const std::string& word : words) {
    argv.push_back(word.c_str());
  }
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Said said;
  said.status = run_app(static_cast<int>(argv.size()), argv.data());
  said.out = testing::internal::GetCapturedStdout();
  said.err = testing::internal::GetCapturedStderr();
  return said;
}

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
  for (const char* subcommand :
       {"explore", "record", "trials", "loops", "relax", "render", "check", "doctor"}) {
    const Said said = run({subcommand, "--help"});
    EXPECT_EQ(said.status, 0);
    EXPECT_THAT(said.out, HasSubstr(std::string("Example: panoptes ") + subcommand));
  }
  EXPECT_EQ(run({"--help"}).status, 0);
  EXPECT_THAT(run({"--version"}).out, StartsWith("panoptes "));
}

TEST_F(RunApp, BadUsageIsOneLineAndStatus2) {
  Said said = run({});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "panoptes: A subcommand is required; see panoptes --help\n");
  said = run({"explor"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "panoptes: explor is no subcommand; did you mean explore?\n");
  said = run({"explore"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "panoptes: MISSION is required; see panoptes explore --help\n");
  said = run({"explore", kOffice, "--seed", "x"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "panoptes: Could not convert: --seed = x; see panoptes explore --help\n");
  said = run({"explore", kOffice, "--seed", "-1"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err,
            "panoptes: --seed: must not be negative, got -1; see panoptes explore --help\n");
}

TEST_F(RunApp, AMissingMissionIsStatus2) {
  const Said said = run({"explore", "nowhere.yaml"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "nowhere.yaml: no such file\n");
}

TEST_F(RunApp, AMissionThatCannotBeReadIsStatus2) {
  const Said said = run({"explore", folder_.string()});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr(": not a file\n"));
}

TEST_F(RunApp, AMissingWorldIsStatus2AndAMissingMeshOrTextureStatus3) {
  const std::string mission = write(folder_ / "m.yaml", mission_with("w.yaml"));
  Said said = run({"explore", mission, "--out", (folder_ / "out").string()});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, mission + ":3:36: platform.world: no such file: " +
                          (folder_ / "w.yaml").string() + "\n");
  const std::string world =
      write(folder_ / "w.yaml", "name: w\nobjects:\n  - {name: desk, mesh: desk.gltf}\n");
  said = run({"explore", mission, "--out", (folder_ / "out").string()});
  EXPECT_EQ(said.status, 3);
  EXPECT_EQ(said.err, world + ":3:24: platform.world.objects[0].mesh: no such file: " +
                          (folder_ / "desk.gltf").string() + "\n");
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(RunApp, OverridesOnNothingAreStatus2) {
  const Said said = run({"explore", kOffice, "--set", "navigator.drivr.carrot_m=1"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err,
            "--set navigator.drivr.carrot_m: navigator.drivr: unknown key; did you mean driver?\n");
}

TEST_F(RunApp, AFolderThatIsNotEmptyIsRefusedBeforeAnythingRuns) {
  write(folder_ / "x", "x");
  const Said said = run({"explore", kOffice, "--out", folder_.string()});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr("is not empty"));
}

TEST_F(RunApp, AFolderThatCannotBeWrittenIsStatus2) {
  const Said said = run({"explore", kOffice, "--out", "/proc/nowhere"});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, StartsWith("/proc/nowhere: "));
}

TEST_F(RunApp, AStartInsideFurnitureIsStatus2) {
  const Said said = run({"check", kOffice});
  EXPECT_EQ(said.status, 0);
  const std::string mission =
      write(folder_ / "m.yaml",
            mission_with(kScenes + "worlds/office.yaml, start: {x_m: 0.1, y_m: 0.1}"));
  const Said refused = run({"check", mission});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.out, StartsWith(mission + ":3:"));
  EXPECT_THAT(refused.out, HasSubstr("platform.start: x_m: 0.100, y_m: 0.100 is inside "));
}

TEST_F(RunApp, CheckKnowsEveryKindOfFile) {
  const std::string route = write(folder_ / "r.yaml", "waypoints: [{x_m: 1, y_m: 2}]\n");
  const std::string robot = write(folder_ / "b.yaml", "radius_m: 0.3\n");
  const std::string rig = kScenes + "rigs/front-back-floor.yaml";
  Said said = run({"check", route, robot, rig});
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(said.out, route + ": ok (route)\n" + robot + ": ok (robot)\n" + rig + ": ok (rig)\n");
  const std::string broken = write(folder_ / "c.yaml", "radius_m: 0.3\nheigth_m: 1\n");
  said = run({"check", robot, broken});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.out, robot + ": ok (robot)\n" + broken +
                          ":2:1: heigth_m: unknown key; did you mean height_m?\n");
  const std::string odd = write(folder_ / "d.yaml", "a: b\n");
  said = run({"check", odd});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.out,
            odd +
                ": cannot tell what this is; a mission has platform:, a world objects:, boxes:, "
                "generate: or floor_plan:, a rig cameras:, a robot radius_m:, a route waypoints: "
                "or tour:, a map image: and occupied_thresh:\n");
}

TEST_F(RunApp, DoctorFindsWhatTheTestsNeed) {
  const Said said = run({"doctor"});
  EXPECT_EQ(said.status, 0) << said.out;
  EXPECT_THAT(said.out, StartsWith("ok      renderer"));
}

}  // namespace
}  // namespace panoptes
