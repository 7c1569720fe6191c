// SPDX-License-Identifier: BSD-3-Clause
#include "hw/standin/controller.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/config/fields.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr double kCount_m = 0.5e-3 + 1e-9;  // half a count of the wire's millimetres
constexpr double kPeriod_s = 0.01;          // of the controller's servos

/// A robot that goes at once as it is told, exactly, on an endless floor. A wall ahead, where there
/// is one, holds it.
class FloorRobot final : public Robot {
 public:
  Observation observe(Time deadline) override {
    while (now_ < deadline) {
      const Time next = std::min(deadline, now_ + milliseconds(1));
      const Twist2 wanted = now_ < expires_ ? command_ : Twist2{};
      const bool blocked = held && wanted.v_mps > 0;
      twist_ = {blocked ? 0 : wanted.v_mps, wanted.w_radps};
      pose = pose * exp_twist(twist_, to_seconds(next - now_));
      now_ = next;
    }
    Observation seen;
    seen.stamp = now_;
    seen.odometry = {pose, twist_};
    seen.health.bumper_pressed = held || !bearings_rad.empty();
    seen.health.bumper_bearings_rad = bearings_rad;
    return seen;
  }
  void drive(const Twist2& command, Duration valid_for) override {
    command_ = command;
    expires_ = now_ + valid_for;
  }
  void stop() override { command_ = {}; }
  Time now() const override { return now_; }
  Timing timing() const override {
    return {std::chrono::milliseconds(67), std::chrono::milliseconds(8)};
  }
  std::optional<Truth> truth() const override { return std::nullopt; }

  const Twist2& twist() const { return twist_; }

  Pose2 pose;
  bool held = false;
  std::vector<double> bearings_rad;

 private:
  Twist2 command_;
  Twist2 twist_;
  Time expires_;
  Time now_;
};

/// With no limits that would be felt.
Body nimble() {
  Body body;
  body.max_speed_mps = 5;
  body.max_turn_radps = 5;
  body.max_accel_mps2 = 1e4;
  body.max_turn_accel_radps2 = 1e4;
  return body;
}

class StandInControllerTest : public testing::Test {
 protected:
  void make(const StandInOptions& options = {}, const Body& body = nimble()) {
    controller_.emplace(robot_, body, options);
  }

  void tell(const Bytes& bytes) { controller_->receive(controller_->now(), bytes); }
  void tell(Command command) { tell(command_frame(command)); }
  void tell(Command command, int argument) { tell(command_frame(command, argument)); }

  /// The payloads that begin until then.
  std::vector<Bytes> hear(Duration during = {}) {
    controller_->advance(controller_->now() + during);
    PacketReader reader;
    std::vector<Bytes> payloads;
    for (const Sent& sent : controller_->take_sent()) {
      for (const PacketReader::Packet& packet : reader.read(sent.bytes)) {
        payloads.push_back(packet.payload);
      }
    }
    EXPECT_EQ(reader.bad_frames(), 0U);
    return payloads;
  }

  /// The last report of a while in which the client keeps the link alive.
  Sip drive(Duration during) {
    const Time end = controller_->now() + during;
    Sip last;
    while (controller_->now() < end) {
      tell(Command::kPulse);
      for (const Bytes& payload :
           hear(std::min<Duration>(milliseconds(500), end - controller_->now()))) {
        last = read_sip(payload).value_or(last);
      }
    }
    return last;
  }

  void connect() {
    for (const Command command : {Command::kPulse, Command::kOpen, Command::kClose}) {
      tell(command);
    }
    tell(Command::kOpen, 1);
    T_opened_ = robot_.pose;
    tell(Command::kEnable, 1);
    hear();
  }

  double speed_now() const { return robot_.twist().v_mps; }
  double turn_now() const { return robot_.twist().w_radps; }

  FloorRobot robot_;
  Pose2 T_opened_;  ///< of the robot
  std::optional<StandInController> controller_;
};

TEST_F(StandInControllerTest, AnswersTheOpeningOfAriaCoda) {
  make();
  tell(Bytes{0xFA, 0xFB, 0x03, 0x00, 0x00, 0x00});
  EXPECT_THAT(hear(), ElementsAre(Bytes{0}));
  tell(Bytes{0xFA, 0xFB, 0x03, 0x01, 0x00, 0x01});
  EXPECT_THAT(hear(), ElementsAre(Bytes{1}));
  tell(Bytes{0xFA, 0xFB, 0x03, 0x02, 0x00, 0x02});
  const std::vector<Bytes> third = hear();
  ASSERT_THAT(third, SizeIs(1));
  const auto names = read_names(third.front());
  ASSERT_TRUE(names);
  EXPECT_EQ(names->class_name, "Pioneer");
  EXPECT_EQ(names->subclass, "p3dx-sh");
  EXPECT_FALSE(controller_->open());
  tell(Bytes{0xFA, 0xFB, 0x06, 0x01, 0x3B, 0x01, 0x00, 0x02, 0x3B});
  EXPECT_TRUE(controller_->open());
  tell(Bytes{0xFA, 0xFB, 0x06, 0x12, 0x3B, 0x01, 0x00, 0x13, 0x3B});
  const std::vector<Bytes> configured = hear();
  ASSERT_THAT(configured, SizeIs(1));
  const auto config = read_config(configured.front());
  ASSERT_TRUE(config);
  EXPECT_EQ(config->subclass, "p3dx-sh");
  EXPECT_EQ(config->sip_cycle_ms, 100);
  EXPECT_EQ(config->watchdog_ms, 2000);
  EXPECT_EQ(config->front_bumpers, 5);
  tell(Bytes{0xFA, 0xFB, 0x06, 0x32, 0x3B, 0x02, 0x00, 0x34, 0x3B});
  EXPECT_EQ(controller_->baud(), 38400);
  tell(Bytes{0xFA, 0xFB, 0x06, 0x3E, 0x3B, 0x01, 0x00, 0x3F, 0x3B});
  tell(Bytes{0xFA, 0xFB, 0x06, 0x04, 0x3B, 0x01, 0x00, 0x05, 0x3B});
  tell(Bytes{0xFA, 0xFB, 0x06, 0x06, 0x3B, 0xB8, 0x0B, 0xBE, 0x46});
  tell(Bytes{0xFA, 0xFB, 0x06, 0x05, 0x3B, 0x2C, 0x01, 0x31, 0x3C});
  tell(Bytes{0xFA, 0xFB, 0x06, 0x05, 0x1B, 0x2C, 0x01, 0x31, 0x1C});
  tell(Bytes{0xFA, 0xFB, 0x06, 0x0A, 0x3B, 0x96, 0x00, 0xA0, 0x3B});
  tell(Bytes{0xFA, 0xFB, 0x06, 0x17, 0x3B, 0x64, 0x00, 0x7B, 0x3B});
  tell(Bytes{0xFA, 0xFB, 0x06, 0x17, 0x1B, 0x64, 0x00, 0x7B, 0x1B});
  const std::vector<Bytes> reports = hear(seconds(1));
  EXPECT_GE(reports.size(), 9U);  // the configuration took some of the line's time
  const auto sip = read_sip(reports.back());
  ASSERT_TRUE(sip);
  EXPECT_FALSE(sip->moving);
  EXPECT_EQ(sip->flags & kFlagMotorsOn, kFlagMotorsOn);
  EXPECT_THAT(sip->sonar, IsEmpty());
  EXPECT_NEAR(sip->battery_v(), 12.7, 0.05);
  tell(Command::kEnable, 0);
  tell(Bytes{0xFA, 0xFB, 0x06, 0x02, 0x3B, 0x01, 0x00, 0x03, 0x3B});
  EXPECT_FALSE(controller_->open());
  EXPECT_THAT(hear(seconds(1)), IsEmpty());
  EXPECT_EQ(controller_->baud(), 38400);
}

TEST_F(StandInControllerTest, OutOfOrderItStartsOver) {
  make();
  tell(Command::kOpen);
  tell(Command::kClose);
  EXPECT_THAT(hear(), IsEmpty());
  tell(Command::kPulse);
  tell(Command::kOpen);
  tell(Command::kOpen);  // SYNC1 again
  EXPECT_THAT(hear(), SizeIs(2));
  tell(Command::kClose);
  EXPECT_THAT(hear(), IsEmpty());
  tell(Command::kPulse);
  tell(Command::kPulse);
  tell(Command::kOpen);
  tell(Command::kPulse);
  tell(Command::kOpen);
  tell(Command::kClose);
  EXPECT_THAT(hear(), SizeIs(6));
  tell(Command::kVelocity, 100);  // before OPEN
  EXPECT_THAT(hear(seconds(1)), IsEmpty());
  tell(Command::kOpen, 1);
  EXPECT_TRUE(controller_->open());
}

TEST_F(StandInControllerTest, InAnOpenSessionItStreamsOnUntilClose) {
  make();
  connect();
  tell(Command::kPulse);  // SYNC0
  tell(Command::kOpen);   // SYNC1
  for (const Bytes& payload : hear(seconds(1))) {
    EXPECT_TRUE(read_sip(payload));
  }
  tell(Command::kClose);  // SYNC2
  EXPECT_THAT(hear(seconds(1)), IsEmpty());
  tell(Command::kPulse);
  EXPECT_THAT(hear(), ElementsAre(Bytes{0}));
}

TEST_F(StandInControllerTest, ReportsWhereItIsAndHowItMoves) {
  make();
  connect();
  tell(Command::kVelocity, 400);
  drive(seconds(1));
  tell(Command::kVelocity, 250);
  tell(Command::kTurnVelocity, -20);
  const Sip sip = drive(seconds(2));
  EXPECT_TRUE(sip.moving);
  const PioneerModel& model = *find_model("p3dx-sh");
  EXPECT_NEAR(sip.x * model.distance_m, robot_.pose.x_m, kCount_m);
  EXPECT_NEAR(static_cast<std::int16_t>(sip.y) * model.distance_m, robot_.pose.y_m, kCount_m);
  EXPECT_NEAR(sip.theta * model.angle_rad, robot_.pose.theta_rad, model.angle_rad / 2 + 1e-9);
  EXPECT_NEAR(robot_.pose.theta_rad, deg_to_rad(-40), deg_to_rad(20) * kPeriod_s * 1.01);
  EXPECT_NEAR((sip.left + sip.right) / 2 * model.speed_mps, 0.25, model.speed_mps);
  EXPECT_NEAR((sip.right - sip.left) / 2 * model.speed_mps * model.turn_rad_per_m, deg_to_rad(-20),
              model.speed_mps * model.turn_rad_per_m);
  EXPECT_EQ(sip.turn_velocity, -200);
  EXPECT_EQ(sip.flags, kFlagMotorsOn | kFlagEmergencyStall);
  EXPECT_FALSE(sip.left_stalled || sip.right_stalled);
  tell(Command::kSonar, 1);
  EXPECT_EQ(drive(milliseconds(200)).flags & kFlagSonar, 0) << "it has no array to switch on";
  tell(Command::kEmergencyStall, 0);
  EXPECT_EQ(drive(milliseconds(200)).flags & kFlagEmergencyStall, 0);
}

TEST_F(StandInControllerTest, AReportIsOfTheInstantAtWhichItsTransmissionBegins) {
  make({.host_baud = 9600});
  connect();
  tell(Command::kVelocity, 500);
  hear(seconds(1));
  tell(Command::kConfig);  // over 100 bytes, over 100 ms
  controller_->advance(controller_->now() + seconds(1));
  const std::vector<Sent> sent = controller_->take_sent();
  ASSERT_THAT(sent, testing::Not(IsEmpty()));
  Time free = sent.front().at;
  for (const Sent& one : sent) {
    EXPECT_GE(one.at, free);  // one after the other
    free = one.at + Duration(seconds(10)) * one.bytes.size() / 9600;
    const auto sip = read_sip(std::span(one.bytes).subspan(3, one.bytes.size() - 5));
    if (sip) {
      // The robot moves at the first control period after it is told.
      EXPECT_NEAR(sip->x * 1e-3, 0.5 * to_seconds(one.at), kCount_m + 0.5 * kPeriod_s);
    }
  }
}

TEST_F(StandInControllerTest, CountersWrapAtTheirBits) {
  for (const int bits : {12, 15, 16}) {
    robot_.pose = {};
    make({.counter_bits = bits});
    connect();
    const int modulus = 1 << bits;
    tell(Command::kVelocity, -3000);
    for (int i = 0; i < 4; ++i) {
      tell(Command::kTurnVelocity, i % 2);
      const Sip sip = drive(seconds(13));
      const auto wrapped = [&](double metres) {
        const long counts = std::lround(1e3 * metres) % modulus;
        return counts < 0 ? counts + modulus : counts;
      };
      const Pose2 there = T_opened_.inverse() * robot_.pose;
      EXPECT_EQ(sip.x, wrapped(there.x_m)) << bits;
      EXPECT_EQ(sip.y, wrapped(there.y_m)) << bits;
    }
    tell(Command::kClose);
    hear();
  }
}

TEST_F(StandInControllerTest, TheOriginIsWhereItWasOpenedOrSet) {
  make();
  connect();
  tell(Command::kVelocity, 300);
  tell(Command::kTurnVelocity, 30);
  drive(seconds(3));
  tell(Command::kSetOrigin);
  tell(Command::kStop);
  Sip sip = drive(milliseconds(300));
  EXPECT_LE(sip.x, 5);
  EXPECT_LE(std::abs(sip.theta), 5);
  tell(Command::kVelocity, 300);
  sip = drive(seconds(1));
  EXPECT_NEAR(sip.x, 300, 5);  // ahead, wherever that is
  EXPECT_LE(static_cast<std::int16_t>(sip.y), 5);
}

TEST_F(StandInControllerTest, ItsWatchdogStopsItAndItRevivesByItself) {
  make({.watchdog_ms = 700});
  connect();
  tell(Command::kVelocity, 500);
  hear(milliseconds(690));
  EXPECT_GT(speed_now(), 0.4);
  hear(milliseconds(40));
  EXPECT_EQ(speed_now(), 0);
  hear(seconds(5));
  EXPECT_EQ(speed_now(), 0);
  tell(Bytes{0xFA, 0xFB, 0x03, 0x00, 0x00, 0x01});  // a wrong checksum wakes nobody
  hear(milliseconds(50));
  EXPECT_EQ(speed_now(), 0);
  tell(Command::kPulse);
  hear(milliseconds(50));
  EXPECT_NEAR(speed_now(), 0.5, 1e-9);
}

TEST_F(StandInControllerTest, VelocitiesAreDeadWhileTheMotorsAreOff) {
  make();
  connect();
  tell(Command::kEnable, 0);
  tell(Command::kVelocity, 500);
  tell(Command::kTurnBy, 90);
  Sip sip = drive(seconds(1));
  EXPECT_FALSE(sip.moving);
  EXPECT_EQ(sip.flags & kFlagMotorsOn, 0);
  tell(Command::kEnable, 1);
  EXPECT_FALSE(drive(seconds(1)).moving);
  tell(Command::kVelocity, 500);
  EXPECT_TRUE(drive(seconds(1)).moving);
  tell(Command::kEnable, 0);
  EXPECT_FALSE(drive(seconds(1)).moving);
}

TEST_F(StandInControllerTest, KeepsToTheAccelerationsAndSpeedsThatAreSet) {
  make();
  connect();
  tell(Command::kSetMaxSpeed, 400);
  tell(Command::kSetMaxTurn, 50);
  tell(Command::kSetAcceleration, 500);
  tell(Command::kSetAcceleration, -200);
  tell(Command::kSetTurnAcceleration, 100);
  tell(Command::kSetTurnAcceleration, -50);
  tell(Command::kVelocity, 1000);
  tell(Command::kTurnVelocity, -80);
  drive(milliseconds(400));
  EXPECT_NEAR(speed_now(), 0.2, 0.5 * kPeriod_s * 1.01);
  EXPECT_NEAR(turn_now(), deg_to_rad(-40), deg_to_rad(100) * kPeriod_s * 1.01);
  drive(seconds(1));
  EXPECT_NEAR(speed_now(), 0.4, 1e-9);
  EXPECT_NEAR(turn_now(), deg_to_rad(-50), 1e-9);
  tell(Command::kStop);
  drive(milliseconds(500));
  EXPECT_NEAR(speed_now(), 0.3, 0.2 * kPeriod_s * 1.01);
  EXPECT_NEAR(turn_now(), deg_to_rad(-25), deg_to_rad(50) * kPeriod_s * 1.01);
  tell(Command::kEmergencyStop);
  drive(milliseconds(20));
  EXPECT_EQ(speed_now(), 0);
  EXPECT_EQ(turn_now(), 0);
  tell(Command::kVelocity, 100);  // the motors are on still
  EXPECT_TRUE(drive(seconds(1)).moving);
}

TEST_F(StandInControllerTest, DrivesAndTurnsAsFarAsItIsTold) {
  constexpr double kThere_m = 0.003;  // two millimetres, and a control period's way
  const double kThere_rad = deg_to_rad(0.7);
  Body body = nimble();
  body.max_accel_mps2 = 0.5;
  body.max_turn_accel_radps2 = 1;
  make({}, body);
  connect();
  tell(Command::kSetMaxSpeed, 300);
  tell(Command::kSetMaxTurn, 60);
  tell(Command::kMove, 700);
  drive(seconds(6));
  EXPECT_NEAR(robot_.pose.x_m, 0.7, kThere_m);
  EXPECT_EQ(speed_now(), 0);
  tell(Command::kMove, -200);
  drive(seconds(4));
  EXPECT_NEAR(robot_.pose.x_m, 0.5, 2 * kThere_m);
  tell(Command::kHead, 90);
  drive(seconds(5));
  EXPECT_NEAR(robot_.pose.theta_rad, deg_to_rad(90), kThere_rad);
  tell(Command::kTurnBy, -30);
  tell(Command::kTurnByFromSetpoint, -15);
  const Sip sip = drive(seconds(5));
  EXPECT_NEAR(robot_.pose.theta_rad, deg_to_rad(45), 2 * kThere_rad);
  EXPECT_NEAR(sip.control * find_model("p3dx-sh")->angle_rad, deg_to_rad(45), kThere_rad);
  EXPECT_EQ(turn_now(), 0);
  tell(Command::kRotate, 20);
  drive(seconds(1));
  EXPECT_NEAR(turn_now(), deg_to_rad(20), 1e-9);
}

TEST_F(StandInControllerTest, TakesTheVelocityOfEachWheel) {
  make();
  connect();
  tell(Command::kWheelVelocities, 20 << 8 | 10);  // 0.4 m/s left, 0.2 m/s right
  Sip sip = drive(milliseconds(300));
  EXPECT_NEAR(sip.left, 400, 1);
  EXPECT_NEAR(sip.right, 200, 1);
  tell(Command::kWheelVelocities, -(10 << 8) | 5);  // -0.2 m/s left, less a carry
  sip = drive(milliseconds(300));
  EXPECT_NEAR(sip.left, -200, 1);
  EXPECT_NEAR(sip.right, 100, 1);
}

TEST_F(StandInControllerTest, BumpersAreCountedClockwiseFromTheLeftInFrontFromTheRightBehind) {
  make();
  connect();
  const auto pressed = [&](std::vector<double> bearings_deg) {
    robot_.bearings_rad.clear();
    for (const double deg : bearings_deg) {
      robot_.bearings_rad.push_back(deg_to_rad(deg));
    }
    const Sip sip = drive(milliseconds(200));
    return std::pair<int, int>(sip.front_bumpers, sip.rear_bumpers);
  };
  EXPECT_EQ(pressed({0}), std::pair(0b00100, 0));
  EXPECT_EQ(pressed({80, 30, -30, -80}), std::pair(0b11011, 0));
  EXPECT_EQ(pressed({180, -179}), std::pair(0, 0b00100));
  EXPECT_EQ(pressed({-100}), std::pair(0, 0b00001));
  EXPECT_EQ(pressed({100}), std::pair(0, 0b10000));
  EXPECT_EQ(pressed({}), std::pair(0, 0));
  robot_.held = true;  // nobody knows where
  EXPECT_EQ(pressed({}), std::pair(0b11111, 0b11111));
}

TEST_F(StandInControllerTest, AHeldWheelStallsAndABumperCanBeToldToHoldIt) {
  make();
  connect();
  robot_.held = true;
  robot_.bearings_rad = {0.1};
  EXPECT_FALSE(drive(milliseconds(300)).left_stalled);  // it is told nothing
  tell(Command::kVelocity, 300);
  Sip sip = drive(milliseconds(300));
  EXPECT_TRUE(sip.left_stalled && sip.right_stalled);
  tell(Command::kVelocity, -300);
  EXPECT_FALSE(drive(milliseconds(300)).left_stalled);
  robot_.held = false;  // it is touched, and could go on
  tell(Command::kVelocity, 300);
  EXPECT_FALSE(drive(milliseconds(300)).left_stalled);
  EXPECT_GT(speed_now(), 0.2);
  tell(Command::kBumpStall, 2);
  EXPECT_FALSE(drive(milliseconds(300)).left_stalled);  // of the rear ones
  tell(Command::kBumpStall, 1);
  EXPECT_TRUE(drive(milliseconds(300)).left_stalled);
  EXPECT_EQ(speed_now(), 0);
  tell(Command::kVelocity, -300);
  EXPECT_FALSE(drive(milliseconds(300)).left_stalled);
  EXPECT_LT(speed_now(), -0.2);
}

TEST_F(StandInControllerTest, CountsTheTicksOfItsWheels) {
  make();
  connect();
  const auto encoders = [&](Duration during) {
    std::vector<Bytes> packets;
    for (const Bytes& payload : hear(during)) {
      if (payload[0] == kEncoderPacket) {
        packets.push_back(payload);
      }
    }
    return packets;
  };
  const auto left = [](const Bytes& payload) {
    return static_cast<std::int32_t>(payload[1] | payload[2] << 8 | payload[3] << 16 |
                                     static_cast<unsigned>(payload[4]) << 24);
  };
  tell(Command::kVelocity, -200);
  EXPECT_THAT(encoders(seconds(1)), IsEmpty());
  tell(Command::kEncoder, 1);
  const std::vector<Bytes> once = encoders(seconds(1));
  ASSERT_THAT(once, SizeIs(1));
  EXPECT_NEAR(left(once[0]), -200 * 128, 200 * 128 * kPeriod_s * 1.01);
  tell(Command::kEncoder, 2);
  EXPECT_THAT(encoders(seconds(1)), SizeIs(10));
  tell(Command::kEncoder, 0);
  EXPECT_THAT(encoders(seconds(1)), IsEmpty());
}

TEST_F(StandInControllerTest, TheBaudStaysUntilAReset) {
  make();
  connect();
  EXPECT_EQ(controller_->baud(), 9600);
  tell(Command::kHostBaud, 9);
  EXPECT_EQ(controller_->baud(), 9600);
  tell(Command::kHostBaud, 4);
  EXPECT_EQ(controller_->baud(), 115'200);
  tell(Command::kClose);
  EXPECT_EQ(controller_->baud(), 115'200);
  tell(Command::kReset);
  EXPECT_EQ(controller_->baud(), 9600);
  EXPECT_FALSE(controller_->open());
}

TEST_F(StandInControllerTest, GarbageAroundAndInsideOfFramesDoesNotStopIt) {
  make();
  connect();
  Rng rng(5);
  for (int i = 0; i < 300; ++i) {
    Bytes bytes(static_cast<std::size_t>(rng.index(40)));
    for (std::uint8_t& byte : bytes) {
      byte = rng.index(4) == 0 ? 0xFA : static_cast<std::uint8_t>(rng.index(256));
    }
    const Bytes cut = command_frame(Command::kVelocity, 77);
    bytes.insert(bytes.end(), cut.begin(), cut.begin() + rng.index(9));
    const Bytes whole = command_frame(Command::kVelocity, i);
    bytes.insert(bytes.end(), whole.begin(), whole.end());
    tell(bytes);
    hear(milliseconds(20));
    ASSERT_NEAR(speed_now(), 1e-3 * i, 1e-9);
  }
}

TEST_F(StandInControllerTest, WhatItDoesNotKnowOrCannotReadItIgnores) {
  make();
  connect();
  for (int number = 0; number < 256; ++number) {
    if (number != 2 && number != 253) {
      tell(arcos_frame(Bytes{static_cast<std::uint8_t>(number)}));
      tell(arcos_frame(Bytes{static_cast<std::uint8_t>(number), 0x3B}));
      tell(arcos_frame(Bytes{static_cast<std::uint8_t>(number), 0x2B, 9, 1}));
    }
  }
  EXPECT_TRUE(controller_->open());
  EXPECT_FALSE(drive(seconds(1)).moving);
}

TEST(StandInOptions, AreReadWithAllTheirErrors) {
  try {
    read_settings_text<StandInOptions>(
        "subclass: p3dx-xx\ncounter_bits: 14\nhost_baud: 300\nwatchdog_ms: 1\n", "s.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("subclass: must be one of p3dx-sh, "));
    EXPECT_THAT(error.what(), testing::HasSubstr("counter_bits: must be 12, 15 or 16"));
    EXPECT_THAT(error.what(), testing::HasSubstr("host_baud: must be 9600, "));
    EXPECT_THAT(error.what(), testing::HasSubstr("watchdog_ms: must be from 100 to 60000"));
  }
}

}  // namespace
}  // namespace panoptes::hw
