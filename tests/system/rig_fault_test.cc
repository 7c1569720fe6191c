// SPDX-License-Identifier: BSD-3-Clause
// Rig files that are wrong in kind, and a floor camera that is knocked: named soon, and no map is
// called good.
#include <string>

#include <gmock/gmock.h>

#include "tests/system/program.h"

namespace panoptes {
namespace {

using ::testing::HasSubstr;

class RigFaults : public SystemTest {
 protected:
  void expect_named(const std::string& error, const std::string& fault) {
    SCOPED_TRACE(error);
    const Said said = explore(
        kOffice, fault,
        {"--seed", "3", "--duration", "60", "--set", "require=[]", "--set", "platform." + error});
    EXPECT_EQ(said.status, 1);
    EXPECT_THAT(said.out, ::testing::StartsWith("failed (" + fault));
    EXPECT_EQ(metrics(fault)["outcome"], "failed");
    EXPECT_LT(metrics(fault)["run_s"], 60);
    EXPECT_EQ(metrics(fault)["collisions"], 0);
  }
};

TEST_F(RigFaults, StopTheRobotAndAreTheOutcome) {
  expect_named("mounting_error={exactly: {front: {yaw_deg: 180}, back: {yaw_deg: 180}}}",
               "front and back look swapped");
  expect_named("mounting_error={exactly: {back: {roll_deg: 180}}}",
               "back looks mirrored or upside down");
  expect_named("lens_error={exactly: {front: {focal_percent: 25}}}",
               "the field of view of front looks wrong");
  expect_named("clock_error={exactly: {back: 0.5}}", "the stamps of back look 0.50 s late");
  expect_named("clock_error={exactly: {front: -0.5}}", "the stamps of front look 0.50 s early");
  expect_named("mounting_error={exactly: {back: {y_m: 0.25}}}", "back looks mounted ");
}

TEST_F(RigFaults, AFloorCameraThatIsKnockedStopsTheRobot) {
  const Said said =
      explore(kScenes + "missions/loops-home.yaml", "knocked",
              {"--seed", "3", "--duration", "90", "--set",
               "platform.faults=[{camera: floor, fault: knock, at_s: 45, pitch_deg: 1.5}]"});
  EXPECT_EQ(said.status, 1);
  EXPECT_THAT(said.out, ::testing::StartsWith("failed (floor was knocked"));
  EXPECT_GT(metrics("knocked")["run_s"], 45);
  EXPECT_LT(metrics("knocked")["run_s"], 60);
}

}  // namespace
}  // namespace panoptes
