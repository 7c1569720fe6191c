// SPDX-License-Identifier: BSD-3-Clause
#include "hw/replay/recorded_robot.h"

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/io/file.h"
#include "hw/replay/recording_robot.h"
#include "tests/hw/replay/scripted_robot.h"
#include "tests/support/scratch.h"

namespace panoptes::hw {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kObservations = 23;

class RecordedRobotTest : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    RecordingRobot robot(std::make_unique<ScriptedRobot>(kObservations), folder_,
                         RecordingInfo{.version = "1", .mission = "m", .seed = 3}, small_rig(),
                         Body{});
    drive_on(robot, kObservations);
    robot.finish();
  }

  std::unique_ptr<RecordedRobot> replay(const Rig& rig = small_rig()) const {
    return std::make_unique<RecordedRobot>(read_dataset(folder_), rig,
                                           RecordedTruth::read(folder_));
  }

  std::string rig_fault(const Rig& rig) const {
    try {
      recorded_rig({folder_.string(), "m.yaml:1:1"}, read_dataset(folder_), rig);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "none";
  }
};

TEST_F(RecordedRobotTest, PerceivesTheSameAgainBitForBit) {
  ScriptedRobot live(kObservations);
  const auto robot = replay();
  for (int i = 0; i < kObservations; ++i) {
    SCOPED_TRACE(i);
    EXPECT_FALSE(robot->ended());
    const Observation was = drive_on(live, 1, i).front();
    const Observation is = drive_on(*robot, 1, i).front();
    expect_same(was, is);
    EXPECT_EQ(robot->now(), live.now());
    expect_same(*robot->truth(), *live.truth());  // no later one than live
  }
  EXPECT_TRUE(robot->ended());
  EXPECT_FALSE(robot->commands_diverged_at());
  EXPECT_EQ(robot->length(), live.now().time_since_epoch());
}

// Its front camera is told stamps that are off: earlier than the run, or later than the set.
class WrongClock final : public Robot {
 public:
  WrongClock(int observations, Duration offset) : robot_(observations), offset_(offset) {}
  Observation observe(Time deadline) override {
    Observation seen = robot_.observe(deadline);
    if (const auto front = seen.pictures.find("front"); front != seen.pictures.end()) {
      front->second.stamp += offset_;
    }
    return seen;
  }
  void drive(const Twist2& command, Duration valid_for) override {
    robot_.drive(command, valid_for);
  }
  void stop() override {}
  Time now() const override { return robot_.now(); }
  Timing timing() const override { return robot_.timing(); }
  std::optional<Truth> truth() const override { return std::nullopt; }

 private:
  ScriptedRobot robot_;
  Duration offset_;
};

TEST_F(RecordedRobotTest, PicturesOfAWrongClockComeAgainWithTheirStamps) {
  for (const Duration offset : {Duration(-13'000'001), Duration(7'000'003)}) {
    const fs::path folder = folder_ / std::to_string(offset.count());
    fs::create_directories(folder);
    RecordingRobot recording(std::make_unique<WrongClock>(kObservations, offset), folder,
                             RecordingInfo{.version = "1", .mission = "m", .seed = 3}, small_rig(),
                             Body{});
    drive_on(recording, kObservations);
    recording.finish();
    WrongClock live(kObservations, offset);
    RecordedRobot robot(read_dataset(folder), small_rig(), std::nullopt);
    for (int i = 0; i < kObservations; ++i) {
      SCOPED_TRACE(i);
      expect_same(drive_on(live, 1, i).front(), drive_on(robot, 1, i).front());
    }
    EXPECT_TRUE(robot.ended());
  }
}

TEST_F(RecordedRobotTest, NoticesTheFirstCommandThatDiffers) {
  const auto robot = replay();
  drive_on(*robot, 6);
  robot->observe(robot->now() + seconds(1));
  Twist2 other = made_up_command(6);
  other.v_mps = std::nextafter(other.v_mps, 10.0);
  robot->drive(other, milliseconds(400));
  EXPECT_EQ(robot->commands_diverged_at(), robot->now());
  const Time when = robot->now();
  drive_on(*robot, 3, 7);
  EXPECT_EQ(robot->commands_diverged_at(), when);  // from then on, whatever comes

  const auto longer = replay();
  longer->observe(seconds(1) + Time());
  longer->drive(made_up_command(0), milliseconds(500));
  EXPECT_EQ(longer->commands_diverged_at(), Time());
}

TEST_F(RecordedRobotTest, ACommandThatTheKilledRecordingLacksDiffersFromNone) {
  const std::string commands = read_file(folder_ / "mav0/cmd0/data.csv");
  write_file(folder_ / "mav0/cmd0/data.csv",
             commands.substr(0, commands.rfind('\n', commands.size() - 2) + 1));
  const auto robot = replay();
  drive_on(*robot, kObservations);
  EXPECT_FALSE(robot->commands_diverged_at());
}

TEST_F(RecordedRobotTest, ReplaysAsFarAsItsTruthIsWhole) {
  for (const char* name : {"data.csv", "poses.csv", "contacts.csv", "seen.csv"}) {
    SCOPED_TRACE(name);
    const fs::path file = folder_ / "mav0/truth0" / name;
    const std::string rows = read_file(file);
    write_file(file, rows.substr(0, rows.size() - 3));  // in the middle of its last row
    const auto robot = replay();
    EXPECT_THAT(robot->remarks().back(),
                testing::HasSubstr("truth0/data.csv: the truth of the last "));
    ScriptedRobot live(kObservations);
    while (!robot->ended()) {
      expect_same(live.observe({}), robot->observe(robot->now() + seconds(1)));
      expect_same(*live.truth(), *robot->truth());
    }
    EXPECT_LT(live.now(), Time(milliseconds(100 * (kObservations - 1))));
    write_file(file, rows);
  }
}

TEST_F(RecordedRobotTest, TruthThatLacksRowsBeforeItsEndIsRefused) {
  const auto fault_without_row = [this](const char* name, int row) {
    const fs::path file = folder_ / "mav0/truth0" / name;
    const std::string rows = read_file(file);
    std::size_t at = 0;
    for (int line = 0; line < row; ++line) {
      at = rows.find('\n', at) + 1;
    }
    write_file(file, rows.substr(0, at) + rows.substr(rows.find('\n', at) + 1));
    std::string fault = "none";
    try {
      replay();
    } catch (const ConfigError& error) {
      fault = error.what();
    }
    write_file(file, rows);
    return fault.substr(fault.find("/mav0/truth0/") + 13);
  };
  EXPECT_THAT(fault_without_row("poses.csv", 3),
              testing::MatchesRegex("poses.csv:4: is later than the observation that knows of it .*"
                                    "/data.csv:4.; rows before it are missing"));
  EXPECT_THAT(fault_without_row("seen.csv", 2), testing::HasSubstr("rows before it are missing"));
  EXPECT_EQ(fault_without_row("data.csv", 3),
            "data.csv:4: must be of the instant 200000000, as row 3 of mav0/odom0/data.csv");
}

TEST_F(RecordedRobotTest, WithoutRecordedCommandsAnyDiffers) {
  fs::remove(folder_ / "mav0/cmd0/data.csv");
  const auto robot = replay();
  drive_on(*robot, 2);
  EXPECT_EQ(robot->commands_diverged_at(), Time());
}

TEST_F(RecordedRobotTest, StandsStillAtTheEnd) {
  const auto robot = replay();
  const Observation last = drive_on(*robot, kObservations).back();
  const Time deadline = robot->now() + seconds(1);
  const Observation after = robot->observe(deadline);
  EXPECT_TRUE(after.pictures.empty());
  EXPECT_EQ(after.stamp, deadline);
  EXPECT_EQ(after.odometry.T_odom_body, last.odometry.T_odom_body);
}

TEST_F(RecordedRobotTest, MeetsAnEarlierDeadlineWithoutLosingASet) {
  ScriptedRobot live(kObservations);
  const auto robot = replay();
  expect_same(live.observe({}), robot->observe(Time()));
  const Observation early = robot->observe(Time(milliseconds(40)));
  EXPECT_EQ(early.stamp, Time(milliseconds(40)));
  EXPECT_TRUE(early.pictures.empty());
  expect_same(live.observe({}), robot->observe(Time(seconds(1))));
}

TEST_F(RecordedRobotTest, TakesItsTimingFromTheStampsWhereTheRecordingDoesNotSay) {
  EXPECT_EQ(replay()->timing().period, ScriptedRobot(1).timing().period);
  write_file(folder_ / "recording.yaml", "schema: panoptes.dataset/1\nversion: '1'\n");
  const Dataset dataset = read_dataset(folder_);
  const Timing timing = recorded_timing(dataset);
  EXPECT_EQ(timing.period, dataset.observations[2].stamp - dataset.observations[1].stamp);
  EXPECT_EQ(timing.worst_latency,
            timing.period + (dataset.observations[1].now - dataset.observations[1].stamp));
}

TEST_F(RecordedRobotTest, LeavesOutCamerasThatNobodyAsksFor) {
  Rig rig = small_rig();
  rig.cameras.erase("front");
  const auto robot = replay(rig);
  for (const Observation& seen : drive_on(*robot, kObservations)) {
    EXPECT_FALSE(seen.pictures.contains("front"));
  }
}

TEST_F(RecordedRobotTest, APictureThatCannotBeReadIsToldWhenItIsDue) {
  const fs::path picture = folder_ / "mav0/front/data/300000000.png";
  std::string bytes = read_file(picture);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x55);
  write_file(picture, bytes);
  const auto robot = replay();
  drive_on(*robot, 3);
  try {
    robot->observe(robot->now() + seconds(1));
    ADD_FAILURE() << "it was read";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("mav0/front/data.csv:4: "));
  }
}

TEST_F(RecordedRobotTest, TakesTheSurveyOfTheRecordingWhereTheRigHasNone) {
  Rig rig = small_rig();
  rig.cameras["floor"].floor->marks.clear();
  const Rig surveyed = recorded_rig({folder_.string(), ""}, read_dataset(folder_), rig);
  EXPECT_EQ(surveyed.cameras.at("floor").floor->marks.size(), 4U);
  EXPECT_EQ(surveyed.cameras.at("floor").floor->marks[1].px, Vec2(7, 5));

  rig.cameras["side"] = rig.cameras["front"];
  EXPECT_EQ(rig_fault(rig),
            "m.yaml:1:1: platform.dataset: has no pictures of the rig's camera side; it has floor, "
            "front");
  rig.cameras.erase("side");
  fs::remove(folder_ / "rig.yaml");
  EXPECT_EQ(rig_fault(rig),
            "m.yaml:1:1: platform.dataset: its rig.yaml has no surveyed marks for floor; give "
            "rig.cameras.floor.floor.marks or .homography");
}

}  // namespace
}  // namespace panoptes::hw
