// SPDX-License-Identifier: BSD-3-Clause
#include "hw/replay/recording_robot.h"

#include <cmath>
#include <csignal>
#include <fstream>

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>
#include <sys/resource.h>

#include "core/base/error.h"
#include "core/io/file.h"
#include "tests/hw/replay/scripted_robot.h"
#include "tests/support/scratch.h"

namespace panoptes::hw {
namespace {

namespace fs = std::filesystem;

class RecordingRobotTest : public ScratchTest {
 protected:
  std::unique_ptr<RecordingRobot> recording(int observations, TruePictures true_pictures = {}) {
    return std::make_unique<RecordingRobot>(
        std::make_unique<ScriptedRobot>(observations), folder_,
        RecordingInfo{.version = "1", .mission = "m", .seed = 3}, small_rig(), Body{},
        std::move(true_pictures));
  }
};

TEST_F(RecordingRobotTest, PassesOnWhatTheRobotSays) {
  ScriptedRobot alone(20);
  const auto recorded = recording(20);
  const std::vector<Observation> a = drive_on(alone, 20);
  const std::vector<Observation> b = drive_on(*recorded, 20);
  for (std::size_t i = 0; i < a.size(); ++i) {
    expect_same(a[i], b[i]);
  }
  EXPECT_EQ(recorded->now(), alone.now());
  expect_same(*recorded->truth(), *alone.truth());
}

TEST_F(RecordingRobotTest, KeepsAllThatWasPerceivedUntilTheRobotIsLost) {
  {
    const auto robot = recording(5);
    drive_on(*robot, 5);
    EXPECT_THROW(robot->observe(robot->now()), DeviceError);
  }
  const Dataset dataset = read_dataset(folder_);
  EXPECT_EQ(dataset.observations.size(), 5U);
  EXPECT_EQ(dataset.commands.size(), 5U);
  EXPECT_EQ(recorded_timing(dataset).period, ScriptedRobot(5).timing().period);
  EXPECT_EQ(recorded_timing(dataset).worst_latency, ScriptedRobot(5).timing().worst_latency);
  EXPECT_THAT(dataset.warnings, testing::IsEmpty());
}

// Its fourth observation is of wheels that tell no number.
class SilentWheels final : public Robot {
 public:
  Observation observe(Time deadline) override {
    Observation seen = robot_.observe(deadline);
    if (++observations_ == 4) {
      seen.odometry.twist_body.w_radps = std::nan("");
    }
    return seen;
  }
  void drive(const Twist2& /*command_body*/, Duration /*valid_for*/) override {}
  void stop() override {}
  Time now() const override { return robot_.now(); }
  Timing timing() const override { return robot_.timing(); }
  std::optional<Truth> truth() const override { return robot_.truth(); }

 private:
  ScriptedRobot robot_{10};
  int observations_ = 0;
};

TEST_F(RecordingRobotTest, EndsWhereTheWheelsTellNoNumber) {
  {
    RecordingRobot robot(std::make_unique<SilentWheels>(), folder_, {}, small_rig(), Body{});
    drive_on(robot, 3);
    EXPECT_THROW(robot.observe(robot.now()), DeviceError);
  }
  EXPECT_EQ(read_dataset(folder_).observations.size(), 3U);
}

TEST_F(RecordingRobotTest, WritesForOtherProgramsToo) {
  {
    const auto robot = recording(8);
    drive_on(*robot, 8);
    robot->finish();
  }
  const std::string estimate = read_file(folder_ / "mav0/state_groundtruth_estimate0/data.csv");
  EXPECT_THAT(estimate, testing::StartsWith("#timestamp, p_RS_R_x [m], p_RS_R_y [m]"));
  EXPECT_EQ(std::count(estimate.begin(), estimate.end(), '\n'), 1 + 7);  // one was a deadline
  EXPECT_THAT(read_file(folder_ / "mav0/events.csv"),
              testing::HasSubstr("\n299999993,contact,desk-01,standing\n"));
}

TEST_F(RecordingRobotTest, TruePicturesGoBesideThePictures) {
  const auto shown = [] {
    TruePicture picture;
    picture.stamp = Time(Duration(0));
    picture.depth_m = (cv::Mat_<float>(1, 5) << 1.2345F, 70.0F, -1.0F,
                       std::numeric_limits<float>::infinity(), 65.535F);
    picture.instance = (cv::Mat_<std::uint16_t>(1, 2) << 0, 40'000);
    picture.floor_label = (cv::Mat_<std::uint8_t>(1, 2) << 0, 255);
    return std::map<std::string, TruePicture>{{"front", picture}};
  };
  {
    const auto robot = recording(1, {shown, {"desk, big", "chair"}});
    drive_on(*robot, 1);
  }
  const auto picture = [&](const std::string& name) {
    return cv::imread((folder_ / "mav0" / name / "data/0.png").string(), cv::IMREAD_UNCHANGED);
  };
  const cv::Mat depth = picture("front_depth");
  ASSERT_EQ(depth.type(), CV_16UC1);
  EXPECT_EQ(cv::Mat_<std::uint16_t>(depth)(0, 0), 1235);   // rounded
  EXPECT_EQ(cv::Mat_<std::uint16_t>(depth)(0, 1), 65535);  // too far for 16 bits
  EXPECT_EQ(cv::Mat_<std::uint16_t>(depth)(0, 2), 0);
  EXPECT_EQ(cv::Mat_<std::uint16_t>(depth)(0, 3), 0);
  EXPECT_EQ(cv::Mat_<std::uint16_t>(depth)(0, 4), 65535);
  EXPECT_THAT(
      read_file(folder_ / "mav0/front_depth/sensor.yaml"),
      testing::HasSubstr("16 bit, millimetres along the camera's axis; 0: nothing is there; "
                         "65535: 65.535 m or farther"));
  EXPECT_EQ(cv::Mat_<std::uint16_t>(picture("front_labels"))(0, 1), 40'000);
  EXPECT_EQ(cv::Mat_<std::uint8_t>(picture("front_floor"))(0, 1), 255);
  EXPECT_EQ(read_file(folder_ / "mav0/things.csv"),
            "#number, thing\n0,nothing\n1,desk  big\n2,chair\n");
  EXPECT_THAT(read_dataset(folder_).cameras, testing::ElementsAre("floor", "front"));
}

TEST_F(RecordingRobotTest, AFullDiskIsToldAndWhatIsThereStays) {
  constexpr rlim_t kRoom_bytes = 1200;  // for ten rows of the true poses
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::string what;
  {
    const auto robot = recording(100);
    const rlimit small{kRoom_bytes, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    try {
      drive_on(*robot, 100);
      robot->finish();
    } catch (const IoError& error) {
      what = error.what();
    }
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(what, testing::MatchesRegex(folder_.string() +
                                          "/mav0/.*: cannot be written: File too large; the "
                                          "recording is whole until [0-9.]+ s"));
  EXPECT_GE(read_dataset(folder_).observations.size(), 3U);
}

}  // namespace
}  // namespace panoptes::hw
