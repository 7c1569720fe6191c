// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hw/pioneer/packet.h"

namespace panoptes::hw {

/// Types of the packets that a controller sends of its own (0, 1, 2 echo the synchronisation).
constexpr std::uint8_t kSipStopped = 0x32;
constexpr std::uint8_t kSipMoving = 0x33;
constexpr std::uint8_t kConfigPacket = 0x20;
constexpr std::uint8_t kEncoderPacket = 0x90;

/// Bits of Sip::flags.
constexpr std::uint16_t kFlagMotorsOn = 1 << 0;
constexpr std::uint16_t kFlagSonar = 0xF << 1;
constexpr std::uint16_t kFlagStopButton = 1 << 5;
constexpr std::uint16_t kFlagEmergencyStall = 1 << 6;

constexpr double kLowBattery_v = 11.5;  ///< below it a controller misbehaves

struct SonarReading {
  int index = 0;
  int range = 0;  ///< in the controller's units
};

/// A standard server information packet, in the controller's own units (hw/pioneer/model.h turns
/// them into metres). What follows the digital ports is optional on the wire.
struct Sip {
  bool moving = false;
  std::uint16_t x = 0;  ///< counts that wrap
  std::uint16_t y = 0;
  std::int16_t theta = 0;
  std::int16_t left = 0;  ///< wheel velocities
  std::int16_t right = 0;
  std::uint8_t battery_dv = 0;  ///< 0.1 V
  bool left_stalled = false;
  bool right_stalled = false;
  std::uint8_t rear_bumpers = 0;   ///< bit k: segment k + 1
  std::uint8_t front_bumpers = 0;  ///< likewise
  std::int16_t control = 0;
  std::uint16_t flags = 0;
  std::uint8_t compass = 0;
  std::vector<SonarReading> sonar;  ///< new ones
  std::uint8_t gripper = 0;
  std::uint8_t analog_port = 0;
  std::uint8_t analog = 0;
  std::uint8_t digital_in = 0;
  std::uint8_t digital_out = 0;
  std::optional<std::uint16_t> battery_fine_dv = {};  ///< 0.1 V, in two bytes
  std::optional<std::uint8_t> charge_stage = {};
  std::optional<std::int16_t> turn_velocity = {};  ///< 0.1 deg/s
  std::optional<std::uint16_t> faults = {};

  double battery_v() const { return 0.1 * battery_fine_dv.value_or(battery_dv); }
};

/// Reads by what length there is; empty where it ends before the digital ports, has more sonar
/// readings than bytes for them, or is of another type.
std::optional<Sip> read_sip(std::span<const std::uint8_t> payload);

/// The optional fields up to the first that is absent.
Bytes sip_payload(const Sip& sip);

/// What a controller says of itself when it is asked (CONFIG). Newer fields after the version are
/// neither read nor sent.
struct ControllerConfig {
  std::string class_name;
  std::string subclass;
  std::string serial;
  std::uint16_t top_turn_degps = 0;
  std::uint16_t top_speed_mmps = 0;
  std::uint16_t top_turn_accel_degps2 = 0;
  std::uint16_t top_accel_mmps2 = 0;
  std::uint16_t most_pwm = 0;
  std::string name;
  std::uint8_t sip_cycle_ms = 100;
  std::uint8_t host_baud = 0;
  std::uint8_t aux_baud = 0;
  std::uint16_t has_gripper = 0;
  std::uint16_t has_front_sonar = 0;
  std::uint8_t has_rear_sonar = 0;
  std::uint16_t low_battery_dv = 0;
  std::uint16_t rev_count = 0;
  std::uint16_t watchdog_ms = 0;
  std::uint16_t stall_pwm = 0;
  std::uint16_t stall_count = 0;
  std::uint16_t joy_speed_mmps = 0;
  std::uint16_t joy_turn_degps = 0;
  std::uint16_t max_turn_degps = 0;
  std::uint16_t max_speed_mmps = 0;
  std::uint16_t turn_accel_degps2 = 0;
  std::uint16_t turn_decel_degps2 = 0;
  std::uint16_t turn_pid[3] = {};
  std::uint16_t accel_mmps2 = 0;
  std::uint16_t decel_mmps2 = 0;
  std::uint16_t pid[3] = {};
  std::uint8_t front_bumpers = 0;  ///< how many segments
  std::uint8_t rear_bumpers = 0;
  std::uint8_t charger = 0;
  std::uint8_t sonar_cycle = 0;
  std::uint8_t autobaud = 0;
  std::uint8_t gyro = 0;
  std::int16_t drift_factor = 0;
  std::uint8_t aux2_baud = 0;
  std::uint8_t aux3_baud = 0;
  std::uint16_t ticks_per_mm = 0;
  std::uint16_t shutdown_dv = 0;
  std::string firmware;
};

/// Empty where it ends before the firmware's version, or is of another type.
std::optional<ControllerConfig> read_config(std::span<const std::uint8_t> payload);
Bytes config_payload(const ControllerConfig& config);

/// The answer to SYNC2: type 2 and three texts.
struct ControllerNames {
  std::string name;
  std::string class_name;
  std::string subclass;
};
std::optional<ControllerNames> read_names(std::span<const std::uint8_t> payload);
Bytes names_payload(const ControllerNames& names);

/// Both wheels' ticks, as ENCODER asks for them.
Bytes encoder_payload(std::int32_t left_ticks, std::int32_t right_ticks);

}  // namespace panoptes::hw
