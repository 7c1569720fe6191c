// SPDX-License-Identifier: BSD-3-Clause
// The calibration motions, driven by the wheels through the program itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/file.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

using testing::HasSubstr;

class DrivePrograms : public SystemTest {
 protected:
  // A hall with a crate, and one small camera: a minute and a half takes two seconds.
  void hall(const std::string& drive, const std::string& events = "[]") const {
    write("hall.yaml",
          "ambient: 0.7\nboxes:\n"
          "  - {name: floor, size_m: [6, 6, 0.1], at: {x_m: 3, y_m: 3}, z_m: -0.1, "
          "picture: data:office/carpet_sand.png, picture_m: [2, 2]}\n"
          "  - {name: crate, size_m: [0.3, 0.3, 0.5], at: {x_m: 4, y_m: 1}, movable: true}\n"
          "events: " +
              events + "\n");
    write("m.yaml",
          "rig: {cameras: {ahead: {size_px: [64, 48], fov_deg: 80, at_m: [0.1, 0, 0.7]}}}\n"
          "platform: {kind: simulated, world: hall.yaml, start: {x_m: 3, y_m: 3}}\n"
          "drive: " +
              drive + "\n");
  }
};

TEST_F(DrivePrograms, ARoseIsDrivenToItsEndAndAgainOnItsRecording) {
  hall("{program: rose}");
  const Said recorded = panoptes({"record", "m.yaml", "--quiet", "--out", "rose"});
  ASSERT_EQ(recorded.status, 0) << recorded.err;
  EXPECT_THAT(recorded.out, HasSubstr("wheels: "));
  const auto m = metrics("rose");
  EXPECT_EQ(m["outcome"], "completed");
  EXPECT_FALSE(m.contains("warnings"));
  EXPECT_EQ(m["collisions"], 0);
  EXPECT_NEAR(m["distance_m"].get<double>(), 11 * 2 * 0.5, 0.1);
  EXPECT_LT(m["odometry"]["error_percent"].get<double>(), 1.5);
  EXPECT_LT(m["run_s"].get<double>(), 90);
  EXPECT_THAT(read_file((folder_ / "work" / "rose" / "steps.csv").string()),
              HasSubstr("segment 32 of 32: back 0.50 m"));
  // On a recording its commands go nowhere, and they are the same.
  const Said again = panoptes({"record", "rose", "--quiet", "--out", "again"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_FALSE(metrics("again").contains("replay"));
  EXPECT_EQ(metrics("again")["distance_m"], m["distance_m"]);
  const Said other =
      panoptes({"record", "rose", "--quiet", "--out", "other", "--set", "drive.program=sawtooth"});
  ASSERT_EQ(other.status, 0) << other.err;
  EXPECT_TRUE(metrics("other").contains("replay"));
}

TEST_F(DrivePrograms, ARunThatEndsBeforeItsProgramSaysSo) {
  hall("{program: rose}");
  const Said said = panoptes({"record", "m.yaml", "--quiet", "--duration", "10", "--out", "part"});
  ASSERT_EQ(said.status, 0) << said.err;
  const std::string warning = "the program was not finished: the run ended in segment ";
  EXPECT_THAT(said.out, HasSubstr(warning));
  EXPECT_EQ(metrics("part")["end_reason"], "duration");
  EXPECT_THAT(metrics("part")["warnings"].at(0).get<std::string>(), HasSubstr(warning));
}

TEST_F(DrivePrograms, ATouchEndsItWithTheSegmentsName) {
  hall("{program: legs_and_turns}", "[{at_s: 0.5, over_s: 2, move: crate, to: {x_m: 4, y_m: 3}}]");
  const Said said = panoptes({"record", "m.yaml", "--quiet", "--out", "legs"});
  EXPECT_EQ(said.status, 1);
  EXPECT_EQ(metrics("legs")["outcome"], "collision");
  EXPECT_THAT(said.out, HasSubstr("collision (touched something in segment 1 of 27: ahead 1.00 m, "
                                  "0.6"));
  EXPECT_THAT(said.out, HasSubstr("m from where that began; see that the program has clear floor "
                                  "for 1.35 m ahead of where the robot starts"));
}

TEST_F(DrivePrograms, AStartWithoutRoomIsRefusedBeforeAnythingIsWritten) {
  hall("{program: {kind: rose, petal_m: 3.2}}");
  const Said said = panoptes({"record", "m.yaml", "--quiet", "--out", "rose"});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr("m.yaml:2:54: platform.start: x_m: 3.000, y_m: 3.000 has no room "
                                  "for what drive: program is to do, which needs clear floor for "
                                  "3.55 m ahead of where the robot starts"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work" / "rose"));
}

}  // namespace
}  // namespace panoptes
