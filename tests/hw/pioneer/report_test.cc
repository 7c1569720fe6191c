// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/report.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hw/pioneer/model.h"

namespace panoptes::hw {
namespace {

using testing::SizeIs;

/// The only payload in a frame.
Bytes payload_of(const Bytes& frame) {
  PacketReader reader;
  const std::vector<PacketReader::Packet> packets = reader.read(frame);
  EXPECT_THAT(packets, SizeIs(1));
  EXPECT_EQ(reader.skipped_bytes(), 0U);
  return packets.empty() ? Bytes{} : packets.front().payload;
}

// As AMRISim sends it at rest, sixteen sonars silent.
Bytes simulators_report() {
  Bytes frame{0xFA, 0xFB, 0x56, 0x32};
  frame.resize(frame.size() + 10);  // x y th vL vR
  for (const int byte : {0x82, 0x00, 0x00, 0x00, 0x00, 0x1F, 0x00, 0x00, 0x10}) {
    frame.push_back(static_cast<std::uint8_t>(byte));
  }
  for (std::uint8_t sonar = 0; sonar < 16; ++sonar) {
    frame.insert(frame.end(), {sonar, 0x88, 0x13});
  }
  for (const int byte : {0x00, 0x00, 0x00, 0xFF, 0xFF, 0x82, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                         0x00, 0x00, 0x81, 0x00, 0xE8, 0x2B}) {
    frame.push_back(static_cast<std::uint8_t>(byte));
  }
  return frame;
}

TEST(Sip, OfAnotherSimulatorIsRead) {
  const Bytes frame = simulators_report();
  ASSERT_EQ(frame.size(), 89U);
  const auto sip = read_sip(payload_of(frame));
  ASSERT_TRUE(sip);
  EXPECT_FALSE(sip->moving);
  EXPECT_EQ(sip->x, 0);
  EXPECT_EQ(sip->theta, 0);
  EXPECT_EQ(sip->battery_dv, 130);
  EXPECT_NEAR(sip->battery_v(), 13.0, 1e-9);
  EXPECT_EQ(sip->flags, kFlagMotorsOn | kFlagSonar);
  ASSERT_THAT(sip->sonar, SizeIs(16));
  EXPECT_EQ(sip->sonar[15].index, 15);
  EXPECT_EQ(sip->sonar[15].range, 5000);
  EXPECT_EQ(sip->digital_in, 0xFF);
  EXPECT_EQ(sip->digital_out, 0xFF);
  EXPECT_EQ(sip->battery_fine_dv, 130);
  EXPECT_EQ(sip->charge_stage, 0);
  EXPECT_EQ(sip->turn_velocity, 0);
  EXPECT_EQ(sip->faults, 0);
  // What is read of it is written the same, up to the fields that are not.
  Bytes written = sip_payload(*sip);
  EXPECT_EQ(written,
            Bytes(frame.begin() + 3, frame.begin() + 3 + static_cast<long>(written.size())));
  EXPECT_EQ(frame.size() - 5 - written.size(), 4U);  // lateral velocity, temperature, charge
}

TEST(Sip, HasItsFieldsWhereTheProtocolSays) {
  Sip sip;
  sip.moving = true;
  sip.x = 0x1234;
  sip.y = 0xFFFE;
  sip.theta = -2;
  sip.left = 500;
  sip.right = -500;
  sip.battery_dv = 127;
  sip.left_stalled = true;
  sip.rear_bumpers = 0b00001;
  sip.front_bumpers = 0b10100;
  sip.control = 7;
  sip.flags = 0x0441;
  sip.compass = 9;
  sip.sonar = {{3, 1000}};
  sip.gripper = 1;
  sip.analog_port = 2;
  sip.analog = 3;
  sip.digital_in = 4;
  sip.digital_out = 5;
  EXPECT_EQ(
      sip_payload(sip),
      (Bytes{0x33,     0x34, 0x12, 0xFE, 0xFF, 0xFE, 0xFF, 0xF4, 0x01, 0x0C, 0xFE, 127,
             0b11,  // the rear bumpers over the left wheel's stall
             0b101000, 7,    0,    0x41, 0x04, 9,    1,    3,    0xE8, 0x03, 1,    2,   3, 4, 5}));
  sip.battery_fine_dv = 127;
  sip.charge_stage = 2;
  sip.turn_velocity = -1;
  sip.faults = 0x0102;
  const Bytes whole = sip_payload(sip);
  EXPECT_EQ(Bytes(whole.end() - 7, whole.end()), (Bytes{127, 0, 2, 0xFF, 0xFF, 0x02, 0x01}));
  const auto read = read_sip(whole);
  ASSERT_TRUE(read);
  EXPECT_EQ(sip_payload(*read), whole);
  sip.charge_stage.reset();  // nothing can follow what is absent
  EXPECT_EQ(sip_payload(sip).size(), whole.size() - 5);
}

TEST(Sip, EndsAtAnyOptionalFieldButNotBefore) {
  Sip sip;
  sip.sonar = {{0, 100}, {1, 200}};
  const std::size_t least = sip_payload(sip).size();
  sip.battery_fine_dv = 1;
  sip.charge_stage = 2;
  sip.turn_velocity = 3;
  sip.faults = 4;
  const Bytes whole = sip_payload(sip);
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    const auto read = read_sip(std::span(whole).first(size));
    EXPECT_EQ(read.has_value(), size >= least) << size;
    if (read) {
      EXPECT_EQ(read->battery_fine_dv.has_value(), size >= least + 2);
      EXPECT_EQ(read->charge_stage.has_value(), size >= least + 3);
      EXPECT_EQ(read->turn_velocity.has_value(), size >= least + 5);
      EXPECT_EQ(read->faults.has_value(), size >= least + 7);
    }
  }
  Bytes more = whole;  // newer firmware has more
  more.resize(more.size() + 13);
  EXPECT_TRUE(read_sip(more));
  Bytes other = whole;
  other[0] = 0x34;
  EXPECT_FALSE(read_sip(other));
}

TEST(ControllerNames, OfAnotherSimulatorAreReadAndWrittenTheSame) {
  const std::string names(
      "\x02"
      "AMRISim\0Pioneer\0p3dx\0",
      22);
  Bytes frame{0xFA, 0xFB, 0x18};
  frame.insert(frame.end(), names.begin(), names.end());
  frame.insert(frame.end(), {0xEB, 0xBD});
  const Bytes payload = payload_of(frame);
  const auto read = read_names(payload);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->name, "AMRISim");
  EXPECT_EQ(read->class_name, "Pioneer");
  EXPECT_EQ(read->subclass, "p3dx");
  EXPECT_EQ(arcos_frame(names_payload(*read)), frame);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    EXPECT_FALSE(read_names(std::span(payload).first(size)));
  }
}

TEST(ControllerConfig, HasItsFieldsInTheOrderOfTheProtocol) {
  ControllerConfig config;
  config.class_name = "Pioneer";
  config.subclass = "p3dx-sh";
  config.serial = "7";
  config.top_turn_degps = 500;
  config.name = "n";
  config.sip_cycle_ms = 100;
  config.host_baud = 2;
  config.rev_count = 16570;
  config.watchdog_ms = 2000;
  config.front_bumpers = 5;
  config.rear_bumpers = 6;
  config.drift_factor = -3;
  config.ticks_per_mm = 128;
  config.firmware = "2.9";
  const Bytes payload = config_payload(config);
  const std::string text(payload.begin(), payload.end());
  EXPECT_TRUE(
      text.starts_with(std::string("\x20"
                                   "Pioneer\0p3dx-sh\0"
                                   "7\0",
                                   19)));
  EXPECT_EQ(payload[19], 0);     // unused
  EXPECT_EQ(payload[20], 0xF4);  // 500 deg/s
  EXPECT_EQ(payload[21], 0x01);
  EXPECT_EQ(text.substr(30, 5), (std::string("n\0\x64\x02\0", 5)));
  // 2 gripper, 2 front sonar, 1 rear sonar, 2 low battery
  EXPECT_EQ(payload[42] | payload[43] << 8, 16570);
  EXPECT_EQ(payload[44] | payload[45] << 8, 2000);
  // 1 unused; stall, joystick and velocities 6 x 2; accelerations and gains 2 x (2 x 2 + 3 x 2)
  EXPECT_EQ(payload[79], 5);
  EXPECT_EQ(payload[80], 6);
  // charger, sonar cycle, automatic baud, gyro
  EXPECT_EQ(payload[85], 0xFD);
  EXPECT_EQ(payload[86], 0xFF);
  EXPECT_EQ(payload[89], 128);
  EXPECT_EQ(text.substr(93), std::string("2.9\0", 4));
  const auto read = read_config(payload);
  ASSERT_TRUE(read);
  EXPECT_EQ(config_payload(*read), payload);
  for (std::size_t size = 0; size < payload.size(); ++size) {
    EXPECT_FALSE(read_config(std::span(payload).first(size)));
  }
  Bytes newer = payload;
  newer.resize(newer.size() + 20);
  EXPECT_TRUE(read_config(newer));
}

TEST(EncoderPayload, HasTheLowWordFirst) {
  EXPECT_EQ(encoder_payload(0x01020304, -2),
            (Bytes{0x90, 0x04, 0x03, 0x02, 0x01, 0xFE, 0xFF, 0xFF, 0xFF}));
}

TEST(FindModel, KnowsTheRobotsByTheirSubclass) {
  ASSERT_NE(find_model("p3dx-sh"), nullptr);
  EXPECT_EQ(find_model("p3dx-sh")->distance_m, 1e-3);
  EXPECT_EQ(find_model("p3dx-sh")->turn_rad_per_m, 5.6);
  EXPECT_EQ(find_model("p3dx")->distance_m, 0.485e-3);
  EXPECT_EQ(find_model("p3dx-xx"), nullptr);
  EXPECT_EQ(find_model(""), nullptr);
  EXPECT_THAT(known_models(), testing::Contains("p3dx-sh"));
}

}  // namespace
}  // namespace panoptes::hw
