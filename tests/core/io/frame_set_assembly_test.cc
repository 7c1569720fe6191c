// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/frame_set_assembly.h"

#include <optional>
#include <string>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/io/dataset_gaps.h"
#include "core/io/dataset_table.h"
#include "core/io/euroc_truth.h"

namespace panoptes {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<RecordedPicture> pictures_at(const std::vector<int>& ms) {
  std::vector<RecordedPicture> pictures;
  for (const int t : ms) {
    pictures.push_back({Time(milliseconds(t)), std::to_string(t), "csv:1"});
  }
  return pictures;
}

// The files of each set, in the order of the cameras' names.
std::vector<std::string> files_of(const std::vector<RecordedObservation>& sets) {
  std::vector<std::string> all;
  for (const RecordedObservation& set : sets) {
    std::string files;
    for (const auto& [name, picture] : set.pictures) {
      files += (files.empty() ? "" : " ") + name + picture.file;
    }
    all.push_back(files);
  }
  return all;
}

TEST(FrameSetAssembly, TakesTheNearestPictureOfEveryCamera) {
  const auto sets = assemble_frame_sets({{"a", pictures_at({0, 100, 200, 300})},
                                         {"b", pictures_at({-20, 80, 181, 279})},
                                         {"c", pictures_at({30, 230})}});
  EXPECT_THAT(files_of(sets),
              ElementsAre("a0 b-20 c30", "a100 b80", "a200 b181 c230", "a300 b279"));
  EXPECT_EQ(sets[0].stamp, Time());
  EXPECT_EQ(sets[0].now, Time(milliseconds(30)));
  EXPECT_EQ(sets[1].now, Time(milliseconds(100)));
}

TEST(FrameSetAssembly, LosesNoPictureWhereTheFastestCameraLacksOne) {
  const auto sets = assemble_frame_sets({{"a", pictures_at({0, 100, 400, 500})},
                                         {"b", pictures_at({5, 105, 205, 305, 405})},
                                         {"c", pictures_at({10, 210, 410})}});
  EXPECT_THAT(files_of(sets),
              ElementsAre("a0 b5 c10", "a100 b105", "b205 c210", "b305", "a400 b405 c410", "a500"));
}

TEST(FrameSetAssembly, OneSetTakesOnePictureOfACamera) {
  const auto sets =
      assemble_frame_sets({{"a", pictures_at({0, 100, 200})}, {"b", pictures_at({60, 95, 240})}});
  EXPECT_THAT(files_of(sets), ElementsAre("a0", "b60", "a100 b95", "a200 b240"));
}

TEST(FrameSetAssembly, OdometryLiesOnTheArcBetweenRows) {
  const Twist2 twist{0.5, 0.8};
  const Pose2 T_odom_from{1, 2, 3};
  const std::vector<StampedOdometry> rows{
      {Time(), {T_odom_from, twist}},
      {Time(milliseconds(20)), {T_odom_from * exp_twist(twist, 0.02), {0.7, 0.8}}}};
  const Odometry between = odometry_at(rows, Time(milliseconds(5)));
  const Pose2 driven = T_odom_from * exp_twist(twist, 0.005);
  constexpr double kRoundoff = 1e-12;
  EXPECT_NEAR((between.T_odom_body.position() - driven.position()).norm(), 0, kRoundoff);
  EXPECT_NEAR(wrap_angle(between.T_odom_body.theta_rad - driven.theta_rad), 0, kRoundoff);
  EXPECT_NEAR(between.twist_body.v_mps, 0.55, kRoundoff);
}

TEST(FrameSetAssembly, OfARecordingThatWasCutShortTheLastRowIsLeftOut) {
  const std::string table =
      "#timestamp [ns],x [m],y [m],theta [rad],v [m/s],w [rad/s]\n0,0,0,0,0,0\n"
      "100000000,0.01,0,0,0.1,0\n200000000,0.02,0";
  const auto text = [&table](const std::string&) { return std::optional(table); };
  const auto rows = recorded_odometry("run", text, TableBy::kPanoptes);
  ASSERT_THAT(rows, SizeIs(2));
  EXPECT_EQ(rows[1].odometry.T_odom_body.x_m, 0.01);
  EXPECT_THROW(recorded_odometry("run", text, TableBy::kOthers), ConfigError);
  const auto none = [](const std::string&) { return std::optional<std::string>(); };
  EXPECT_THROW(recorded_odometry("run", none, TableBy::kPanoptes), ConfigError);
}

TEST(FrameSetAssembly, VelocitiesFollowFromTheMotion) {
  std::vector<StampedOdometry> rows;
  const Twist2 twist{0.5, -0.8};
  for (int i = 0; i < 50; ++i) {
    rows.push_back({Time(milliseconds(20 * i)), {exp_twist(twist, 0.02 * i), {}}});
  }
  add_velocities(rows);
  for (const StampedOdometry& row : rows) {
    EXPECT_NEAR(row.odometry.twist_body.v_mps, twist.v_mps, 1e-3);  // chord for arc
    EXPECT_NEAR(row.odometry.twist_body.w_radps, twist.w_radps, 1e-9);
  }
}

// A dataset of two cameras that take a picture every 100 ms from 1.7e18 ns on, as text.
class TheirText {
 public:
  explicit TheirText(std::string odometry) {
    files_["mav0/odom0/data.csv"] = std::move(odometry);
    for (const std::string camera : {"cam0", "cam1"}) {
      std::string rows = "#timestamp [ns],filename\r\n";
      for (int i = 0; i < 10; ++i) {
        const std::string name = stamp(100 * i + (camera == "cam1" ? 8 : 0));
        rows += name + "," + name + ".png\r\n";
      }
      files_["mav0/" + camera + "/data.csv"] = rows.substr(0, rows.size() - 2);  // no end of line
    }
  }
  static std::string stamp(int ms) {
    return std::to_string(1'700'000'000'000'000'000 + 1'000'000LL * ms);
  }
  std::string& operator[](const std::string& file) { return files_[file]; }

  DatasetText text() const {
    return [files = files_](const std::string& file) {
      const auto found = files.find(file);
      return found == files.end() ? std::nullopt : std::optional(found->second);
    };
  }
  Dataset read() const { return parse_dataset("d", {"cam0", "cam1"}, text()); }

  std::string fault() const {
    try {
      read();
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "none";
  }

 private:
  std::map<std::string, std::string> files_;
};

// 0.5 m/s straight ahead in a frame of its own, every 20 ms from one instant to another.
std::string straight_odometry(int from_ms, int to_ms, const std::string& more = "") {
  std::string rows = "\xef\xbb\xbf#timestamp [ns], x [m], y [m], theta [rad]\r\n";
  for (int ms = from_ms; ms <= to_ms; ms += 20) {
    rows += TheirText::stamp(ms) + ", 7, " + std::to_string(0.5e-3 * ms) + ", 1.5707963267948966" +
            more + " \r\n";
  }
  return rows;
}

TEST(OthersDataset, BeginsWithItsFirstFrameSet) {
  const TheirText theirs(straight_odometry(-7, 953));
  const Dataset dataset = theirs.read();
  EXPECT_FALSE(dataset.ours);
  EXPECT_EQ(start_unix_ns(dataset), 1'700'000'000'000'000'000);
  EXPECT_THAT(dataset.warnings, IsEmpty());
  ASSERT_THAT(dataset.observations, SizeIs(10));
  for (int i = 0; i < 10; ++i) {
    const RecordedObservation& seen = dataset.observations[static_cast<std::size_t>(i)];
    EXPECT_EQ(seen.stamp, Time(milliseconds(100 * i)));
    EXPECT_EQ(seen.pictures.at("cam1").stamp, seen.stamp + milliseconds(8));
    EXPECT_EQ(seen.pictures.at("cam1").mention, "d/mav0/cam1/data.csv:" + std::to_string(i + 2));
    EXPECT_NEAR(seen.odometry.T_odom_body.x_m, 0.05 * i, 1e-6);
    EXPECT_NEAR(seen.odometry.T_odom_body.y_m, 0, 1e-9);
    EXPECT_NEAR(seen.odometry.T_odom_body.theta_rad, 0, 1e-9);
    EXPECT_NEAR(seen.odometry.twist_body.v_mps, 0.5, 1e-4);
  }
}

TEST(OthersDataset, OdometryThatDoesNotReachIsTold) {
  const Dataset dataset = TheirText(straight_odometry(150, 1000)).read();
  EXPECT_THAT(dataset.observations, SizeIs(8));
  EXPECT_EQ(dataset.observations.front().stamp, Time());
  EXPECT_THAT(dataset.warnings,
              ElementsAre("d/mav0/odom0/data.csv: begins 0.15 s after the first pictures and ends "
                          "0.00 s before the last; 2 of 10 frame sets are left out"));
  EXPECT_EQ(TheirText(straight_odometry(-1000, 220)).fault(),
            "d/mav0/odom0/data.csv: goes from 1699999999000000000 to 1700000000220000000 ns, the "
            "pictures from 1700000000000000000 to 1700000000900000000 ns; it must reach from the "
            "first to the last, by the same clock");
}

TEST(OthersDataset, FaultsAreToldWithTheirPlace) {
  EXPECT_EQ(TheirText(straight_odometry(-10, 950, ", 0.5")).fault(),
            "d/mav0/odom0/data.csv:2: has 5 fields, must have 4 or 6: #timestamp [ns], x [m], y "
            "[m], theta [rad], and v [m/s], w [rad/s] where they are known");
  TheirText theirs(straight_odometry(-10, 950));
  theirs["mav0/odom0/data.csv"] += TheirText::stamp(940) + ",7,0.5,1.57\n";
  EXPECT_THAT(theirs.fault(), HasSubstr("/odom0/data.csv:51: is not after the row before"));
  theirs["mav0/odom0/data.csv"] = straight_odometry(-10, 950) + TheirText::stamp(960) + ",7,9,1\n";
  EXPECT_THAT(theirs.fault(), HasSubstr("/odom0/data.csv:51: jumps 8.5"));
  theirs["mav0/odom0/data.csv"] = straight_odometry(-10, 950);
  theirs["mav0/cam1/data.csv"] += "\n1700000000.5,x.png\n";
  EXPECT_EQ(theirs.fault(),
            "d/mav0/cam1/data.csv:12: field 1 must be a whole number, got 1700000000.5");
}

TEST(OthersDataset, CamerasThatNobodyUsesGatherNothing) {
  TheirText theirs(straight_odometry(-10, 950));
  std::string fast = "#timestamp [ns],filename\n";
  for (int ms = 3; ms < 900; ms += 10) {
    fast += TheirText::stamp(ms) + ",x.png\n";
  }
  theirs["mav0/depth/data.csv"] = fast;
  Rig rig;
  rig.cameras["cam0"];
  rig.cameras["cam1"];
  const Dataset dataset = parse_dataset("d", {"cam0", "cam1", "depth"}, theirs.text(), rig);
  EXPECT_THAT(dataset.observations, SizeIs(10));
  EXPECT_THAT(dataset.observations[4].pictures, SizeIs(2));
}

TEST(OthersDataset, WhatTheWheelsSayWhilePicturesPauseIsKept) {
  TheirText theirs(straight_odometry(-10, 5000));
  for (const std::string camera : {"cam0", "cam1"}) {
    theirs["mav0/" + camera + "/data.csv"] += "\n" + TheirText::stamp(4900) + ",late.png\n";
  }
  const Dataset dataset = theirs.read();
  ASSERT_THAT(dataset.observations, SizeIs(10 + 7 + 1));  // every half second from 0.9 to 4.9 s
  EXPECT_THAT(dataset.observations[12].pictures, IsEmpty());
  EXPECT_NEAR(dataset.observations[12].odometry.T_odom_body.x_m,
              0.5 * to_seconds(dataset.observations[12].stamp), 1e-6);
  Rig rig;
  rig.cameras["cam0"];
  EXPECT_THAT(gap_lines(dataset, rig),
              ElementsAre("d/mav0/cam0/data.csv:12: no picture for 4.00 s, from 0.90 to 4.90 s: 39 "
                          "missing, at 10.0 a second"));
}

TEST(OthersDataset, OurOwnWithOtherOdometryIsTakenAsTheirs) {
  TheirText theirs(straight_odometry(-7, 953));
  theirs["recording.yaml"] = "schema: panoptes.dataset/1\n";
  theirs["mav0/events.csv"] = "#timestamp [ns], event, subject, value\n";
  EXPECT_FALSE(theirs.read().ours);
}

constexpr const char* kEstimate =
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z "
    "[], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], "
    "b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], "
    "b_a_RS_S_z [m s^-2]\r\n";

std::vector<TumPose> truth_with(const std::string& row, const std::string& sensor) {
  return *read_euroc_truth("d", [&](const std::string& file) -> std::optional<std::string> {
    return file == kEstimateFile ? std::optional(std::string(kEstimate) + row + "\r\n")
           : sensor.empty()      ? std::nullopt
                                 : std::optional(sensor);
  });
}

const std::string kRest = ",0,0,0,0.1,0.1,0.1,0.2,0.2,0.2";

TEST(EurocTruth, TellsWhereTheBodyIs) {
  const auto poses = truth_with(
      "1700000000000000000,4,5,0.3,0.7071067811865476,0,0,0.7071067811865476" + kRest, "");
  ASSERT_THAT(poses, SizeIs(1));
  const Pose2 T = floor_pose(poses[0]);
  EXPECT_NEAR(T.x_m, 4, 1e-12);
  EXPECT_NEAR(T.theta_rad, 1.5707963267948966, 1e-12);
}

TEST(EurocTruth, WhatWasTrackedMaySitElsewhere) {
  // an inertial sensor 0.2 m ahead, its x up and its z back
  const std::string lying =
      "T_BS:\n  cols: 4\n  rows: 4\n  data: [0, 0, -1, 0.2, 0, 1, 0, 0, 1, 0, 0, 0.5, 0, 0, 0, "
      "1]\n";
  const std::string row =
      "1700000000000000000,4,5,0.5,0.7071067811865476,0,-0.7071067811865476,0" + kRest;
  const Pose2 T = floor_pose(truth_with(row, lying)[0]);
  EXPECT_NEAR(T.x_m, 3.8, 1e-12);
  EXPECT_NEAR(T.y_m, 5, 1e-12);
  EXPECT_NEAR(T.theta_rad, 0, 1e-12);
  try {
    truth_with(row, "");
    ADD_FAILURE() << "a body that lies on its side";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("data.csv:2: the body does not stand upright"));
  }
  EXPECT_THROW(truth_with(row, "T_BS: [1, 2]\n"), ConfigError);
  EXPECT_THROW(truth_with("1700000000000000000,4,5,0.3,0.9,0,0,0.9" + kRest, ""), ConfigError);
}

}  // namespace
}  // namespace panoptes
