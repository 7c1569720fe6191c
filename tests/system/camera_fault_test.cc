// SPDX-License-Identifier: BSD-3-Clause
// Cameras that fail in the middle of a run.
#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "core/io/csv.h"
#include "core/io/tum.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CameraFaults : public SystemTest {
 protected:
  Said explore_with(const std::string& out, const std::string& faults, double duration_s) const {
    return explore(kOffice, out,
                   {"--seed", "3", "--set", "require=[]", "--set", "platform.faults=" + faults,
                    "--set", "navigator.camera_patience_s=2", "--set",
                    "until.duration_s=" + std::to_string(duration_s)});
  }
  std::string why_at(const std::string& out, double at_s) const {
    const CsvTable steps = read_csv(folder_ / "work" / out / "steps.csv");
    for (const auto& row : steps.rows) {
      if (std::stod(row[steps.column("stamp_s")]) >= at_s) {
        return row[steps.column("state")] + ": " + row[steps.column("why")];
      }
    }
    return "";
  }
  // Of the true way from there on.
  double driven_from_m(const std::string& out, double at_s) const {
    double path_m = 0;
    std::optional<Vec3> last;
    for (const TumPose& pose : read_tum(folder_ / "work" / out / "ground_truth.tum")) {
      if (pose.stamp >= time_at(at_s)) {
        path_m += last ? (pose.T_frame_body.translation - *last).norm() : 0;
        last = pose.T_frame_body.translation;
      }
    }
    return path_m;
  }
};

TEST_F(CameraFaults, StopTheRobotAndAreTheOutcome) {
  for (const auto& [fault, state] : std::map<std::string, std::string>{
           {"freeze", "frozen"}, {"cover", "covered"}, {"black", "dark"}, {"unplug", "missing"}}) {
    const Said said = explore_with(fault, "[{camera: floor, fault: " + fault + ", at_s: 9}]", 20);
    EXPECT_EQ(said.status, 3) << fault;
    EXPECT_THAT(said.out, testing::StartsWith("device_lost (camera floor: " + state + ") after "));
    EXPECT_THAT(said.out, HasSubstr("camera floor: lost for "));
    const auto m = metrics(fault);
    EXPECT_EQ(m["outcome"], "device_lost");
    EXPECT_LT(m["run_s"], 12) << "it waits 2 s and ends";
    EXPECT_GE(m["cameras"]["floor"][state], 25);
    EXPECT_GE(m["cameras"]["floor"]["lost_s"], 1.9);
    EXPECT_EQ(m["cameras"]["front"]["lost_s"], 0);
    EXPECT_EQ(m["collisions"], 0);
    EXPECT_EQ(why_at(fault, 9.3), "stopped: camera floor: " + state);
    EXPECT_EQ(driven_from_m(fault, 10), 0) << "at rest within a second";
  }
}

TEST_F(CameraFaults, ThatPassAreWaitedFor) {
  const Said said = explore_with("run", "[{camera: floor, fault: black, at_s: 5, for_s: 1}]", 13);
  EXPECT_EQ(said.status, 0);
  const auto m = metrics("run");
  EXPECT_EQ(m["end_reason"], "duration");
  EXPECT_EQ(m["cameras"]["floor"]["dark"], 15);
  EXPECT_NEAR(m["cameras"]["floor"]["lost_s"], 1, 0.01);
  EXPECT_GT(driven_from_m("run", 6.5), 0.1);
}

TEST_F(CameraFaults, OfALoopCameraAreToldWhileItDrivesOn) {
  const Said said = explore_with("run", "[{camera: front, fault: black, at_s: 6}]", 14);
  EXPECT_EQ(said.status, 3);
  EXPECT_THAT(said.out, HasSubstr("camera front: lost for "));
  EXPECT_THAT(said.out, HasSubstr("no loops could be closed"));
  EXPECT_EQ(metrics("run")["outcome"], "device_lost");
  EXPECT_THAT(why_at("run", 8), HasSubstr("; camera front: dark"));
  EXPECT_GT(driven_from_m("run", 7), 0.3);
  const CsvTable steps = read_csv(folder_ / "work/run/steps.csv");
  int after = 0;
  for (const auto& row : steps.rows) {
    after += std::stod(row[steps.column("stamp_s")]) > 7 && !row[steps.column("keyframe")].empty();
  }
  EXPECT_GE(after, 2) << "keyframes go on";
}

TEST_F(CameraFaults, AFloorCameraThatLosesEveryPictureIsNoCompletedRun) {
  const Said said = explore(kOffice, "run",
                            {"--seed", "3", "--duration", "20", "--set", "require=[]", "--set",
                             "platform.trigger.groups={f: {cameras: [floor], drops: 1}}"});
  EXPECT_EQ(said.status, 3);
  EXPECT_EQ(metrics("run")["outcome"], "device_lost");
  EXPECT_LT(metrics("run")["run_s"], 11);
}

TEST_F(CameraFaults, OfARecordingMapNothing) {
  ASSERT_EQ(
      panoptes({"record", kOffice, "--seed", "3", "--duration", "14", "--quiet", "--out", "drive"})
          .status,
      0);
  const std::vector<std::string> more{"--set", "require=[]", "--set",
                                      "navigator.camera_patience_s=3"};
  EXPECT_EQ(explore("drive", "whole", more).status, 0);
  std::vector<fs::path> pictures;
  for (const auto& entry : fs::directory_iterator(folder_ / "work/drive/mav0/floor/data")) {
    pictures.push_back(entry.path());
  }
  std::sort(pictures.begin(), pictures.end(), [](const fs::path& a, const fs::path& b) {
    return std::stoll(a.stem().string()) < std::stoll(b.stem().string());
  });
  const std::size_t frozen_from = 9 * 15;
  ASSERT_GT(pictures.size(), frozen_from);
  for (std::size_t i = frozen_from; i < pictures.size(); ++i) {
    fs::copy_file(pictures[frozen_from - 1], pictures[i], fs::copy_options::overwrite_existing);
  }
  EXPECT_EQ(explore("drive", "frozen", more).status, 3);
  EXPECT_EQ(metrics("frozen")["outcome"], "device_lost");
  EXPECT_GE(metrics("frozen")["cameras"]["floor"]["frozen"], 40);
  EXPECT_LE(metrics("frozen")["map"]["mapped_free_m2"], metrics("whole")["map"]["mapped_free_m2"]);
}

TEST_F(CameraFaults, NobodySaysExploredInTheDark) {
  const Said said = explore_with("run", "[{fault: black, at_s: 9}]", 20);
  EXPECT_EQ(said.status, 3);
  EXPECT_THAT(said.out, HasSubstr("camera back: dark; camera floor: dark; camera front: dark"));
}

}  // namespace
}  // namespace panoptes
