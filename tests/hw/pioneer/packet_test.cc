// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/packet.h"

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/base/rng.h"

namespace panoptes::hw {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

Bytes joined(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const Bytes& part : parts) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

std::vector<Bytes> payloads(PacketReader& reader, std::span<const std::uint8_t> bytes) {
  std::vector<Bytes> all;
  for (const PacketReader::Packet& packet : reader.read(bytes)) {
    all.push_back(packet.payload);
  }
  return all;
}

/// A frame as other programs send it on a real wire, and what it means.
struct Golden {
  Bytes frame;
  Command command;
  std::variant<std::monostate, int, std::string> argument;
};

// Worked examples of the protocol, and all that AriaCoda sends from its first byte to its last.
const std::vector<Golden>& golden() {
  static const std::vector<Golden> kAll = {
      {{0xFA, 0xFB, 0x03, 0x00, 0x00, 0x00}, Command::kPulse, {}},
      {{0xFA, 0xFB, 0x03, 0x01, 0x00, 0x01}, Command::kOpen, {}},
      {{0xFA, 0xFB, 0x03, 0x02, 0x00, 0x02}, Command::kClose, {}},
      {{0xFA, 0xFB, 0x06, 0x0B, 0x3B, 0xFA, 0x00, 0x05, 0x3B}, Command::kVelocity, 250},
      {{0xFA, 0xFB, 0x06, 0x0B, 0x1B, 0xFA, 0x00, 0x05, 0x1B}, Command::kVelocity, -250},
      {{0xFA, 0xFB, 0x06, 0x15, 0x1B, 0x0A, 0x00, 0x1F, 0x1B}, Command::kTurnVelocity, -10},
      {{0xFA, 0xFB, 0x07, 0x03, 0x2B, 0x02, 0x01, 0x02, 0x05, 0x2E},
       Command::kPolling,
       std::string("\x01\x02")},
      {{0xFA, 0xFB, 0x06, 0x04, 0x3B, 0x01, 0x00, 0x05, 0x3B}, Command::kEnable, 1},
      {{0xFA, 0xFB, 0x03, 0x1D, 0x00, 0x1D}, Command::kStop, {}},
      {{0xFA, 0xFB, 0x03, 0x37, 0x00, 0x37}, Command::kEmergencyStop, {}},
      {{0xFA, 0xFB, 0x06, 0x01, 0x3B, 0x01, 0x00, 0x02, 0x3B}, Command::kOpen, 1},
      {{0xFA, 0xFB, 0x06, 0x12, 0x3B, 0x01, 0x00, 0x13, 0x3B}, Command::kConfig, 1},
      {{0xFA, 0xFB, 0x06, 0x32, 0x3B, 0x02, 0x00, 0x34, 0x3B}, Command::kHostBaud, 2},
      {{0xFA, 0xFB, 0x06, 0x3E, 0x3B, 0x01, 0x00, 0x3F, 0x3B}, Command::kBatteryInfo, 1},
      {{0xFA, 0xFB, 0x06, 0x06, 0x3B, 0xB8, 0x0B, 0xBE, 0x46}, Command::kSetMaxSpeed, 3000},
      {{0xFA, 0xFB, 0x06, 0x05, 0x3B, 0x2C, 0x01, 0x31, 0x3C}, Command::kSetAcceleration, 300},
      {{0xFA, 0xFB, 0x06, 0x05, 0x1B, 0x2C, 0x01, 0x31, 0x1C}, Command::kSetAcceleration, -300},
      {{0xFA, 0xFB, 0x06, 0x0A, 0x3B, 0x96, 0x00, 0xA0, 0x3B}, Command::kSetMaxTurn, 150},
      {{0xFA, 0xFB, 0x06, 0x17, 0x3B, 0x64, 0x00, 0x7B, 0x3B}, Command::kSetTurnAcceleration, 100},
      {{0xFA, 0xFB, 0x06, 0x17, 0x1B, 0x64, 0x00, 0x7B, 0x1B}, Command::kSetTurnAcceleration, -100},
      {{0xFA, 0xFB, 0x06, 0x02, 0x3B, 0x01, 0x00, 0x03, 0x3B}, Command::kClose, 1},
  };
  return kAll;
}

TEST(CommandFrame, IsWhatOthersSendByteForByte) {
  for (const Golden& one : golden()) {
    const Bytes frame = std::holds_alternative<int>(one.argument)
                            ? command_frame(one.command, std::get<int>(one.argument))
                        : std::holds_alternative<std::string>(one.argument)
                            ? command_frame(one.command, std::get<std::string>(one.argument))
                            : command_frame(one.command);
    EXPECT_EQ(frame, one.frame) << static_cast<int>(one.command);
  }
}

TEST(ReadCommand, UnderstandsWhatOthersSend) {
  PacketReader reader;
  for (const Golden& one : golden()) {
    const std::vector<Bytes> found = payloads(reader, one.frame);
    ASSERT_THAT(found, SizeIs(1)) << static_cast<int>(one.command);
    const auto packet = read_command(found.front());
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->command, one.command);
    EXPECT_EQ(packet->argument, one.argument);
  }
  EXPECT_EQ(reader.bad_frames() + reader.skipped_bytes() + reader.resyncs(), 0U);
}

TEST(ReadCommand, TakesTwosComplementFromSloppyClients) {
  const auto argument = [](const Bytes& payload) {
    return std::get<int>(read_command(payload)->argument);
  };
  EXPECT_EQ(argument({11, 0x3B, 0x06, 0xFF}), -250);
  EXPECT_EQ(argument({11, 0x3B, 0xFF, 0x7F}), 0x7FFF);
  EXPECT_EQ(argument({11, 0x1B, 0xFF, 0xFF}), -0xFFFF);
}

TEST(ReadCommand, RefusesAnArgumentThatIsCutShortOrOfNoKnownType) {
  for (const Bytes& payload : std::vector<Bytes>{{},
                                                 {11, 0x3B},
                                                 {11, 0x3B, 1},
                                                 {11, 0x1B, 1},
                                                 {11, 0x2B},
                                                 {11, 0x2B, 2, 1},
                                                 {11, 0x00, 1, 1}}) {
    EXPECT_FALSE(read_command(payload));
  }
}

TEST(ArcosFrame, HoldsAsMuchAsItsLengthByteCanSay) {
  PacketReader reader;
  const Bytes longest(kMostPayload_bytes, 0xFA);
  EXPECT_THAT(payloads(reader, arcos_frame(longest)), ElementsAre(longest));
  EXPECT_THROW(arcos_frame(Bytes(kMostPayload_bytes + 1)), CheckError);
  EXPECT_THROW(arcos_frame(Bytes{}), CheckError);
}

TEST(PacketReader, FindsFramesHoweverTheyAreCut) {
  std::vector<Bytes> frames;
  for (const Golden& one : golden()) {
    frames.push_back(one.frame);
  }
  const Bytes all = joined(frames);
  PacketReader reader;
  std::size_t found = 0;
  std::size_t end = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const PacketReader::Packet& packet : reader.read(std::span(all).subspan(i, 1))) {
      end += frames[found++].size();
      EXPECT_EQ(packet.end, end);
      EXPECT_EQ(packet.end, i + 1);  // no later than its last byte
    }
  }
  EXPECT_EQ(found, frames.size());
  EXPECT_EQ(reader.bytes(), all.size());
}

TEST(PacketReader, ADamagedFrameCostsNoOther) {
  const Bytes good = command_frame(Command::kVelocity, 250);
  Rng rng(3);
  for (int i = 0; i < 2000; ++i) {
    Bytes damaged = command_frame(Command::kTurnVelocity, rng.index(1000));
    const auto at = static_cast<std::size_t>(rng.index(static_cast<int>(damaged.size())));
    damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ 1 << rng.index(8));  // of length, too
    PacketReader reader;
    const std::vector<Bytes> found = payloads(reader, joined({good, damaged, good, good}));
    ASSERT_GE(std::count(found.begin(), found.end(), Bytes(good.begin() + 3, good.end() - 2)), 3);
    ASSERT_LE(found.size(), 4U);
  }
}

TEST(PacketReader, ADoubledHeaderLosesNothing) {
  const Bytes good = command_frame(Command::kStop);
  PacketReader reader;
  EXPECT_THAT(payloads(reader, joined({{0xFA}, good, {0xFA, 0xFB}, good})), SizeIs(2));
  EXPECT_EQ(reader.skipped_bytes(), 3U);
  EXPECT_EQ(reader.bad_frames(), 1U);
  EXPECT_EQ(reader.resyncs(), 2U);
}

TEST(PacketReader, ALengthThatNoFrameHasIsRejectedAtOnce) {
  for (const std::uint8_t length : {0, 1, 2}) {
    PacketReader reader;
    EXPECT_THAT(payloads(reader, Bytes{0xFA, 0xFB, length}), IsEmpty());
    EXPECT_EQ(reader.bad_frames(), 1U);
    EXPECT_EQ(reader.skipped_bytes(), 3U);
  }
}

TEST(PacketReader, ForgetsWhatWasBegun) {
  const Bytes frame = command_frame(Command::kVelocity, 250);
  PacketReader reader;
  reader.read(std::span(frame).first(5));
  reader.clear();
  EXPECT_THAT(payloads(reader, std::span(frame).subspan(5)), IsEmpty());
  EXPECT_THAT(payloads(reader, frame), SizeIs(1));
}

}  // namespace
}  // namespace panoptes::hw
