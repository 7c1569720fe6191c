// SPDX-License-Identifier: BSD-3-Clause
#include "apps/serve/served_truth.h"

#include <limits>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/io/file.h"
#include "core/io/map_server.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

constexpr double kRoundoff_rad = 1e-12;
constexpr std::int64_t kStart_unix_ns = 1'700'000'000'123'456'789;

Truth world() {
  Truth truth;
  truth.floor = {0.01, {-0.5, 0.25}, 3, 2, {1, 0, 0, 0, 0, 1}};
  truth.body = {0.02, {-1, -1}, 2, 2, {0, 1, 1, 0}};
  truth.wheels = {0.098, 0.1 - 0.1 / 3, 1.0 / 3};
  return truth;
}

Truth news(int from, int to) {
  Truth truth;
  for (int i = from; i < to; ++i) {
    TruePose pose;
    pose.stamp = time_at(i / 15.0);
    pose.T_scene_body = {0.1 * i, 1.0 / 3, 0.4 * i - 3};
    pose.clearance_m = 0.7 - 0.01 * i;
    truth.poses.push_back(pose);
  }
  return truth;
}

class ServedTruthFiles : public ScratchTest {
 protected:
  ServedTruthFiles() : contact_{time_at(0.31), {0.125, -2}, "a chair, \"red\"", true} {}

  void write() {
    ServedTruthWriter writer(folder_, kStart_unix_ns, world());
    writer.add(news(0, 5));
    Truth more = news(5, 10);
    more.contacts = {contact_, {time_at(0.5), {1, 2}, "walker", false}};
    writer.add(more);
    EXPECT_EQ(writer.poses(), 10U);
    EXPECT_EQ(writer.contacts(), 2U);
  }
  void cut(const char* name, std::size_t bytes) {
    fs::resize_file(folder_ / name, fs::file_size(folder_ / name) - bytes);
  }
  void replace(const char* name, const std::string& what, const std::string& by) {
    std::string text = read_file(folder_ / name);
    ASSERT_NE(text.find(what), std::string::npos);
    text.replace(text.find(what), what.size(), by);
    write_file(folder_ / name, text);
  }
  std::string fault() {
    try {
      read_served_truth(folder_);
    } catch (const ConfigError& error) {
      return std::string(error.what()).substr(folder_.string().size() + 1);
    }
    return "no error";
  }

  TrueContact contact_;
};

TEST_F(ServedTruthFiles, ReadBackAsTheyWereWritten) {
  write();
  const ServedTruth served = read_served_truth(folder_);
  EXPECT_EQ(served.start_unix_ns, kStart_unix_ns);
  const Truth all = news(0, 10);
  ASSERT_EQ(served.truth.poses.size(), all.poses.size());
  for (std::size_t i = 0; i < all.poses.size(); ++i) {
    const TruePose& pose = served.truth.poses[i];
    EXPECT_EQ(pose.stamp, all.poses[i].stamp);
    EXPECT_EQ(pose.T_scene_body.position(), all.poses[i].T_scene_body.position());
    EXPECT_NEAR(wrap_angle(pose.T_scene_body.theta_rad - all.poses[i].T_scene_body.theta_rad), 0,
                kRoundoff_rad);
    EXPECT_EQ(pose.clearance_m, all.poses[i].clearance_m);
  }
  EXPECT_NEAR(served.truth.path_m, 0.9, kRoundoff_rad);
  ASSERT_EQ(served.truth.contacts.size(), 2U);
  EXPECT_EQ(served.truth.contacts[0].stamp, contact_.stamp);
  EXPECT_EQ(served.truth.contacts[0].p_scene, contact_.p_scene);
  EXPECT_EQ(served.truth.contacts[0].object, contact_.object);
  EXPECT_TRUE(served.truth.contacts[0].while_moving);
  EXPECT_FALSE(served.truth.contacts[1].while_moving);
  for (const auto& [read, written] :
       {std::pair(served.truth.floor, world().floor), std::pair(served.truth.body, world().body)}) {
    EXPECT_EQ(read.cell_m, written.cell_m);
    EXPECT_EQ(read.origin, written.origin);
    EXPECT_EQ(read.columns, written.columns);
    EXPECT_EQ(read.rows, written.rows);
    EXPECT_EQ(read.cells, written.cells);
  }
  EXPECT_TRUE(served.truth.seen.cells.empty());
  EXPECT_FALSE(served.truth.rig.has_value());
  EXPECT_EQ(served.truth.wheels->right_radius_m, 0.1 - 0.1 / 3);
  EXPECT_EQ(served.truth.wheels->base_m, 1.0 / 3);
  fs::remove(folder_ / "true_platform.yaml");  // as of who served before
  EXPECT_FALSE(read_served_truth(folder_).truth.wheels.has_value());
}

TEST_F(ServedTruthFiles, AreReadByOthers) {
  write();
  EXPECT_EQ(read_file(folder_ / "contacts.csv"),
            "stamp_s,x_m,y_m,object,while_moving\n"
            "0.31,0.125,-2,\"a chair, \"\"red\"\"\",1\n0.5,1,2,walker,0\n");
  EXPECT_TRUE(read_file(folder_ / "clearance.csv").starts_with("stamp_s,clearance_m\n0,0.7\n"));
  EXPECT_EQ(read_map_server(folder_ / "body.yaml").cells,
            (std::vector<Cell>{Cell::kFree, Cell::kOccupied, Cell::kOccupied, Cell::kFree}));
}

TEST_F(ServedTruthFiles, KeepWhatWasTrueBeforeAnybodyWasServed) {
  Truth first = world();
  first.poses = news(0, 2).poses;
  const ServedTruthWriter writer(folder_, kStart_unix_ns, first);
  EXPECT_EQ(writer.poses(), 2U);
  EXPECT_EQ(read_served_truth(folder_).truth.poses.size(), 2U);
}

TEST_F(ServedTruthFiles, OfAWorldWithoutAThing) {
  ServedTruthWriter writer(folder_, kStart_unix_ns, {});
  Truth truth = news(0, 1);
  truth.poses[0].clearance_m = std::numeric_limits<double>::infinity();
  writer.add(truth);
  const Truth back = read_served_truth(folder_).truth;
  EXPECT_EQ(back.poses.at(0).clearance_m, std::numeric_limits<double>::infinity());
  EXPECT_TRUE(back.body.cells.empty());
}

TEST_F(ServedTruthFiles, AreGoodUpToWhereTheyWereCutShort) {
  write();
  cut("ground_truth.tum", 1);  // only the end of the line: its last number may be cut short
  EXPECT_EQ(read_served_truth(folder_).truth.poses.size(), 9U);
  cut("clearance.csv",
      read_file(folder_ / "clearance.csv").size() - 42);  // all but its first row and some
  EXPECT_EQ(read_served_truth(folder_).truth.poses.size(), 1U);
  cut("contacts.csv", 3);
  EXPECT_EQ(read_served_truth(folder_).truth.contacts.size(), 1U);
  write_file(folder_ / "contacts.csv", "stamp_s,x");
  write_file(folder_ / "ground_truth.tum", "");
  const ServedTruth nothing = read_served_truth(folder_);
  EXPECT_TRUE(nothing.truth.poses.empty());
  EXPECT_TRUE(nothing.truth.contacts.empty());
  EXPECT_EQ(nothing.truth.path_m, 0);
}

TEST_F(ServedTruthFiles, SayWhereTheyAreWrong) {
  write();
  replace("contacts.csv", "0.125", "left");
  EXPECT_EQ(fault(), "contacts.csv:2: x_m must be a number, got 'left'");
  replace("contacts.csv", "stamp_s", "stamp");
  EXPECT_EQ(fault(), "contacts.csv:1: must be stamp_s,x_m,y_m,object,while_moving");
  replace("clearance.csv", "\n0,", "\n0.01,");
  EXPECT_EQ(fault(), "clearance.csv:2: stamp_s must be 0, as in ground_truth.tum, got 0.01");
  replace("ground_truth.tum", "\n0.2 ", "\n0.1 ");
  EXPECT_EQ(fault(), "ground_truth.tum:4: the stamp is not later than the one before, 0.133333333");
  fs::remove(folder_ / "ground_truth.tum");
  EXPECT_THAT(fault(), testing::StartsWith("ground_truth.tum: cannot be opened: "));
  write_file(folder_ / "metrics.json", "{\"command\": \"serve\"}");
  EXPECT_EQ(fault(), "metrics.json: start_unix_ns: missing; it must be the wall instant of time 0");
  write_file(folder_ / "metrics.json", "{");
  EXPECT_THAT(fault(), testing::StartsWith("metrics.json: "));
}

}  // namespace
}  // namespace panoptes
