// SPDX-License-Identifier: BSD-3-Clause
#include "hw/standin/controller.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  std::optional<Truth> truth() const override { return std::nullopt; }

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
    tell(Command::kEnable, 1);
    hear();
  }

  FloorRobot robot_;
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

}  // namespace
}  // namespace panoptes::hw
