// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace panoptes::hw {

using Bytes = std::vector<std::uint8_t>;

/// The numbers of the commands that a Pioneer's controller takes (ARCOS and its forerunner P2OS).
enum class Command : std::uint8_t {
  kPulse = 0,  ///< keeps the watchdog quiet; SYNC0 before the link is open
  kOpen = 1,   ///< SYNC1 before
  kClose = 2,  ///< SYNC2 before
  kPolling = 3,
  kEnable = 4,
  kSetAcceleration = 5,       ///< mm/s2, negative: deceleration
  kSetMaxSpeed = 6,           ///< mm/s
  kSetOrigin = 7,             ///< zeroes the controller's odometry
  kMove = 8,                  ///< mm
  kRotate = 9,                ///< deg/s
  kSetMaxTurn = 10,           ///< deg/s
  kVelocity = 11,             ///< mm/s
  kHead = 12,                 ///< to a heading, degrees
  kTurnBy = 13,               ///< degrees
  kSay = 15,                  ///< beeps
  kConfig = 18,               ///< asks for a configuration packet
  kEncoder = 19,              ///< 0 none, 1 one, more: a stream of encoder packets
  kTurnVelocity = 21,         ///< deg/s
  kTurnByFromSetpoint = 22,   ///< degrees
  kSetTurnAcceleration = 23,  ///< deg/s2, negative: deceleration
  kSonar = 28,
  kStop = 29,
  kWheelVelocities = 32,  ///< low byte right, high byte left, signed, 20 mm/s each
  kIoRequest = 40,
  kBumpStall = 44,
  kHostBaud = 50,       ///< 0..4: 9600, 19200, 38400, 57600, 115200
  kEmergencyStop = 55,  ///< regardless of the deceleration that is set
  kEmergencyStall = 56,
  kGyro = 58,
  kBatteryInfo = 62,
  kReset = 253
};

/// The longest payload that a frame can hold: its length byte counts the checksum as well.
constexpr std::size_t kMostPayload_bytes = 253;

/// Over a payload: its big-endian 16-bit words added, an odd last byte exclusive-or'd. Weak: words
/// exchanged, or errors that cancel, pass.
std::uint16_t arcos_checksum(std::span<const std::uint8_t> payload);

/// FA FB, the length of what follows, the payload, the checksum with its high byte first.
Bytes arcos_frame(std::span<const std::uint8_t> payload);

/// Frames of commands: without argument, with a number (its sign is in its type, -65535..65535),
/// with text.
Bytes command_frame(Command command);
Bytes command_frame(Command command, int argument);
Bytes command_frame(Command command, std::string_view argument);

struct CommandPacket {
  Command command = Command::kPulse;
  std::variant<std::monostate, int, std::string> argument;
};

/// A command's payload as a controller reads it; empty where its argument is cut short or of no
/// known type. A number whose type says positive but is over 0x7FFF is read as two's complement,
/// which sloppy clients send.
std::optional<CommandPacket> read_command(std::span<const std::uint8_t> payload);

/// Finds frames in a stream of bytes that may be damaged. After a frame that is not right it looks
/// for the next header inside of it; and while it waits for the rest of a long one it takes a whole
/// frame that is in it, so that a damaged length does not swallow what follows.
class PacketReader {
 public:
  struct Packet {
    Bytes payload;
    std::size_t end = 0;  ///< index after its last byte, among all bytes ever read
  };

  /// The payloads of the frames that these bytes complete, in order.
  std::vector<Packet> read(std::span<const std::uint8_t> bytes);

  void clear();  ///< forgets what was begun: the line is another one now

  std::size_t bytes() const { return bytes_; }
  std::size_t bad_frames() const { return bad_frames_; }  ///< headers that no right frame followed
  std::size_t skipped_bytes() const { return skipped_bytes_; }  ///< in no frame
  std::size_t resyncs() const { return resyncs_; }  ///< right frames that came after skipped bytes

 private:
  void skip(std::size_t count);

  Bytes pending_;
  std::size_t bytes_ = 0;
  std::size_t bad_frames_ = 0;
  std::size_t skipped_bytes_ = 0;
  std::size_t resyncs_ = 0;
  bool in_step_ = true;
};

}  // namespace panoptes::hw
