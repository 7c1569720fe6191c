// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/packet.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "core/base/check.h"

namespace panoptes::hw {
namespace {

constexpr std::uint8_t kHeader0 = 0xFA;
constexpr std::uint8_t kHeader1 = 0xFB;
constexpr std::size_t kHeader_bytes = 3;    // with the length
constexpr std::size_t kChecksum_bytes = 2;  // which the length counts
constexpr std::size_t kLeastLength = 1 + kChecksum_bytes;

constexpr std::uint8_t kPositive = 0x3B;
constexpr std::uint8_t kNegative = 0x1B;
constexpr std::uint8_t kText = 0x2B;

enum class Fit { kFrame, kShort, kNone };

// What begins at `at`: a right frame, one that may yet become right, or none.
Fit fit(std::span<const std::uint8_t> bytes, std::size_t at) {
  const std::size_t left = bytes.size() - at;
  if (bytes[at] != kHeader0 || (left > 1 && bytes[at + 1] != kHeader1) ||
      (left > 2 && bytes[at + 2] < kLeastLength)) {
    return Fit::kNone;
  }
  if (left < kHeader_bytes || left < kHeader_bytes + bytes[at + 2]) {
    return Fit::kShort;
  }
  const std::size_t payload = bytes[at + 2] - kChecksum_bytes;
  const std::size_t sum = at + kHeader_bytes + payload;
  const std::uint16_t expected = arcos_checksum(bytes.subspan(at + kHeader_bytes, payload));
  return bytes[sum] == expected >> 8 && bytes[sum + 1] == (expected & 0xFF) ? Fit::kFrame
                                                                            : Fit::kNone;
}

}  // namespace

std::uint16_t arcos_checksum(std::span<const std::uint8_t> payload) {
  unsigned sum = 0;
  for (std::size_t i = 0; i + 1 < payload.size(); i += 2) {
    sum += static_cast<unsigned>(payload[i]) << 8 | payload[i + 1];
  }
  if (payload.size() % 2 == 1) {
    sum ^= payload.back();
  }
  return static_cast<std::uint16_t>(sum & 0xFFFF);
}

Bytes arcos_frame(std::span<const std::uint8_t> payload) {
  PANOPTES_CHECK(!payload.empty() && payload.size() <= kMostPayload_bytes,
                 "a payload fits its length byte");
  Bytes frame(kHeader_bytes + payload.size() + kChecksum_bytes);
  frame[0] = kHeader0;
  frame[1] = kHeader1;
  frame[2] = static_cast<std::uint8_t>(payload.size() + kChecksum_bytes);
  std::copy(payload.begin(), payload.end(), frame.begin() + kHeader_bytes);
  const std::uint16_t sum = arcos_checksum(payload);
  frame[frame.size() - 2] = static_cast<std::uint8_t>(sum >> 8);
  frame[frame.size() - 1] = static_cast<std::uint8_t>(sum & 0xFF);
  return frame;
}

Bytes command_frame(Command command) {
  return arcos_frame(std::array{static_cast<std::uint8_t>(command)});
}

Bytes command_frame(Command command, int argument) {
  const auto size = static_cast<unsigned>(std::abs(argument));
  PANOPTES_CHECK(size <= 0xFFFF, "a command's number fits 16 bits");
  return arcos_frame(
      std::array{static_cast<std::uint8_t>(command), argument < 0 ? kNegative : kPositive,
                 static_cast<std::uint8_t>(size & 0xFF), static_cast<std::uint8_t>(size >> 8)});
}

Bytes command_frame(Command command, std::string_view argument) {
  Bytes payload{static_cast<std::uint8_t>(command), kText,
                static_cast<std::uint8_t>(argument.size())};
  payload.insert(payload.end(), argument.begin(), argument.end());
  return arcos_frame(payload);
}

std::optional<CommandPacket> read_command(std::span<const std::uint8_t> payload) {
  if (payload.empty()) {
    return std::nullopt;
  }
  CommandPacket packet{static_cast<Command>(payload[0]), {}};
  if (payload.size() == 1) {
    return packet;
  }
  if (payload[1] == kText) {
    if (payload.size() < 3 || payload.size() < 3U + payload[2]) {
      return std::nullopt;
    }
    packet.argument = std::string(payload.begin() + 3, payload.begin() + 3 + payload[2]);
    return packet;
  }
  if ((payload[1] != kPositive && payload[1] != kNegative) || payload.size() < 4) {
    return std::nullopt;
  }
  const int size = payload[2] | payload[3] << 8;
  packet.argument = payload[1] == kNegative ? -size : size > 0x7FFF ? size - 0x10000 : size;
  return packet;
}

void PacketReader::skip(std::size_t count) {
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(count));
  skipped_bytes_ += count;
  in_step_ = in_step_ && count == 0;
}

std::vector<PacketReader::Packet> PacketReader::read(std::span<const std::uint8_t> bytes) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  bytes_ += bytes.size();
  std::vector<Packet> packets;
  while (true) {
    // The first right frame, and before it the first place where one may yet come to an end.
    std::optional<std::size_t> unfinished;
    std::optional<std::size_t> found;
    std::size_t wrong = 0;
    std::size_t at = 0;
    for (; at < pending_.size(); ++at) {
      const Fit here = fit(pending_, at);
      if (here == Fit::kFrame) {
        found = at;
        break;
      }
      if (here == Fit::kShort) {
        unfinished = unfinished.value_or(at);
      } else if (pending_[at] == kHeader0 && at + 1 < pending_.size() &&
                 pending_[at + 1] == kHeader1) {
        wrong += unfinished ? 0 : 1;
      }
    }
    if (!found) {
      bad_frames_ += wrong;
      skip(unfinished.value_or(pending_.size()));
      return packets;
    }
    bad_frames_ += wrong + (unfinished ? 1 : 0);
    skip(*found);
    const std::size_t length = kHeader_bytes + pending_[2];
    packets.push_back(
        {Bytes(pending_.begin() + kHeader_bytes,
               pending_.begin() + static_cast<std::ptrdiff_t>(length - kChecksum_bytes)),
         bytes_ - pending_.size() + length});
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(length));
    resyncs_ += in_step_ ? 0 : 1;
    in_step_ = true;
  }
}

void PacketReader::clear() { skip(pending_.size()); }

}  // namespace panoptes::hw
