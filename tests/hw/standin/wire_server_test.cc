// SPDX-License-Identifier: BSD-3-Clause
#include "hw/standin/wire_server.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hw/pioneer/report.h"

namespace panoptes::hw {
namespace {

using std::chrono::milliseconds;

/// Stands, and its time goes on.
class StillRobot final : public Robot {
 public:
  Observation observe(Time deadline) override {
    Observation seen;
    seen.stamp = now_ = std::max(now_, deadline);
    return seen;
  }
  void drive(const Twist2& /*command_body*/, Duration /*valid_for*/) override {}
  void stop() override {}
  Time now() const override { return now_; }
  Timing timing() const override {
    return {std::chrono::milliseconds(67), std::chrono::milliseconds(8)};
  }
  std::optional<Truth> truth() const override { return std::nullopt; }

 private:
  Time now_;
};

/// A client that is there as long as it is told to.
struct Wire {
  bool there = true;
  std::optional<int> baud;
  Bytes to_robot;
  PacketReader from_robot;
  std::vector<Bytes> heard;
};

class WireEnd final : public Endpoint {
 public:
  explicit WireEnd(Wire& wire) : wire_(wire) {}
  const std::string& name() const override { return name_; }
  Bytes read() override { return std::exchange(wire_.to_robot, {}); }
  void write(std::span<const std::uint8_t> bytes) override {
    for (const PacketReader::Packet& packet : wire_.from_robot.read(bytes)) {
      wire_.heard.push_back(packet.payload);
    }
  }
  bool connected() const override { return wire_.there; }
  int fd() const override { return -1; }
  std::optional<int> client_baud() const override { return wire_.baud; }

 private:
  Wire& wire_;
  std::string name_ = "wire";
};

class WireServerTest : public testing::Test {
 protected:
  void serve(Wire& first, Wire* second = nullptr) {
    std::vector<std::unique_ptr<Endpoint>> ends;
    ends.push_back(std::make_unique<WireEnd>(first));
    if (second != nullptr) {
      ends.push_back(std::make_unique<WireEnd>(*second));
    }
    server_.emplace(controller_, std::move(ends));
  }

  void turn_until(Time end) {
    while (controller_.now() < end) {
      server_->turn([this] {
        ++seconds_caught_up_;
        return true;
      });
    }
  }
  void turn_for(Duration during) { turn_until(controller_.now() + during); }

  static Bytes opening() {
    Bytes all;
    for (const Bytes& frame : {command_frame(Command::kPulse), command_frame(Command::kOpen),
                               command_frame(Command::kClose), command_frame(Command::kOpen, 1)}) {
      all.insert(all.end(), frame.begin(), frame.end());
    }
    return all;
  }

  StillRobot robot_;
  StandInController controller_{robot_, Body{}, {}};
  std::optional<WireServer> server_;
  int seconds_caught_up_ = 0;
};

TEST_F(WireServerTest, TheFirstWhoComesIsServedUntilItLeaves) {
  Wire first;
  Wire second;
  first.to_robot = opening();
  second.to_robot = command_frame(Command::kHostBaud, 4);
  serve(first, &second);
  turn_for(milliseconds(350));
  EXPECT_GE(first.heard.size(), 4U);
  EXPECT_EQ(first.from_robot.skipped_bytes(), 0U);
  EXPECT_EQ(second.heard.size(), 0U);
  EXPECT_EQ(controller_.baud(), 9600);
  first.there = false;
  turn_for(milliseconds(250));
  EXPECT_GE(second.heard.size(), 1U);  // the robot streams on
}

TEST_F(WireServerTest, ASerialClientHearsAPacketWhenItsLastBitIsThrough) {
  Wire wire;
  wire.baud = 9600;
  wire.to_robot = opening();
  serve(wire);
  turn_for(milliseconds(20));  // 6 bytes through, then 6, and 30
  EXPECT_LT(wire.heard.size(), 3U);
  turn_for(milliseconds(200));
  EXPECT_GE(wire.heard.size(), 3U);
}

TEST_F(WireServerTest, AtAnotherBaudBothHearGarbage) {
  Wire wire;
  wire.baud = 38400;
  wire.to_robot = opening();
  serve(wire);
  turn_for(milliseconds(300));
  EXPECT_FALSE(controller_.open());
  wire.baud = 9600;
  wire.to_robot = opening();
  turn_for(milliseconds(300));
  EXPECT_TRUE(controller_.open());
  wire.heard.clear();
  wire.from_robot.clear();
  wire.baud = 57600;
  turn_for(milliseconds(300));
  EXPECT_EQ(wire.heard.size(), 0U);
  EXPECT_GT(wire.from_robot.bytes(), 0U);
}

TEST_F(WireServerTest, AfterAPauseItCatchesUpWithoutWhatIsOutOfDate) {
  Wire wire;
  wire.to_robot = opening();
  serve(wire);
  turn_for(milliseconds(150));
  const std::size_t before = wire.heard.size();
  const Time paused = controller_.now();
  std::this_thread::sleep_for(milliseconds(1200));
  turn_until(paused + milliseconds(1150));
  EXPECT_EQ(seconds_caught_up_, 1);
  EXPECT_LE(wire.heard.size() - before, 2U);  // of twelve reports
  turn_for(milliseconds(350));
  EXPECT_GE(wire.heard.size() - before, 2U);
}

}  // namespace
}  // namespace panoptes::hw
