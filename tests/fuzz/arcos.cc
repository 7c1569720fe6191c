// SPDX-License-Identifier: BSD-3-Clause
// Bytes from a serial line, as a Pioneer's client and as its controller read them.
#include <string>
#include <vector>

#include "hw/pioneer/packet.h"
#include "hw/pioneer/report.h"
#include "hw/standin/controller.h"
#include "tests/fuzz/fuzz.h"

namespace panoptes::fuzz {
namespace {

using hw::Bytes;
using hw::Command;

/// Goes as it is told.
class Runner final : public hw::Robot {
 public:
  Observation observe(Time deadline) override {
    pose_ = pose_ * exp_twist(command_, to_seconds(deadline - now_));
    now_ = deadline;
    Observation seen;
    seen.stamp = now_;
    seen.odometry = {pose_, command_};
    seen.health.bumper_pressed = pose_.x_m > 0.01;
    return seen;
  }
  void drive(const Twist2& command_body, Duration /*valid_for*/) override {
    command_ = command_body;
  }
  void stop() override { command_ = {}; }
  Time now() const override { return now_; }
  Timing timing() const override {
    return {std::chrono::milliseconds(67), std::chrono::milliseconds(8)};
  }
  std::optional<Truth> truth() const override { return std::nullopt; }

 private:
  Pose2 pose_;
  Twist2 command_;
  Time now_;
};

std::string text(const Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

}  // namespace

std::vector<std::string> words() {
  std::vector<std::string> all{"\xFA\xFB", "\xFA", std::string("\xFA\xFB\x03\0\0\0", 6)};
  const std::string opening =
      text(hw::command_frame(Command::kPulse)) + text(hw::command_frame(Command::kOpen)) +
      text(hw::command_frame(Command::kClose)) + text(hw::command_frame(Command::kOpen, 1)) +
      text(hw::command_frame(Command::kEnable, 1));
  all.push_back(opening);
  for (const int number : {5, 6, 7, 8, 9, 10, 11, 12, 13, 18, 19, 21, 22, 23, 28, 32, 44, 50}) {
    for (const int argument : {0, 1, 3, -250, 0x7FFF, -0xFFFF}) {
      all.push_back(text(hw::command_frame(static_cast<Command>(number), argument)));
    }
  }
  all.push_back(text(hw::arcos_frame(hw::sip_payload({}))));
  all.push_back(text(hw::arcos_frame(hw::config_payload({}))));
  all.push_back(text(hw::arcos_frame(hw::names_payload({"a", "Pioneer", "p3dx-sh"}))));
  return all;
}

void read_input(std::string_view bytes) {
  const Bytes all(bytes.begin(), bytes.end());
  hw::PacketReader reader;
  for (const hw::PacketReader::Packet& packet : reader.read(all)) {
    hw::read_command(packet.payload);
    if (const auto sip = hw::read_sip(packet.payload)) {
      hw::arcos_frame(hw::sip_payload(*sip));
    }
    if (const auto config = hw::read_config(packet.payload)) {
      hw::arcos_frame(hw::config_payload(*config));
    }
    if (const auto names = hw::read_names(packet.payload)) {
      hw::arcos_frame(hw::names_payload(*names));
    }
  }
  hw::read_command(all);
  hw::read_sip(all);
  hw::read_config(all);
  hw::read_names(all);

  Runner robot;
  hw::StandInController controller(robot, Body{}, {});
  constexpr std::size_t kPiece_bytes = 50;
  for (std::size_t at = 0; at < all.size(); at += kPiece_bytes) {
    const auto piece = std::span(all).subspan(at, std::min(kPiece_bytes, all.size() - at));
    controller.receive(controller.now() + std::chrono::milliseconds(40), piece);
  }
  controller.advance(controller.now() + std::chrono::seconds(3));
  controller.take_sent();
}

}  // namespace panoptes::fuzz
