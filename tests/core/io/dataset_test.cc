// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/dataset.h"

#include <bit>
#include <cmath>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/io/dataset_writer.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;

Rig two_cameras() {
  Rig rig;
  for (const char* name : {"a", "b"}) {
    RigCamera camera;
    camera.rate_hz = 10;
    camera.intrinsics = pinhole(8, 6, 1.2);
    rig.cameras[name] = camera;
  }
  rig.cameras["a"].intrinsics.distortion = BrownConrady{-0.2, 0.05, 1e-4, -2e-4, 0};
  rig.cameras["b"].intrinsics.distortion = Equidistant{0.01, 0.002, 0, 0};
  return rig;
}

Time at_ns(std::int64_t ns) { return Time(Duration(ns)); }

cv::Mat noise(Rng& rng) {
  cv::Mat bgr(6, 8, CV_8UC3);
  for (int i = 0; i < 6 * 8 * 3; ++i) {
    bgr.data[i] = static_cast<unsigned char>(rng.index(256));
  }
  return bgr;
}

// Whatever an observation may hold: odd numbers, a missing camera, a picture with a stamp of its
// own, a deadline, bumps, a clock that is ahead of the pictures.
std::vector<std::pair<Observation, Time>> odd_observations() {
  Rng rng(5);
  std::vector<std::pair<Observation, Time>> all;
  for (int i = 0; i < 12; ++i) {
    Observation seen;
    seen.stamp = at_ns(100'000'000LL * i + (i % 3));
    Time now = seen.stamp;
    seen.odometry.T_odom_body = {rng.normal() / 3, i == 2 ? -0.0 : rng.normal() * 1e-17,
                                 rng.normal()};
    seen.odometry.twist_body = {i == 4 ? std::numeric_limits<double>::denorm_min() : rng.normal(),
                                rng.normal()};
    seen.health.bumper_pressed = i == 3 || i == 4;
    seen.health.motors_enabled = i != 7;
    if (i != 6) {
      seen.pictures["a"] = {seen.stamp, noise(rng)};
    }
    if (i != 6 && i != 8) {
      seen.pictures["b"] = {i > 8 ? seen.stamp - Duration(5) : seen.stamp, noise(rng)};
    }
    if (i == 9) {
      now += Duration(20'000'000);
    }
    all.emplace_back(seen, now);
  }
  return all;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

void expect_same(const Observation& was, Time now, const Dataset& dataset, std::size_t i) {
  const RecordedObservation& is = dataset.observations.at(i);
  EXPECT_EQ(is.stamp, was.stamp);
  EXPECT_EQ(is.now, now);
  const Odometry& o = was.odometry;
  EXPECT_TRUE(same_bits(is.odometry.T_odom_body.x_m, o.T_odom_body.x_m));
  EXPECT_TRUE(same_bits(is.odometry.T_odom_body.y_m, o.T_odom_body.y_m));
  EXPECT_TRUE(same_bits(is.odometry.T_odom_body.theta_rad, o.T_odom_body.theta_rad));
  EXPECT_TRUE(same_bits(is.odometry.twist_body.v_mps, o.twist_body.v_mps));
  EXPECT_TRUE(same_bits(is.odometry.twist_body.w_radps, o.twist_body.w_radps));
  EXPECT_EQ(is.health.bumper_pressed, was.health.bumper_pressed);
  EXPECT_EQ(is.health.motors_enabled, was.health.motors_enabled);
  ASSERT_EQ(is.pictures.size(), was.pictures.size()) << i;
  for (const auto& [name, picture] : was.pictures) {
    EXPECT_EQ(is.pictures.at(name).stamp, picture.stamp);
    const cv::Mat read = read_picture(dataset, is.pictures.at(name));
    ASSERT_EQ(read.size(), picture.bgr.size());
    EXPECT_EQ(std::memcmp(read.data, picture.bgr.data, read.total() * 3), 0);
  }
}

class DatasetTest : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    recorded_ = odd_observations();
  }

  void record() {
    Body robot;
    robot.radius_m = 0.3;
    DatasetWriter writer(folder_, {.version = "1.2.3", .mission = "m", .seed = 7}, two_cameras(),
                         robot);
    for (const auto& [seen, now] : recorded_) {
      writer.add(seen, now);
      writer.add({now, {0.1 / 3, -1e-9}, Duration(400'000'000)});
    }
  }

  std::string fault() {
    try {
      check_pictures(read_dataset(folder_), two_cameras());
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "none";
  }

  void replace(const std::string& file, const std::string& from, const std::string& to) {
    std::string text = read_file(folder_ / file);
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << file << " has no " << from;
    write_file(folder_ / file, text.replace(at, from.size(), to));
  }

  void cut(const std::string& file, std::uintmax_t bytes) {
    fs::resize_file(folder_ / file, fs::file_size(folder_ / file) - bytes);
  }

  std::vector<std::pair<Observation, Time>> recorded_;
};

TEST_F(DatasetTest, GivesBackEveryBit) {
  record();
  const Dataset dataset = read_dataset(folder_);
  check_pictures(dataset, two_cameras());
  EXPECT_THAT(dataset.cameras, ElementsAre("a", "b"));
  EXPECT_THAT(dataset.warnings, IsEmpty());
  ASSERT_EQ(dataset.observations.size(), recorded_.size());
  for (std::size_t i = 0; i < recorded_.size(); ++i) {
    SCOPED_TRACE(i);
    expect_same(recorded_[i].first, recorded_[i].second, dataset, i);
  }
  ASSERT_EQ(dataset.commands.size(), recorded_.size());
  EXPECT_TRUE(same_bits(dataset.commands[3].command_body.v_mps, 0.1 / 3));
  EXPECT_EQ(dataset.commands[9].stamp, recorded_[9].second);
  EXPECT_EQ(dataset.commands[9].valid_for, Duration(400'000'000));
  EXPECT_EQ(dataset.believed.info->seed, 7U);
  EXPECT_EQ(dataset.believed.robot->radius_m, 0.3);
  EXPECT_EQ(write_settings(*dataset.believed.rig), write_settings(two_cameras()));
}

TEST_F(DatasetTest, IsLaidOutAsEurocIs) {
  record();
  EXPECT_EQ(read_file(folder_ / "mav0/a/data.csv").substr(0, 60),
            "#timestamp [ns],filename\n0,0.png\n100000001,100000001.png\n200");
  EXPECT_THAT(
      read_file(folder_ / "mav0/odom0/data.csv"),
      testing::StartsWith("#timestamp [ns], x [m], y [m], theta [rad], v [m/s], w [rad/s]\n0,"));
  EXPECT_THAT(read_file(folder_ / "mav0/cmd0/data.csv"),
              testing::StartsWith("#timestamp [ns], v [m/s], w [rad/s], valid_for [ns]\n"
                                  "0,0.03333333333333333,-1e-09,400000000\n"));
  const std::string sensor = read_file(folder_ / "mav0/a/sensor.yaml");
  EXPECT_THAT(sensor, HasSubstr("\nresolution: [8, 6]\ncamera_model: pinhole\nintrinsics: ["));
  EXPECT_THAT(sensor, HasSubstr("\ndistortion_model: radial-tangential\n"
                                "distortion_coefficients: [-0.2, 0.05, 1.0e-04, -2.0e-04]\n"));
  EXPECT_THAT(read_file(folder_ / "mav0/b/sensor.yaml"),
              HasSubstr("\ndistortion_model: equidistant\n"));
  EXPECT_EQ(read_file(folder_ / "mav0/events.csv"),
            "#timestamp [ns], event, subject, value\n"
            "300000000,bumper,,1\n"
            "500000002,bumper,,0\n"
            "600000000,deadline,,\n"
            "700000001,motors,,0\n"
            "800000002,motors,,1\n"
            "800000002,missing,b,\n"
            "900000000,now,,920000000\n"
            "900000000,picture,b,899999995\n"
            "1000000001,picture,b,999999996\n"
            "1100000002,picture,b,1099999997\n");
}

TEST_F(DatasetTest, CutShortAnywhereIsReadToItsLastCompleteSet) {
  record();
  cut("mav0/odom0/data.csv", 1);  // the last row is torn: its set is not complete
  const Dataset dataset = read_dataset(folder_);
  EXPECT_EQ(dataset.observations.size(), recorded_.size() - 1);
  for (std::size_t i = 0; i < dataset.observations.size(); ++i) {
    expect_same(recorded_[i].first, recorded_[i].second, dataset, i);
  }
  EXPECT_THAT(
      dataset.warnings,
      ElementsAre(EndsWith("odom0/data.csv: the last row is torn, for the recording was cut "
                           "short; it is left out"),
                  EndsWith("2 pictures of an incomplete frame set at the end are left out")));
}

TEST_F(DatasetTest, FaultsAreToldWithTheirPlace) {
  record();
  const std::string mav = (folder_ / "mav0").string();
  replace("mav0/odom0/data.csv", "\n300000000,", "\n300000000,x");
  EXPECT_THAT(fault(),
              testing::StartsWith(mav + "/odom0/data.csv:5: field 2 must be a number, got x"));
  replace("mav0/odom0/data.csv", "\n300000000,x", "\n300000000,1,");
  EXPECT_EQ(fault(), mav + "/odom0/data.csv:5: has 7 fields, must have 6");
  replace("mav0/odom0/data.csv", "\n300000000,1,", "\n300000007,");
  EXPECT_EQ(fault(), mav + "/events.csv:2: no row of mav0/odom0/data.csv has this instant");
  replace("mav0/odom0/data.csv", "\n300000007,", "\n300000000,");
  EXPECT_EQ(fault(), "none");

  replace("mav0/a/data.csv", "\n300000000,", "\n300000001,");
  EXPECT_EQ(fault(), mav + "/a/data.csv:5: no row before " + mav +
                         "/odom0/data.csv:6 has this picture's instant; one is needed at each "
                         "picture, in the order of time");
  replace("mav0/a/data.csv", "\n300000001,", "\n300000000,../");
  EXPECT_EQ(fault(), mav + "/a/data.csv:5: must name a file of data/");
  replace("mav0/a/data.csv", "\n300000000,../", "\n100000001,");
  EXPECT_EQ(
      fault(),
      mav +
          "/a/data.csv:5: is not after the row before: put rows in the order of their stamps, each "
          "once");
  replace("mav0/a/data.csv", "\n100000001,300", "\n300000000,300");
  replace("mav0/events.csv", "bumper", "bumpr");
  EXPECT_EQ(fault(), mav +
                         "/events.csv:2: no such event; known are deadline, now, bumper, motors, "
                         "picture, missing and contact");
  replace("mav0/events.csv", "bumpr,,1", "bumper,,2");
  EXPECT_EQ(fault(), mav + "/events.csv:2: bumper must be 0 or 1");
}

TEST_F(DatasetTest, OnlyItsEndMayBeTorn) {
  record();
  const std::string file = "mav0/odom0/data.csv";
  const std::string mav = (folder_ / "mav0").string();
  const std::string whole = read_file(folder_ / file);
  const auto row = [&](int i) {  // from where to where
    std::size_t at = 0;
    for (int line = 0; line <= i; ++line) {
      at = whole.find('\n', at) + 1;
    }
    return std::pair(at, whole.find('\n', at) + 1);
  };
  const auto [from, to] = row(1);
  write_file(folder_ / file, whole.substr(0, from) + whole.substr(to));
  const std::string fault_at_the_next = mav + "/a/data.csv:3: no row before " + mav +
                                        "/odom0/data.csv:3 has this picture's instant; one is "
                                        "needed at each picture, in the order of time";
  EXPECT_EQ(fault(), fault_at_the_next);
  const auto [next, end] = row(2);
  write_file(folder_ / file, whole.substr(0, from) + whole.substr(next, end - next) +
                                 whole.substr(from, to - from) + whole.substr(end));
  EXPECT_EQ(fault(), fault_at_the_next);  // swapped
  const auto [last, last_end] = row(11);
  write_file(folder_ / file, whole.substr(0, last));
  EXPECT_EQ(fault(), "none");  // as a killed recording ends
}

TEST_F(DatasetTest, PicturesThatAreNoneAreTold) {
  record();
  const std::string mav = (folder_ / "mav0").string();
  const std::string place = mav + "/a/data.csv:5: " + mav + "/a/data/300000000.png ";
  const fs::path picture = folder_ / "mav0/a/data/300000000.png";
  const std::string whole = read_file(picture);
  cut("mav0/a/data/300000000.png", 10);
  const std::string cure = ": copy it again from where it was recorded, or remove its row";
  EXPECT_EQ(fault(), place + "is torn, the end of the PNG picture is missing" + cure);
  write_file(picture, "no picture, but long enough to be one");
  EXPECT_EQ(fault(), place + "is not a PNG or JPEG picture" + cure);
  fs::remove(picture);
  EXPECT_EQ(fault(), place + "is not there" + cure);
  cv::imwrite(picture.string(), cv::Mat(6, 8, CV_16UC1, cv::Scalar(300)));
  EXPECT_EQ(fault(), place +
                         "has 16 bits a sample; save the camera's pictures with 8 (mogrify "
                         "-depth 8 of ImageMagick does it)");
  std::string spoilt = whole;
  spoilt[spoilt.size() / 2] = static_cast<char>(spoilt[spoilt.size() / 2] ^ 0x55);
  write_file(picture, spoilt);
  EXPECT_EQ(fault(), "none");  // it looks whole
  const Dataset dataset = read_dataset(folder_);
  EXPECT_THROW(read_picture(dataset, dataset.observations[3].pictures.at("a")), ConfigError);
  Rig other = two_cameras();
  other.cameras["b"].intrinsics.width_px = 9;
  try {
    check_pictures(dataset, other);
    ADD_FAILURE() << "a picture of another size";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("has 8 x 6 pixels, the rig's b has 9 x 6: give the rig"));
  }
}

TEST_F(DatasetTest, AFolderInAFilesPlaceIsTold) {
  record();
  for (const char* file : {"mav0/odom0/data.csv", "mav0/events.csv", "mav0/a/data.csv",
                           "recording.yaml", "rig.yaml"}) {
    fs::rename(folder_ / file, folder_ / "kept");
    fs::create_directory(folder_ / file);
    EXPECT_EQ(fault(), (folder_ / file).string() + ": is not a file");
    fs::remove(folder_ / file);
    fs::rename(folder_ / "kept", folder_ / file);
  }
}

TEST_F(DatasetTest, WhatIsNoDatasetIsToldApart) {
  EXPECT_EQ(fault(), folder_.string() +
                         ": is no dataset: it has no folder mav0 (the EuRoC layout, as panoptes "
                         "record writes it)");
  fs::create_directories(folder_ / "mav0/cam0/data");
  write_file(folder_ / "mav0/cam0/data.csv", "#timestamp [ns],filename\n");
  EXPECT_EQ(fault(), folder_.string() +
                         ": has pictures of cam0 but no mav0/odom0/data.csv (#timestamp [ns], x "
                         "[m], y [m], theta [rad], v [m/s], w [rad/s]; the last two may be "
                         "absent): the wheels' odometry is needed, at whatever instants, from the "
                         "first pictures to the last; without it panoptes loops " +
                         (folder_ / "mav0/cam0/data").string() +
                         " finds places by their looks alone");
  EXPECT_THROW(read_beliefs(folder_), ConfigError);
  folder_ /= "nowhere";
  EXPECT_EQ(fault(), folder_.string() + ": no such folder");
}

TEST_F(DatasetTest, NothingIsWrittenOver) {
  record();
  EXPECT_THROW(record(), IoError);
}

TEST(DatasetText, IsReadWithoutAnyFile) {
  const auto text = [](const std::string& file) -> std::optional<std::string> {
    if (file == "mav0/events.csv") {
      return "#\n";
    }
    if (file == "mav0/odom0/data.csv") {
      return "#\n0,0,0,0,0,0\n5,1,0,0,0,0\n";
    }
    if (file == "mav0/cam/data.csv") {
      return "#\r\n5,five.png\r\n";
    }
    return std::nullopt;
  };
  const Dataset dataset = parse_dataset("d", {"cam"}, text);
  ASSERT_EQ(dataset.observations.size(), 2U);
  EXPECT_THAT(dataset.observations[0].pictures, IsEmpty());
  EXPECT_EQ(dataset.observations[1].pictures.at("cam").file, "mav0/cam/data/five.png");
  EXPECT_FALSE(dataset.believed.rig.has_value());
}

// What is said of a dataset whose last row of odometry is `last`.
std::string fault_of_last_row(const std::string& last) {
  const auto text = [&](const std::string& file) -> std::optional<std::string> {
    if (file == "mav0/events.csv") {
      return "#\n";
    }
    if (file == "mav0/odom0/data.csv") {
      return "#\n0,0,0,0,0,0\n100000000,0.05,0,0,0.5,0\n" + last + "\n";
    }
    if (file == "mav0/cam/data.csv") {
      return "#\n0,0.png\n100000000,1.png\n";
    }
    return std::nullopt;
  };
  try {
    parse_dataset("d", {"cam"}, text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "none";
}

TEST(DatasetText, RowsAreInTheOrderOfTime) {
  EXPECT_EQ(fault_of_last_row("50000000,0.05,0,0,0.5,0"),
            "d/mav0/odom0/data.csv:4: is before the row before; rows must be in the order of time");
}

TEST(DatasetText, OdometryOfAnotherClockIsRefused) {
  const auto text = [](const std::string& file) -> std::optional<std::string> {
    return file == "mav0/odom0/data.csv" ? std::optional("#\n0,0,0,0,0,0\n5,1,0,0,0,0\n")
           : file == "mav0/cam/data.csv" ? std::optional("#\n7000,a.png\n8000,b.png\n")
                                         : std::nullopt;
  };
  EXPECT_THROW(parse_dataset("d", {"cam"}, text), ConfigError);
}

TEST(DatasetText, StampsOfAnotherEpochBeginWithTheRun) {
  const auto text = [](const std::string& file) -> std::optional<std::string> {
    return file == "mav0/odom0/data.csv"
               ? std::optional("#\n1403636579763555584,0,0,0,0,0\n1403636579863555584,0,0,0,0,0\n")
           : file == "mav0/cam/data.csv"
               ? std::optional("#\n1403636579763555584,a.png\n1403636579863555580,b.png\n")
           : file == "mav0/events.csv"
               ? std::optional(
                     "#\n1403636579863555584,now,,1403636579873555584\n"
                     "1403636579863555584,picture,cam,1403636579863555580\n")
           : file == "mav0/cmd0/data.csv" ? std::optional("#\n1403636579873555584,0.1,0,5\n")
                                          : std::nullopt;
  };
  const Dataset dataset = parse_dataset("d", {"cam"}, text);
  EXPECT_TRUE(dataset.ours);
  EXPECT_EQ(start_unix_ns(dataset), 1403636579763555584);
  ASSERT_EQ(dataset.observations.size(), 2U);
  EXPECT_EQ(dataset.observations[0].stamp, Time());
  EXPECT_EQ(dataset.observations[1].now, at_ns(110'000'000));
  EXPECT_EQ(dataset.observations[1].pictures.at("cam").stamp, at_ns(99'999'996));
  EXPECT_EQ(dataset.commands.at(0).stamp, at_ns(110'000'000));
}

TEST(DatasetText, WhatNoRobotOnWheelsDoesIsRefused) {
  const std::string place = "d/mav0/odom0/data.csv:4: ";
  EXPECT_EQ(fault_of_last_row("200000000,0.1,0,0,0.5,0"), "none");
  EXPECT_EQ(fault_of_last_row("200000000,1e9,0,0,0.5,0"),
            place + "field 2 must be from -1e+06 to 1e+06, got 1e9");
  EXPECT_EQ(fault_of_last_row("200000000,0,0,-1e300,0.5,0"),
            place + "field 4 must be from -1e+06 to 1e+06, got -1e300");
  EXPECT_EQ(fault_of_last_row("200000000,0.1,0,0,700,0"),
            place + "field 5 must be from -20 to 20, got 700");
  EXPECT_EQ(fault_of_last_row("200000000,5.05,0,0,0.5,0"),
            place +
                "jumps 5 m in 0.1 s; no robot on wheels is faster than 20 m/s: mend or remove "
                "what is wrong");
  EXPECT_EQ(fault_of_last_row("4000000000000000000,0.1,0,0,0.5,0"),
            place +
                "is over an hour after the row before; that is no single drive: cut the "
                "dataset there, or mend the stamp");
}

}  // namespace
}  // namespace panoptes
