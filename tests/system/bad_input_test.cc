// SPDX-License-Identifier: BSD-3-Clause
// What the program says, and how it ends, when it cannot begin: one line, before anything moves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

const std::string kOfficeWorld = kScenes + "worlds/office.yaml";
const std::string kRig = kScenes + "rigs/front-back-edges.yaml";

// Lines 1 and 2, platform in line 3, `more` from line 4 on.
std::string mission_of(const std::string& platform, const std::string& more = "") {
  return "rig: " + kRig + "\nrobot: " + kScenes + "robots/pioneer3dx.yaml\nplatform: {" + platform +
         "}\n" + more;
}

std::string in_office(const std::string& more) {
  return mission_of("kind: simulated, world: " + kOfficeWorld, more);
}

class BadInput : public SystemTest {
 protected:
  // Refused with this one line, and nothing is left behind.
  void expect_refused(int status, const std::string& message,
                      const std::vector<std::string>& more = {},
                      const std::string& mission = "m.yaml") {
    SCOPED_TRACE(message);
    const Said said = explore(mission, "out", more);
    EXPECT_EQ(said.status, status);
    EXPECT_EQ(said.err, message + "\n");
    EXPECT_EQ(said.out, "");
    const fs::path out = folder_ / "work" / "out";
    EXPECT_TRUE(!fs::exists(out) || fs::is_empty(out));
  }
};

TEST_F(BadInput, MissionsThatAreNotThere) {
  write("link", "");
  expect_refused(2, "nowhere.yaml: no such file", {}, "nowhere.yaml");
  expect_refused(2, ".: not a file", {}, ".");
}

TEST_F(BadInput, WorldsAndAssetsThatAreNotThere) {
  write("m.yaml", mission_of("kind: simulated, world: w.yaml"));
  expect_refused(2, "m.yaml:3:36: platform.world: no such file: w.yaml");
  fs::create_directories(folder_ / "work" / "w.yaml");
  expect_refused(2, "m.yaml:3:36: platform.world: not a file: w.yaml");
  fs::remove(folder_ / "work" / "w.yaml");

  write("w.yaml", "name: w\nobjects:\n  - {name: room, mesh: room.gltf}\n");
  expect_refused(2, "w.yaml:3:24: platform.world.objects[0].mesh: no such file: room.gltf");
  write("room.gltf", "no mesh");
  expect_refused(2,
                 "w.yaml:3:24: mesh 'room.gltf' cannot be read: No suitable reader found for the "
                 "file format of file \"room.gltf\".; export it again, as glTF or OBJ");

  const std::string before =
      "  - {name: d, mesh: " PANOPTES_SOURCE_DIR "/assets/office/desk.gltf, textures: {top: ";
  const std::string place = "w.yaml:3:" + std::to_string(before.size() + 1) + ": ";
  write("w.yaml", "name: w\nobjects:\n" + before + "t.png}}\n");
  expect_refused(2, place + "platform.world.objects[0].textures.top: no such file: t.png");
  write("t.png", "no picture");
  expect_refused(2, place +
                        "texture 't.png' is not a picture that can be read; save it again as PNG "
                        "or JPEG");
}

TEST_F(BadInput, KeysThatAreWrong) {
  write("m.yaml", in_office("sed: 3\n"));
  expect_refused(2, "m.yaml:4:1: sed: unknown key; did you mean seed?");
  write("m.yaml", in_office("seed: 1\nseed: 2\n"));
  expect_refused(2, "m.yaml:5:1: seed: given twice; the first is in line 4");
  write("m.yaml", in_office("seed: x\n"));
  expect_refused(2, "m.yaml:4:7: seed: must be a whole number, got x");
  write("m.yaml", in_office("until: {duration_s: .nan}\n"));
  expect_refused(2, "m.yaml:4:21: until.duration_s: must be finite, got .nan");
  write("m.yaml", in_office("until: {duration_s: 0}\n"));
  expect_refused(2, "m.yaml:4:21: until.duration_s: must be from 0.001 to 1e+08, got 0");
}

TEST_F(BadInput, SettingsOfNothing) {
  expect_refused(
      2, "--set navigator.drivr.lookahead_m: navigator.drivr: unknown key; did you mean driver?",
      {"--set", "navigator.drivr.lookahead_m=1"}, kOffice);
  expect_refused(2, "--set seed: must be a whole number, got x", {"--set", "seed=x"}, kOffice);
}

TEST_F(BadInput, RigsThatWillNotDo) {
  expect_refused(2,
                 kRig +
                     ":8:1: rig: has no camera with the role loop_front; SLAM in "
                     "'explore-office' needs a camera for loops, whose role begins with loop_, and "
                     "one for the floor",
                 {"--set", "rig.cameras.front.roles=[]", "--set", "rig.cameras.back.roles=[]"},
                 kOffice);
  expect_refused(2,
                 "--set platform.trigger.groups: platform.trigger.groups.slow.cameras: the rig has "
                 "no camera bakc; did you mean back?",
                 {"--set", "platform.trigger.groups={slow: {cameras: [bakc]}}"}, kOffice);
}

TEST_F(BadInput, StartsInsideADesk) {
  write("m.yaml", mission_of("kind: simulated, world: " + kOfficeWorld +
                             ", start: {x_m: 2.1, y_m: 2, theta_deg: 0}"));
  const std::string column = std::to_string(36 + kOfficeWorld.size() + 9);
  expect_refused(2, "m.yaml:3:" + column +
                        ": platform.start: x_m: 2.100, y_m: 2.000 is inside desk-01; move the "
                        "start, or leave it out to have one drawn from the seed");
}

TEST_F(BadInput, StartsThatLookAtADeskInsteadOfFloor) {
  write("m.yaml", mission_of("kind: simulated, world: " + kOfficeWorld +
                             ", start: {x_m: 0.9, y_m: 2, theta_deg: 0}"));
  const std::string column = std::to_string(36 + kOfficeWorld.size() + 9);
  expect_refused(2, "m.yaml:3:" + column +
                        ": platform.start: x_m: 0.900, y_m: 2.000 is 0.385 m from desk-01, but "
                        "0.70 m about the start must be clear, for the robot cannot see the floor "
                        "at its feet and takes it for free; move the start, or leave it out to "
                        "have one drawn from the seed");
  // the same folder will do for another start
  EXPECT_EQ(explore("m.yaml", "out",
                    {"--set", "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}", "--set",
                     "until.keyframes=1"})
                .status,
            0);
}

TEST_F(BadInput, ABodyThatIsWiderThanEveryPassage) {
  const Said said =
      explore(kOffice, "out", {"--seed", "1", "--set", "robot.radius_m=0.55", "--duration", "40"});
  EXPECT_EQ(said.status, 1);
  EXPECT_THAT(said.out, testing::StartsWith("stuck (no way that the robot, 1.10 m wide, has room "
                                            "for leads from where it started) after "));
  EXPECT_EQ(metrics("out")["outcome"], "stuck");
  EXPECT_EQ(metrics("out")["collisions"], 0);
}

TEST_F(BadInput, StartsAmongLegs) {
  write(
      "m.yaml",
      mission_of("kind: simulated, start: {x_m: 0, y_m: 0, theta_deg: 0}, world: {name: legs, "
                 "boxes: [{name: floor, size_m: [6, 6, 0.1], at: {x_m: 0, y_m: 0}, z_m: -0.1}, "
                 "{name: leg, size_m: [0.04, 0.04, 0.7], at: {x_m: 0.4, y_m: 0.4}}, {name: leg-2, "
                 "size_m: [0.04, 0.04, 0.7], at: {x_m: 0.4, y_m: -0.4}}]}"));
  const Said said = explore("m.yaml", "out", {});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, testing::HasSubstr(" m from leg"));
  EXPECT_THAT(said.err, testing::HasSubstr("about the start must be clear"));
}

TEST_F(BadInput, FoldersThatCannotBeWritten) {
  write("out", "a file");
  Said said = explore(kOffice, "out", {});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "out: is not a folder; name another with --out\n");
  said = explore(kOffice, "/proc/nowhere", {});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err,
            "/proc/nowhere: cannot be made: No such file or directory; name another folder with "
            "--out\n");
  said = explore(kOffice, ".", {});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, ".: is not empty; remove it or name another folder with --out\n");
}

}  // namespace
}  // namespace panoptes
