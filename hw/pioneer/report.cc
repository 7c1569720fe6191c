// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/report.h"

#include <type_traits>

namespace panoptes::hw {
namespace {

// Little-endian fields one after the other. Once something is missing nothing more is read.
class FieldReader {
 public:
  explicit FieldReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <class T>
  void operator()(T& value) {
    if (bytes_.size() < sizeof(T)) {
      whole_ = false;
      bytes_ = {};
      return;
    }
    std::make_unsigned_t<T> read = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      read = static_cast<std::make_unsigned_t<T>>(read | bytes_[i] << (8 * i));
    }
    value = static_cast<T>(read);
    bytes_ = bytes_.subspan(sizeof(T));
  }

  void operator()(std::string& text) {
    text.clear();
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      if (bytes_[i] == 0) {
        bytes_ = bytes_.subspan(i + 1);
        return;
      }
      text += static_cast<char>(bytes_[i]);
    }
    whole_ = false;
    bytes_ = {};
  }

  template <class T>
  void operator()(std::optional<T>& value) {
    T read{};
    (*this)(read);
    if (whole_) {
      value = read;
    }
  }

  bool whole() const { return whole_; }

 private:
  std::span<const std::uint8_t> bytes_;
  bool whole_ = true;
};

class FieldWriter {
 public:
  explicit FieldWriter(std::uint8_t type) { bytes_.push_back(type); }

  template <class T>
  void operator()(const T& value) {
    const auto bits = static_cast<std::make_unsigned_t<T>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(bits >> (8 * i) & 0xFF));
    }
  }

  void operator()(const std::string& text) {
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }

  template <class T>
  void operator()(const std::optional<T>& value) {
    ended_ = ended_ || !value;
    if (!ended_) {
      (*this)(*value);
    }
  }

  Bytes bytes() { return std::move(bytes_); }

 private:
  Bytes bytes_;
  bool ended_ = false;
};

template <class Config, class Field>
void config_fields(Config& c, Field& f) {
  std::uint8_t unused = 0;
  f(c.class_name);
  f(c.subclass);
  f(c.serial);
  f(unused);
  f(c.top_turn_degps);
  f(c.top_speed_mmps);
  f(c.top_turn_accel_degps2);
  f(c.top_accel_mmps2);
  f(c.most_pwm);
  f(c.name);
  f(c.sip_cycle_ms);
  f(c.host_baud);
  f(c.aux_baud);
  f(c.has_gripper);
  f(c.has_front_sonar);
  f(c.has_rear_sonar);
  f(c.low_battery_dv);
  f(c.rev_count);
  f(c.watchdog_ms);
  f(unused);
  f(c.stall_pwm);
  f(c.stall_count);
  f(c.joy_speed_mmps);
  f(c.joy_turn_degps);
  f(c.max_turn_degps);
  f(c.max_speed_mmps);
  f(c.turn_accel_degps2);
  f(c.turn_decel_degps2);
  for (auto& gain : c.turn_pid) {
    f(gain);
  }
  f(c.accel_mmps2);
  f(c.decel_mmps2);
  for (auto& gain : c.pid) {
    f(gain);
  }
  f(c.front_bumpers);
  f(c.rear_bumpers);
  f(c.charger);
  f(c.sonar_cycle);
  f(c.autobaud);
  f(c.gyro);
  f(c.drift_factor);
  f(c.aux2_baud);
  f(c.aux3_baud);
  f(c.ticks_per_mm);
  f(c.shutdown_dv);
  f(c.firmware);
}

}  // namespace

std::optional<Sip> read_sip(std::span<const std::uint8_t> payload) {
  if (payload.empty() || (payload[0] != kSipStopped && payload[0] != kSipMoving)) {
    return std::nullopt;
  }
  Sip sip;
  sip.moving = payload[0] == kSipMoving;
  FieldReader f(payload.subspan(1));
  std::uint8_t left_stall = 0;
  std::uint8_t right_stall = 0;
  std::uint8_t sonars = 0;
  f(sip.x);
  f(sip.y);
  f(sip.theta);
  f(sip.left);
  f(sip.right);
  f(sip.battery_dv);
  f(left_stall);
  f(right_stall);
  f(sip.control);
  f(sip.flags);
  f(sip.compass);
  f(sonars);
  sip.left_stalled = (left_stall & 1) != 0;
  sip.right_stalled = (right_stall & 1) != 0;
  sip.rear_bumpers = left_stall >> 1;
  sip.front_bumpers = right_stall >> 1;
  for (int i = 0; i < sonars && f.whole(); ++i) {
    std::uint8_t index = 0;
    std::uint16_t range = 0;
    f(index);
    f(range);
    sip.sonar.push_back({index, range});
  }
  f(sip.gripper);
  f(sip.analog_port);
  f(sip.analog);
  f(sip.digital_in);
  f(sip.digital_out);
  if (!f.whole()) {
    return std::nullopt;
  }
  f(sip.battery_fine_dv);
  f(sip.charge_stage);
  f(sip.turn_velocity);
  f(sip.faults);
  return sip;
}

Bytes sip_payload(const Sip& sip) {
  FieldWriter f(sip.moving ? kSipMoving : kSipStopped);
  f(sip.x);
  f(sip.y);
  f(sip.theta);
  f(sip.left);
  f(sip.right);
  f(sip.battery_dv);
  f(static_cast<std::uint8_t>(sip.rear_bumpers << 1 | (sip.left_stalled ? 1 : 0)));
  f(static_cast<std::uint8_t>(sip.front_bumpers << 1 | (sip.right_stalled ? 1 : 0)));
  f(sip.control);
  f(sip.flags);
  f(sip.compass);
  f(static_cast<std::uint8_t>(sip.sonar.size()));
  for (const SonarReading& reading : sip.sonar) {
    f(static_cast<std::uint8_t>(reading.index));
    f(static_cast<std::uint16_t>(reading.range));
  }
  f(sip.gripper);
  f(sip.analog_port);
  f(sip.analog);
  f(sip.digital_in);
  f(sip.digital_out);
  f(sip.battery_fine_dv);
  f(sip.charge_stage);
  f(sip.turn_velocity);
  f(sip.faults);
  return f.bytes();
}

std::optional<ControllerConfig> read_config(std::span<const std::uint8_t> payload) {
  if (payload.empty() || payload[0] != kConfigPacket) {
    return std::nullopt;
  }
  ControllerConfig config;
  FieldReader f(payload.subspan(1));
  config_fields(config, f);
  return f.whole() ? std::optional(config) : std::nullopt;
}

Bytes config_payload(const ControllerConfig& config) {
  FieldWriter f(kConfigPacket);
  config_fields(config, f);
  return f.bytes();
}

std::optional<ControllerNames> read_names(std::span<const std::uint8_t> payload) {
  if (payload.empty() || payload[0] != static_cast<std::uint8_t>(Command::kClose)) {
    return std::nullopt;
  }
  ControllerNames names;
  FieldReader f(payload.subspan(1));
  f(names.name);
  f(names.class_name);
  f(names.subclass);
  return f.whole() ? std::optional(names) : std::nullopt;
}

Bytes names_payload(const ControllerNames& names) {
  FieldWriter f(static_cast<std::uint8_t>(Command::kClose));
  f(names.name);
  f(names.class_name);
  f(names.subclass);
  return f.bytes();
}

Bytes encoder_payload(std::int32_t left_ticks, std::int32_t right_ticks) {
  FieldWriter f(kEncoderPacket);
  f(left_ticks);
  f(right_ticks);
  return f.bytes();
}

}  // namespace panoptes::hw
