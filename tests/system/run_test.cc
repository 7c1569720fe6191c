// SPDX-License-Identifier: BSD-3-Clause
// Whole runs: the same again, ended early, without room on the disk, driven by others.
#include <csignal>

#include <gmock/gmock.h>

#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/io/graph_file.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::StartsWith;

class Runs : public SystemTest {
 protected:
  void expect_same(const std::string& a, const std::string& b) const {
    const auto files_a = comparable(folder_ / "work" / a);
    const auto files_b = comparable(folder_ / "work" / b);
    EXPECT_GE(files_a.size(), 14U);
    EXPECT_EQ(files_a.size(), files_b.size());
    for (const auto& [name, text] : files_a) {
      ASSERT_TRUE(files_b.contains(name)) << name;
      EXPECT_TRUE(files_b.at(name) == text) << name << " differs";
    }
  }
};

const std::vector<std::string> kShort{"--seed", "3", "--duration", "12", "--set", "require=[]"};

// Along the aisle between the desks, back, and along it again: places are met both ways round.
const std::string kRoute =
    "drive={route: {waypoints: [{x_m: 4.95, y_m: 1.2}, {x_m: 4.95, y_m: 4.0}, "
    "{x_m: 4.95, y_m: 1.2}]}}";
const std::vector<std::string> kToAndFro{
    "--set", "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}", "--set", kRoute,
    "--set", "require=[\"collisions == 0\", \"loops.false == 0\"]"};

TEST_F(Runs, OneSeedGivesTheSameBytesTwice) {
  EXPECT_EQ(explore(kOffice, "a", kShort).status, 0);
  EXPECT_EQ(explore(kOffice, "b", kShort).status, 0);
  expect_same("a", "b");
  EXPECT_GE(metrics("a")["keyframes"], 10);
  EXPECT_GT(metrics("a")["distance_m"], 0.3);
  EXPECT_EQ(metrics("a")["frames"], 181);  // at 15 Hz, the first at 0 and the last at 12 s
  EXPECT_EQ(metrics("a")["collisions"], 0);
}

TEST_F(Runs, AnotherSeedIsAnotherRun) {
  EXPECT_EQ(explore(kOffice, "a", {"--seed", "1", "--set", "until.keyframes=1"}).status, 1);
  EXPECT_EQ(explore(kOffice, "b", {"--seed", "2", "--set", "until.keyframes=1"}).status, 1);
  EXPECT_NE(metrics("a")["T_scene_map"], metrics("b")["T_scene_map"]);
}

TEST_F(Runs, RenderingThreadsDoNotChangeAByte) {
  const auto with_threads = [](const std::string& count) {
    std::vector<std::string> arguments = kToAndFro;
    arguments.insert(arguments.end(), {"--threads", count});
    return arguments;
  };
  EXPECT_EQ(explore(kOffice, "a", with_threads("1")).status, 0);
  EXPECT_EQ(explore(kOffice, "b", with_threads("3")).status, 0);
  expect_same("a", "b");
}

TEST_F(Runs, TheMissionOfARunRepeatsIt) {
  EXPECT_EQ(explore(kOffice, "a",
                    {"--seed", "4", "--duration", "8", "--set", "require=[]", "--set",
                     "navigator.driver.dwa.margin_s=0.2"})
                .status,
            0);
  EXPECT_EQ(explore("a/mission.yaml", "b", {}).status, 0);
  expect_same("a", "b");
}

TEST_F(Runs, AreReadByWhatOthersWrote) {
  EXPECT_EQ(explore(kOffice, "a", kShort).status, 0);
  const fs::path run = folder_ / "work" / "a";
  const auto keyframes = metrics("a")["keyframes"].get<std::size_t>();
  EXPECT_EQ(read_tum(run / "keyframes.tum").size(), keyframes);
  EXPECT_EQ(read_tum(run / "trajectory.tum").size(), read_csv(run / "steps.csv").rows.size());
  EXPECT_EQ(read_tum(run / "odometry.tum").size(), read_csv(run / "steps.csv").rows.size());
  EXPECT_EQ(read_graph(run / "graph.g2o").graph.T_map_node.size(), keyframes);
  EXPECT_NEAR(read_map_server(run / "map.yaml").area_m2(Cell::kFree),
              metrics("a")["map"]["mapped_free_m2"],
              1e-6);  // the same cells, each 1e-4
}

TEST_F(Runs, EndWithTheirMapWhenTheUserAsks) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const std::string out = "run-" + std::to_string(signal);
    const Said said = explore(kOffice, out, {}, {{}, {}, signal, out + "/mission.yaml"});
    EXPECT_EQ(said.status, 130);
    EXPECT_THAT(said.out, StartsWith("interrupted after "));
    EXPECT_EQ(metrics(out)["outcome"], "interrupted");
    EXPECT_GE(metrics(out)["frames"], 1);
    EXPECT_TRUE(fs::exists(folder_ / "work" / out / "rig_refined.yaml"));
    EXPECT_GT(read_map_server(folder_ / "work" / out / "map.yaml").area_m2(Cell::kFree), 0);
  }
}

TEST_F(Runs, EndInOrderWhenTheUserAsksBeforeTheRobotIsThere) {
  const Said said = explore(kOffice, "run", {}, {{}, {}, SIGINT, "run"});
  EXPECT_EQ(said.status, 130);
  EXPECT_EQ(metrics("run")["outcome"], "interrupted");
}

TEST_F(Runs, LeaveNothingHalfWrittenOnAFullDisk) {
  constexpr std::uint64_t kRoom_bytes = 50'000;  // for tables, not for the map
  const Said said = explore(kOffice, "run", {"--duration", "2"}, {{}, kRoom_bytes, 0, {}});
  EXPECT_EQ(said.status, 3);
  EXPECT_THAT(said.err, StartsWith("run/map.pgm: cannot be written: File too large\n"));
  EXPECT_EQ(metrics("run")["outcome"], "failed");
  EXPECT_EQ(metrics("run")["fault"].get<std::string>() + "\n", said.err);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_ / "work" / "run")) {
    names.push_back(entry.path().filename());
  }
  for (const char* small : {"mission.yaml", "steps.csv", "trajectory.tum", "odometry.tum",
                            "ground_truth.tum", "graph.g2o", "loops.csv", "exploration.csv"}) {
    EXPECT_THAT(names, testing::Contains(small));
  }
  for (const std::string& name : names) {
    EXPECT_FALSE(name.ends_with(".part")) << name;
  }
}

TEST_F(Runs, TellThatNobodyCouldHearThem) {
  Fate fate;
  fate.out = "/dev/full";
  const Said said = explore(kOffice, "run", {"--duration", "1", "--set", "require=[]"}, fate);
  EXPECT_EQ(said.status, 3);
  EXPECT_EQ(said.err, "stdout: cannot be written: No space left on device\n");
  EXPECT_EQ(metrics("run")["outcome"], "completed");
  EXPECT_EQ(panoptes({"--help"}, fate).status, 3);
}

TEST_F(Runs, NobodyDrives) {
  EXPECT_EQ(
      explore(kOffice, "run", {"--duration", "8", "--set", "drive=none", "--set", "require=[]"})
          .status,
      0);
  const auto m = metrics("run");
  EXPECT_EQ(m["end_reason"], "duration");
  EXPECT_LT(m["distance_m"], 0.001);  // nothing moves it
  EXPECT_EQ(m["keyframes"], 1);
  EXPECT_EQ(m["stuck_s"], 0);
  const CsvTable steps = read_csv(folder_ / "work/run/steps.csv");
  EXPECT_EQ(steps.rows.back()[steps.column("why")], "nobody drives");
}

TEST_F(Runs, FollowARouteToItsEnd) {
  EXPECT_EQ(explore(kOffice, "run", kToAndFro).status, 0);
  const auto m = metrics("run");
  EXPECT_EQ(m["end_reason"], "goals_done");
  EXPECT_NEAR(m["distance_m"], 3 * 2.8, 0.4);  // waypoints are passed within the follower's reach
  EXPECT_LT(m["run_s"], 60);
  EXPECT_GT(m["min_clearance_m"], 0.1);
  EXPECT_GE(m["loops"]["correct"], 1);
  EXPECT_GT(m["map"]["free_precision"], 0.9);
  EXPECT_LT(m["trajectory"]["ate_rmse_m"], 0.1);
}

}  // namespace
}  // namespace panoptes
