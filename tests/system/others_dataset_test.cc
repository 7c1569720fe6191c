// SPDX-License-Identifier: BSD-3-Clause
// Recordings as other people have them: another clock, another layout, other instants, JPEG.
#include <cmath>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "core/config/geometry_fields.h"
#include "core/io/dataset.h"
#include "core/io/dataset_table.h"
#include "core/io/file.h"
#include "core/io/frame_set_assembly.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::int64_t kEpoch_ns = 1'700'000'000'123'456'789;
const std::map<std::string, std::string> kTheirNames{
    {"front", "cam0"}, {"back", "cam1"}, {"floor", "cam2"}};

// Along the aisle between the desks, back, and along it again, the cameras triggered apart.
const std::vector<std::string> kToAndFro{
    "--set",
    "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}",
    "--set",
    "drive={route: {waypoints: [{x_m: 4.95, y_m: 1.2}, {x_m: 4.95, y_m: 4.0}, "
    "{x_m: 4.95, y_m: 1.2}]}}",
    "--set",
    "platform.clock_error.sigma_s=0",  // the first frame set, at 0, is of front's picture
    "--set",
    "platform.trigger={groups: {a: {cameras: [back], offset_s: 0.007}, b: {cameras: [floor], "
    "offset_s: 0.011}}}",
    "--set",
    "require=[]"};

std::string on_their_clock(Time stamp) {
  return std::to_string(stamp.time_since_epoch().count() + kEpoch_ns);
}

class OthersDataset : public SystemTest {
 protected:
  // Records a drive, and makes of it what somebody else would have kept of it.
  void SetUp() override {
    SystemTest::SetUp();
    std::vector<std::string> words{"record", kOffice, "--quiet", "--out", "live"};
    words.insert(words.end(), kToAndFro.begin(), kToAndFro.end());
    ASSERT_EQ(panoptes(words).status, 0);
    live_ = read_dataset(work() / "live");
    fs::create_directories(theirs() / "mav0" / "odom0");
    write_rig();
    for (const auto& [ours, name] : kTheirNames) {
      write_camera(ours, name);
    }
    write_odometry();
    write_truth();
  }

  fs::path work() const { return folder_ / "work"; }
  fs::path theirs() const { return work() / "theirs"; }

  // What they call the cameras, with the marks that were surveyed.
  void write_rig() const {
    Rig rig;
    for (const auto& [name, camera] : live_.believed.rig->cameras) {
      rig.cameras[kTheirNames.at(name)] = camera;
    }
    write_file(theirs() / "rig.yaml", write_settings(rig));
  }

  void write_camera(const std::string& ours, const std::string& name) const {
    const fs::path folder = theirs() / "mav0" / name;
    fs::create_directories(folder / "data");
    std::string rows = "#timestamp [ns],filename\r\n";
    for (const RecordedObservation& seen : live_.observations) {
      if (!seen.pictures.contains(ours)) {
        continue;
      }
      const RecordedPicture& picture = seen.pictures.at(ours);
      const std::string file = on_their_clock(picture.stamp) + (name == "cam0" ? ".jpeg" : ".jpg");
      cv::imwrite((folder / "data" / file).string(), read_picture(live_, picture),
                  {cv::IMWRITE_JPEG_QUALITY, 95});
      rows += on_their_clock(picture.stamp) + ", " + file + " \r\n";
    }
    write_file(folder / "data.csv", rows);
  }

  // At 50 Hz, 3.7 ms beside the pictures, in a frame of its own.
  void write_odometry() const {
    const Pose2 T_theirs_odom{3, -2, 1};
    std::vector<StampedOdometry> rows;
    for (const RecordedObservation& seen : live_.observations) {
      rows.push_back({seen.stamp, seen.odometry});
    }
    std::string csv = "#timestamp [ns], x [m], y [m], theta [rad], v [m/s], w [rad/s]\r\n";
    for (Time t(std::chrono::microseconds(-16'300)); t <= rows.back().stamp;
         t += std::chrono::milliseconds(20)) {
      const Odometry told = odometry_at(rows, std::max(t, rows.front().stamp));
      const Pose2 T = T_theirs_odom * told.T_odom_body;
      csv += dataset_row(t + Duration(kEpoch_ns), T.x_m, T.y_m, T.theta_rad, told.twist_body.v_mps,
                         told.twist_body.w_radps);
    }
    write_file(theirs() / "mav0/odom0/data.csv", csv);
  }

  // Its 17 columns are those of our own recording.
  void write_truth() const {
    const std::string name = "mav0/state_groundtruth_estimate0/data.csv";
    const std::string text = read_file(work() / "live" / name);
    const DatasetTable rows(name, text, 17);
    std::string csv = text.substr(0, text.find('\n') + 1);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      csv += on_their_clock(rows.stamp(row, 0));
      for (std::size_t column = 1; column < rows.columns(); ++column) {
        csv += "," + rows.text(row, column);
      }
      csv += "\r\n";
    }
    fs::create_directories(theirs() / "mav0/state_groundtruth_estimate0");
    write_file(theirs() / name, csv);
  }

  // `rows` of a table of theirs, counted from 1, are taken out.
  void remove_rows(const std::string& table, std::size_t from, std::size_t to) const {
    std::string text = read_file(theirs() / table);
    std::string left;
    std::size_t line = 0;
    while (!text.empty()) {
      const std::size_t end = text.find('\n') + 1;
      if (line < from || line > to) {
        left += text.substr(0, end);
      }
      ++line;
      text.erase(0, end);
    }
    write_file(theirs() / table, left);
  }

  Dataset live_;
};

TEST_F(OthersDataset, IsMappedAndJudgedAsOurOwnIs) {
  const Said checked = panoptes({"check", "theirs"});
  EXPECT_EQ(checked.status, 0) << checked.out;
  EXPECT_THAT(checked.out, StartsWith("theirs: "));
  EXPECT_THAT(checked.out, HasSubstr("cam0 15.0 pictures a second, 0 missing"));
  EXPECT_THAT(checked.out, testing::EndsWith("theirs: ok (dataset)\n"));
  ASSERT_EQ(explore("live", "ours", {"--set", "drive=navigator"}).status, 0);
  const Said said = explore("theirs", "again", {});
  ASSERT_EQ(said.status, 0) << said.err;
  const json ours = metrics("ours");
  const json again = metrics("again");
  EXPECT_NEAR(again["frames"].get<int>(), ours["frames"].get<int>(), 1);
  EXPECT_EQ(again["mission"], "theirs");
  EXPECT_EQ(again["end_reason"], "end_of_data");
  EXPECT_EQ(again["start_unix_ns"].get<std::int64_t>(), kEpoch_ns);
  ASSERT_TRUE(again.contains("trajectory"));
  ASSERT_TRUE(ours.contains("checkpoints"));
  ASSERT_TRUE(again.contains("checkpoints"));
  // JPEG changes a grey level here and there, interpolation a fraction of a millimetre
  constexpr double kAlike_m = 0.01;
  for (const char* figure : {"error_mean_m", "error_max_m"}) {
    EXPECT_NEAR(again["checkpoints"][figure].get<double>(),
                ours["checkpoints"][figure].get<double>(), kAlike_m);
  }
  for (const char* figure : {"ate_rmse_m", "odometry_ate_rmse_m"}) {
    EXPECT_NEAR(again["trajectory"][figure].get<double>(), ours["trajectory"][figure].get<double>(),
                kAlike_m);
  }
  EXPECT_GE(again["loops"]["correct"], 1);
  EXPECT_EQ(again["loops"]["false"], 0);
  EXPECT_NEAR(again["distance_m"].get<double>() / ours["distance_m"].get<double>(), 1, 0.01);
  for (const char* absent : {"collisions", "min_clearance_m", "exploration"}) {
    EXPECT_FALSE(again.contains(absent)) << absent;
  }
  for (const char* absent : {"coverage", "free_iou", "obstacle_recall", "reachable_m2"}) {
    EXPECT_FALSE(again["map"].contains(absent)) << absent;
  }
}

TEST_F(OthersDataset, AGapInOneCameraIsToldWithItsPlace) {
  remove_rows("mav0/cam2/data.csv", 101, 115);
  const Said said = panoptes({"check", "theirs"});
  EXPECT_EQ(said.status, 1);
  EXPECT_THAT(said.out,
              HasSubstr("theirs/mav0/cam2/data.csv:102: no picture for 1.07 s, from 6.61 to 7.68 "
                        "s: 15 missing, at 15.0 a second\n"));
  EXPECT_THAT(said.out, testing::EndsWith("theirs: has gaps (dataset)\n"));
  EXPECT_THAT(explore("theirs", "again", {}).err, HasSubstr("no picture for 1.07 s"));
}

TEST_F(OthersDataset, WhatCannotBeMappedSaysWhy) {
  const std::string odometry = read_file(theirs() / "mav0/odom0/data.csv");
  fs::remove_all(theirs() / "mav0/odom0");
  for (const char* command : {"check", "explore"}) {
    const Said said = panoptes({command, "theirs"});
    EXPECT_EQ(said.status, 2);
    EXPECT_THAT(said.out + said.err,
                StartsWith("theirs: has pictures of cam0, cam1, cam2 but no mav0/odom0/data.csv"));
    EXPECT_THAT(said.out + said.err, HasSubstr("panoptes loops theirs/mav0/cam0/data finds"));
  }
  fs::create_directories(theirs() / "mav0/odom0");
  write_file(theirs() / "mav0/odom0/data.csv",
             odometry.substr(0, odometry.find('\n', odometry.size() / 3) + 1));
  const Said said = panoptes({"explore", "theirs"});
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr("it must reach from the first to the last, by the same clock"));
}

}  // namespace
}  // namespace panoptes
