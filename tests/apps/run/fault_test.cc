// SPDX-License-Identifier: BSD-3-Clause
// Whatever is thrown in whichever phase of a run: the robot stands, what was done is kept, and the
// status tells whose fault it was.
#include "apps/process/fault.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "apps/run/mission_run.h"
#include "core/base/check.h"
#include "core/base/error.h"
#include "core/io/csv.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct Thrown {
  const char* name;
  std::function<void()> act;
  int status;
  const char* outcome;
};

std::vector<Thrown> everything_thrown() {
  return {
      {"no memory", [] { throw std::bad_alloc(); }, 3, "failed"},
      {"no memory for a picture",
       [] { CV_Error(cv::Error::StsNoMem, "Failed to allocate 1 bytes"); }, 3, "failed"},
      {"OpenCV", [] { CV_Error(cv::Error::StsAssert, "rows > 0"); }, 4, "failed"},
      {"device", [] { throw DeviceError("camera front: no picture for 1 s"); }, 3, "device_lost"},
      {"disk", [] { throw IoError("a.csv: cannot be written: No space left on device"); }, 3,
       "failed"},
      {"files",
       [] { throw fs::filesystem_error("a", std::make_error_code(std::errc::no_space_on_device)); },
       3, "failed"},
      {"check", [] { PANOPTES_CHECK(1 > 2, "one is more"); }, 4, "failed"},
      {"other", [] { throw std::out_of_range("vector::at"); }, 4, "failed"},
      {"no exception", [] { throw 7; }, 4, "failed"},
  };
}

TEST(CurrentFault, SaysWhoseItIs) {
  for (const Thrown& thrown : everything_thrown()) {
    SCOPED_TRACE(thrown.name);
    try {
      thrown.act();
    } catch (...) {
      EXPECT_EQ(current_fault().status, thrown.status);
      EXPECT_FALSE(current_fault().what.empty());
    }
  }
  try {
    throw ConfigError("a.yaml:1:1: seed: must be a number");
  } catch (...) {
    EXPECT_EQ(current_fault().status, 2);
    EXPECT_EQ(current_fault().what, "a.yaml:1:1: seed: must be a number");
  }
}

TEST(FaultsTest, AreToldOnceAndTheFirstDecides) {
  Faults faults;
  EXPECT_TRUE(faults.none());
  EXPECT_TRUE(faults.attempt([] {}));
  testing::internal::CaptureStderr();
  EXPECT_FALSE(faults.attempt([] { throw IoError("full"); }));
  EXPECT_FALSE(faults.attempt([] { throw IoError("full"); }));
  EXPECT_FALSE(faults.attempt([] { throw std::logic_error("odd"); }));
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "full\na bug of panoptes, please report it: odd\n");
  EXPECT_EQ(faults.status(), 3);
  EXPECT_EQ(faults.text(), "full\na bug of panoptes, please report it: odd");
}

/// Another robot in between, which throws at one of its calls and remembers all of them.
class FaultyRobot final : public hw::Robot {
 public:
  FaultyRobot(std::unique_ptr<hw::Robot> robot, std::string call, int at, std::function<void()> act,
              std::vector<std::string>& told)
      : robot_(std::move(robot)),
        call_(std::move(call)),
        at_(at),
        act_(std::move(act)),
        told_(told) {}

  Observation observe(Time deadline) override {
    note("observe");
    return robot_->observe(deadline);
  }
  void drive(const Twist2& command_body, Duration valid_for) override {
    note("drive");
    robot_->drive(command_body, valid_for);
  }
  void stop() override {
    told_.emplace_back("stop");
    robot_->stop();
    throw_at("stop");
  }
  Time now() const override { return robot_->now(); }
  Timing timing() const override { return robot_->timing(); }
  hw::DeviceFigures devices() const override {
    throw_at("devices");
    return robot_->devices();
  }
  std::optional<Truth> truth() const override {
    throw_at("truth");
    return robot_->truth();
  }

 private:
  void note(const char* call) {
    told_.emplace_back(call);
    throw_at(call);
  }
  void throw_at(const std::string& call) const {
    if (call == call_ && --at_ == 0) {
      act_();
    }
  }

  std::unique_ptr<hw::Robot> robot_;
  std::string call_;
  mutable int at_;
  std::function<void()> act_;
  std::vector<std::string>& told_;
};

/// What another robot perceives, but for its wheels.
class OtherWheels final : public hw::Robot {
 public:
  OtherWheels(std::unique_ptr<hw::Robot> robot, std::function<void(Observation&)> spoil,
              std::vector<Twist2>& commands)
      : robot_(std::move(robot)), spoil_(std::move(spoil)), commands_(commands) {}

  Observation observe(Time deadline) override {
    Observation seen = robot_->observe(deadline);
    spoil_(seen);
    return seen;
  }
  void drive(const Twist2& command_body, Duration valid_for) override {
    commands_.push_back(command_body);
    robot_->drive(command_body, valid_for);
  }
  void stop() override { robot_->stop(); }
  Time now() const override { return robot_->now(); }
  Timing timing() const override { return robot_->timing(); }
  std::optional<Truth> truth() const override { return robot_->truth(); }

 private:
  std::unique_ptr<hw::Robot> robot_;
  std::function<void(Observation&)> spoil_;
  std::vector<Twist2>& commands_;
};

class FaultyRun : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    ::setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
    write_file(folder_ / "m.yaml",
               "rig: {cameras: {}}\n"
               "platform: {kind: simulated, world: {name: room, boxes: [{name: floor, size_m: [6, "
               "6, 0.1], at: {x_m: 0, y_m: 0}, z_m: -0.1}, {name: box, size_m: [1, 1, 1], at: "
               "{x_m: 2, y_m: 2}}]}, start: {x_m: 0, y_m: 0, theta_deg: 0}}\n"
               "drive: none\nuntil: {duration_s: 1}\nframe_deadline_s: 0.1\n");
  }

  // A program drives for so long by wheels that tell no number in between.
  int run_without_numbers(double from_s, double to_s, const std::string& duration_s) {
    settings_ = {"drive={program: rose}", "until.duration_s=" + duration_s};
    commands_.clear();
    return run([=, this](OpenRobot& open, const fs::path&) {
      open.robot = std::make_unique<OtherWheels>(
          std::move(open.robot),
          [=](Observation& seen) {
            if (seen.stamp >= time_at(from_s) && seen.stamp < time_at(to_s)) {
              seen.odometry.T_odom_body.x_m = std::nan("");
            }
          },
          commands_);
    });
  }

  int run(const std::function<void(OpenRobot&, const fs::path&)>& wrap) {
    const auto mission = load_mission<ExploreMission>((folder_ / "m.yaml").string(), settings_,
                                                      CameraRequirement::kNothing);
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    int status = -1;
    try {
      status = run_mission(mission, {"record", folder_ / "run", true, wrap, false});
    } catch (...) {
      status = current_fault().status;
    }
    summary_ = testing::internal::GetCapturedStdout();
    said_ = testing::internal::GetCapturedStderr();
    return status;
  }

  int run_with(const std::string& call, int at, const std::function<void()>& act) {
    told_.clear();
    return run([&](OpenRobot& open, const fs::path&) {
      open.robot = std::make_unique<FaultyRobot>(std::move(open.robot), call, at, act, told_);
    });
  }

  nlohmann::json metrics() const {
    return nlohmann::json::parse(read_file(folder_ / "run" / "metrics.json"));
  }

  std::string said_;
  std::string summary_;
  std::vector<std::string> told_;
  std::vector<std::string> settings_;
  std::vector<Twist2> commands_;
};

TEST_F(FaultyRun, WithoutAFaultIsWhole) {
  EXPECT_EQ(run_with("", 1, [] {}), 0) << said_;
  EXPECT_EQ(metrics()["outcome"], "completed");
  EXPECT_FALSE(metrics().contains("fault"));
  EXPECT_EQ(told_.back(), "stop");
}

TEST_F(FaultyRun, StandsAndKeepsWhatWasDoneWhateverIsThrownOnTheWay) {
  for (const std::string call : {"observe", "drive"}) {
    for (const Thrown& thrown : everything_thrown()) {
      SCOPED_TRACE(call + ": " + thrown.name);
      fs::remove_all(folder_ / "run");
      EXPECT_EQ(run_with(call, 5, thrown.act), thrown.status) << said_;
      EXPECT_EQ(told_.back(), "stop");
      EXPECT_EQ(metrics()["outcome"], thrown.outcome);
      EXPECT_EQ(metrics()["fault"].get<std::string>() + "\n", said_);
      EXPECT_EQ(metrics()["frames"], 4);
      EXPECT_EQ(read_csv(folder_ / "run" / "steps.csv").rows.size(), 4U);
      EXPECT_EQ(read_tum(folder_ / "run" / "odometry.tum").size(), 4U);
      EXPECT_FALSE(read_tum(folder_ / "run" / "ground_truth.tum").empty());
      read_map_server(folder_ / "run" / "map.yaml");
    }
  }
}

TEST_F(FaultyRun, KeepsAllElseWhateverIsThrownAtTheEnd) {
  for (const std::string call : {"stop", "truth", "devices"}) {
    for (const Thrown& thrown : everything_thrown()) {
      SCOPED_TRACE(call + ": " + thrown.name);
      fs::remove_all(folder_ / "run");
      EXPECT_EQ(run_with(call, 1, thrown.act), thrown.status) << said_;
      EXPECT_EQ(metrics()["outcome"], "failed");
      EXPECT_EQ(metrics()["fault"].get<std::string>() + "\n", said_);
      EXPECT_GE(read_csv(folder_ / "run" / "steps.csv").rows.size(), 10U);
      EXPECT_TRUE(fs::exists(folder_ / "run" / "graph.g2o"));
    }
  }
}

TEST_F(FaultyRun, StandsWhileTheWheelsTellNoNumberAndGoesOn) {
  EXPECT_EQ(run_without_numbers(3, 5, "8"), 0) << said_;
  EXPECT_EQ(metrics()["outcome"], "completed");
  int standing = 0;
  for (const Twist2& command : commands_) {
    ASSERT_TRUE(std::isfinite(command.v_mps) && std::isfinite(command.w_radps));
    standing += command.v_mps == 0 && command.w_radps == 0 ? 1 : 0;
  }
  EXPECT_GE(standing, 19);
  EXPECT_TRUE(std::any_of(commands_.end() - 20, commands_.end(), [](const Twist2& command) {
    return command.v_mps != 0 || command.w_radps != 0;
  }));
  for (const TumPose& pose : read_tum(folder_ / "run" / "odometry.tum")) {
    EXPECT_TRUE(pose.T_frame_body.translation.allFinite());
  }
}

TEST_F(FaultyRun, EndsWhereTheWheelsStaySilent) {
  EXPECT_EQ(run_without_numbers(3, 1e6, "60"), 3);
  EXPECT_EQ(metrics()["outcome"], "device_lost");
  EXPECT_NEAR(metrics()["run_s"].get<double>(), 13, 0.3);
  EXPECT_THAT(summary_, HasSubstr("odometry: the wheels tell no number; nothing else for 10 s"));
  EXPECT_EQ(commands_.back().v_mps, 0);
}

TEST_F(FaultyRun, TellsThatARecordingDidNotComeToItsEnd) {
  EXPECT_EQ(run([](OpenRobot& open, const fs::path&) {
              open.finish = [] {
                throw IoError("mav0/a.png: cannot be written; the recording is whole until 0.5 s");
              };
            }),
            3);
  EXPECT_EQ(said_, "mav0/a.png: cannot be written; the recording is whole until 0.5 s\n");
  EXPECT_EQ(metrics()["outcome"], "failed");
  EXPECT_THAT(metrics()["fault"].get<std::string>(), HasSubstr("whole until 0.5 s"));
}

TEST_F(FaultyRun, LeavesNothingOfAStartThatFails) {
  EXPECT_EQ(run([](OpenRobot&, const fs::path&) { throw IoError("no room"); }), 3);
  EXPECT_FALSE(fs::exists(folder_ / "run"));
  EXPECT_EQ(run_with("observe", 1, [] { throw ConfigError("refused"); }), 2);
  EXPECT_EQ(told_.back(), "stop");
  EXPECT_FALSE(fs::exists(folder_ / "run"));
}

TEST_F(FaultyRun, WritesWhatCanBeWritten) {
  for (const char* name : {"loops.csv", "map.pgm", "map.png", "steps.csv"}) {
    SCOPED_TRACE(name);
    fs::remove_all(folder_ / "run");
    const int status = run([&](OpenRobot&, const fs::path& out) {
      fs::create_directories(out / name / "in the way");  // no file can get this name
    });
    EXPECT_EQ(status, 3) << said_;
    EXPECT_THAT(said_, HasSubstr(std::string(name) + ": cannot be "));
    EXPECT_EQ(metrics()["outcome"], "failed");
    EXPECT_THAT(metrics()["fault"].get<std::string>(), HasSubstr(name));
    for (const char* other :
         {"mission.yaml", "steps.csv", "odometry.tum", "loops.csv", "map.pgm", "coverage.png"}) {
      EXPECT_TRUE(other == std::string(name) || fs::is_regular_file(folder_ / "run" / other))
          << other;
    }
  }
}

}  // namespace
}  // namespace panoptes
