// SPDX-License-Identifier: BSD-3-Clause
// A run that does not know the truth, and what is said of it by who does.
#include <cmath>

#include <gmock/gmock.h>

#include "apps/serve/served_truth.h"
#include "core/io/file.h"
#include "core/io/tum.h"
#include "hw/replay/truth_files.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::int64_t kRun_unix_ns = 1'700'000'000'000'000'000;
constexpr Duration kServedBefore = std::chrono::seconds(40);  // the run began

// Along the aisle between the desks, back, and along it again: places are met both ways round.
const std::vector<std::string> kToAndFro{
    "--set",
    "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}",
    "--set",
    "drive={route: {waypoints: [{x_m: 4.95, y_m: 1.2}, {x_m: 4.95, y_m: 4.0}, "
    "{x_m: 4.95, y_m: 1.2}]}}",
    "--set",
    "require=[\"collisions == 0\", \"loops.false == 0\"]"};

// Equal but for roundoff: angles have been quaternions and degrees on their way.
void expect_near(const json& a, const json& b, const std::string& key) {
  constexpr double kRoundoff = 1e-9;
  if (a.is_object() && b.is_object()) {
    EXPECT_EQ(a.size(), b.size()) << key;
    for (const auto& [name, value] : a.items()) {
      expect_near(value, b.value(name, json()), key + "." + name);
    }
  } else if (a.is_number() && b.is_number()) {
    EXPECT_NEAR(a.get<double>(), b.get<double>(), kRoundoff) << key;
  } else {
    EXPECT_EQ(a, b) << key;
  }
}

TEST_F(SystemTest, ARunIsToldWhatItWouldHaveSaidItself) {
  // with exact clocks: between frame sets the truth is interpolated
  std::vector<std::string> words{
      "record", kOffice, "--quiet", "--out", "live", "--set", "platform.clock_error.sigma_s=0"};
  words.insert(words.end(), kToAndFro.begin(), kToAndFro.end());
  ASSERT_EQ(panoptes(words).status, 0);
  const fs::path work = folder_ / "work";
  const auto recorded = hw::RecordedTruth::read(work / "live");
  ASSERT_TRUE(recorded);
  const Truth truth = recorded->after(recorded->observations());

  // what EuRoC's columns hold of the truth tells the same of the way, and nothing of the walls
  fs::remove_all(work / "live" / "mav0" / "truth0");
  ASSERT_EQ(explore("live", "tracked", {}).status, 1);  // nothing is known of collisions
  for (const char* key : {"T_scene_map", "trajectory", "checkpoints", "loops"}) {
    expect_near(metrics("live").value(key, json()), metrics("tracked").value(key, json()), key);
  }
  for (const char* key : {"collisions", "min_clearance_m"}) {
    EXPECT_FALSE(metrics("tracked").contains(key)) << key;
  }
  EXPECT_FALSE(metrics("tracked")["map"].contains("coverage"));
  constexpr double kCornersCut = 0.01;  // between frame sets
  EXPECT_NEAR(
      metrics("live")["distance_m"].get<double>() / metrics("tracked")["distance_m"].get<double>(),
      1, kCornersCut);

  // driven again by a robot that has no truth, as the served one saw it
  fs::remove_all(work / "live" / "mav0" / "state_groundtruth_estimate0");
  ASSERT_EQ(explore("live", "blind", {}).status, 1);  // nothing is known of collisions
  json blind = metrics("blind");
  EXPECT_FALSE(blind.contains("trajectory"));
  blind["start_unix_ns"] = kRun_unix_ns;
  write_file(work / "blind" / "metrics.json", blind.dump());
  Truth served = truth;
  for (TruePose& pose : served.poses) {
    pose.stamp += kServedBefore;
  }
  for (TrueContact& contact : served.contacts) {
    contact.stamp += kServedBefore;
  }
  fs::create_directories(work / "served");
  ServedTruthWriter(work / "served", kRun_unix_ns - kServedBefore.count(), served);

  const Said said = panoptes({"evaluate", "blind", "--truth", "served"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_THAT(said.out, testing::HasSubstr("\n0 collisions, "));
  const json told = metrics("blind");
  const json live = metrics("live");
  EXPECT_GE(live["loops"]["accepted"], 1);
  for (const char* key : {"T_scene_map", "collisions", "collisions_while_stopped",
                          "min_clearance_m", "stuck_s", "trajectory", "checkpoints", "loops"}) {
    expect_near(live.value(key, json()), told.value(key, json()), key);
  }
  for (const char* key : {"cell_m", "radius_m", "reachable_m2", "mapped_free_m2", "coverage"}) {
    expect_near(live["map"][key], told["map"][key], key);
  }
  EXPECT_NEAR(live["distance_m"].get<double>() / told["distance_m"].get<double>(), 1, kCornersCut);
  EXPECT_EQ(read_tum(work / "blind" / "ground_truth.tum").size(),
            read_tum(work / "live" / "ground_truth.tum").size());

  // somebody else has tracked the robot, and knows the world
  std::vector<TumPose> tracked;
  for (const TruePose& pose : truth.poses) {
    tracked.push_back({pose.stamp + Duration(kRun_unix_ns), on_floor(pose.T_scene_body)});
  }
  write_tum(work / "tracked.tum", tracked);
  EXPECT_EQ(panoptes({"evaluate", "blind", "--truth", "tracked.tum", "--world",
                      kScenes + "worlds/office.yaml"})
                .status,
            1);  // nor does a trajectory know of collisions
  expect_near(told["map"], metrics("blind")["map"], "map");
  expect_near(told["trajectory"], metrics("blind")["trajectory"], "trajectory");
  EXPECT_FALSE(metrics("blind").contains("collisions"));
  const Said twice = panoptes(
      {"evaluate", "blind", "--truth", "served", "--world", kScenes + "worlds/office.yaml"});
  EXPECT_EQ(twice.status, 2);
  EXPECT_EQ(twice.err, "--world: served holds its world; leave --world out\n");
}

}  // namespace
}  // namespace panoptes
