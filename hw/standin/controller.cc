// SPDX-License-Identifier: BSD-3-Clause
#include "hw/standin/controller.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/check.h"
#include "core/base/text.h"

namespace panoptes::hw {
namespace {

constexpr std::array kBauds = {9600, 19200, 38400, 57600, 115200};  // as HOSTBAUD numbers them
constexpr int kBitsOfByte = 10;                                     // with start and stop

constexpr Duration kControlPeriod = std::chrono::milliseconds(10);
constexpr Duration kCommandValidFor = std::chrono::milliseconds(100);
// Answers that would have to wait for the line longer than this are lost.
constexpr Duration kMostWaiting = std::chrono::seconds(1);

// Way and turn that a goal needs not be nearer than: about two ticks of the wheels.
constexpr double kThere_m = 0.002;
const double kThere_rad = deg_to_rad(0.5);
// Of the deceleration, so that a goal is not overrun by what a control period lasts.
constexpr double kBrakeShare = 0.8;

constexpr double kStalledShare = 0.5;  // a wheel that does less of what it is told is held

constexpr std::uint8_t kBattery_dv = 127;
constexpr int kTicksPerMm = 128;
constexpr std::uint16_t kRevCount = 16570;

std::uint16_t whole(double value) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(value), 0L, 0xFFFFL));
}

std::int16_t signed_whole(double value) {
  return static_cast<std::int16_t>(std::clamp(std::lround(value), -0x8000L, 0x7FFFL));
}

// A velocity one period later: first to a standstill where it is to be the other way.
double ramped(double from, double to, double accel, double decel) {
  const double target = from * to < 0 ? 0 : to;
  const double most =
      (std::abs(target) > std::abs(from) ? accel : decel) * to_seconds(kControlPeriod);
  return from + std::clamp(target - from, -most, most);
}

// The velocity with which to be at rest after what is left.
double approach(double left, double there, double most, double decel) {
  if (std::abs(left) <= there) {
    return 0;
  }
  return std::copysign(std::min(most, std::sqrt(2 * kBrakeShare * decel * std::abs(left))), left);
}

// The segments of a half ring around `middle_rad` that are pressed, counted clockwise as seen from
// above: in front from the left, behind from the right.
std::uint8_t segments(const Health& health, int count, double middle_rad) {
  std::uint8_t pressed = 0;
  if (health.bumper_pressed && health.bumper_bearings_rad.empty()) {
    return static_cast<std::uint8_t>((1 << count) - 1);  // somewhere
  }
  for (const double bearing_rad : health.bumper_bearings_rad) {
    const double from_start_rad = std::numbers::pi / 2 - wrap_angle(bearing_rad - middle_rad);
    if (count > 0 && from_start_rad >= 0 && from_start_rad <= std::numbers::pi) {
      const int segment = static_cast<int>(from_start_rad / std::numbers::pi * count);
      pressed |= static_cast<std::uint8_t>(1 << std::min(segment, count - 1));
    }
  }
  return pressed;
}

const PioneerModel& model_of(const StandInOptions& options) {
  const PioneerModel* model = find_model(options.subclass);
  PANOPTES_CHECK(model != nullptr, "the subclass is a known one");
  return *model;
}

}  // namespace

void bind(Fields& f, StandInOptions& o) {
  f("name", o.name);
  f("class", o.class_name);
  f("subclass", o.subclass);
  f.require(find_model(o.subclass) != nullptr, "subclass",
            "must be one of " + joined(known_models()));
  f("counter_bits", o.counter_bits);
  f.require(o.counter_bits == 12 || o.counter_bits == 15 || o.counter_bits == 16, "counter_bits",
            "must be 12, 15 or 16");
  f("sip_cycle_ms", o.sip_cycle_ms, between(20, 255));
  f("watchdog_ms", o.watchdog_ms, between(100, 60'000));
  f("host_baud", o.host_baud);
  f.require(std::find(kBauds.begin(), kBauds.end(), o.host_baud) != kBauds.end(), "host_baud",
            "must be 9600, 19200, 38400, 57600 or 115200");
  f("front_bumpers", o.front_bumpers, between(0, 7));
  f("rear_bumpers", o.rear_bumpers, between(0, 7));
}

StandInController::StandInController(Robot& robot, const Body& body, const StandInOptions& options,
                                     std::function<void(const Observation&)> pictures)
    : robot_(robot),
      body_(body),
      options_(options),
      model_(model_of(options)),
      pictures_(std::move(pictures)),
      now_(robot.now()),
      line_free_(now_),
      reported_(now_) {
  reset();
}

Time StandInController::next_report() const {
  return open() ? std::max(next_sip_, line_free_) : Time::max();
}

std::vector<Sent> StandInController::take_sent() { return std::exchange(sent_, {}); }

void StandInController::advance(Time until) {
  while (now_ < until) {
    observe(std::min({until, next_report(), state_.motors_on ? next_control_ : Time::max()}));
    if (state_.motors_on && now_ >= next_control_) {
      control();
    }
    if (now_ >= next_report()) {
      report();
    }
  }
}

void StandInController::receive(Time now, std::span<const std::uint8_t> bytes) {
  advance(now);
  for (const PacketReader::Packet& packet : reader_.read(bytes)) {
    heard_ = now_;
    if (const std::optional<CommandPacket> command = read_command(packet.payload)) {
      obey(*command);
    }
  }
}

void StandInController::observe(Time until) {
  Observation seen;
  do {  // a frame set may be of an earlier instant
    seen = robot_.observe(until);
    if (!seen.pictures.empty() && pictures_) {
      pictures_(seen);
    }
  } while (seen.stamp < until);
  now_ = until;
  const Pose2 moved = odometry_.T_odom_body.inverse() * seen.odometry.T_odom_body;
  travelled_m_ += moved.x_m;
  turned_rad_ += moved.theta_rad;
  odometry_ = seen.odometry;
  health_ = seen.health;
}

bool StandInController::pressed_towards(double speed_mps) const {
  const auto ahead = [&](double bearing_rad) { return std::cos(bearing_rad) * speed_mps > 0; };
  return speed_mps != 0 && health_.bumper_pressed &&
         (health_.bumper_bearings_rad.empty() ||
          std::any_of(health_.bumper_bearings_rad.begin(), health_.bumper_bearings_rad.end(),
                      ahead));
}

Twist2 StandInController::wanted() const {
  if (now_ - heard_ > std::chrono::milliseconds(options_.watchdog_ms)) {
    return {};  // until it is heard again
  }
  const Limits& limits = state_.limits;
  Twist2 wanted = state_.wanted;
  if (state_.goal_travelled_m) {
    wanted.v_mps = approach(*state_.goal_travelled_m - travelled_m_, kThere_m, limits.speed_mps,
                            limits.decel_mps2);
  }
  if (state_.goal_heading_rad) {
    wanted.w_radps =
        approach(wrap_angle(*state_.goal_heading_rad - odometry_.T_odom_body.theta_rad), kThere_rad,
                 limits.turn_radps, limits.turn_decel_radps2);
  }
  return {std::clamp(wanted.v_mps, -limits.speed_mps, limits.speed_mps),
          std::clamp(wanted.w_radps, -limits.turn_radps, limits.turn_radps)};
}

void StandInController::control() {
  next_control_ += kControlPeriod;
  const Limits& limits = state_.limits;
  Twist2 target = wanted();
  Twist2& command = state_.command;
  const int side = target.v_mps > 0 ? 1 : 2;
  state_.bumper_holds = (state_.bump_stall & side) != 0 && pressed_towards(target.v_mps);
  if (state_.bumper_holds) {
    target.v_mps = command.v_mps = 0;
  }
  command = {
      ramped(command.v_mps, target.v_mps, limits.accel_mps2, limits.decel_mps2),
      ramped(command.w_radps, target.w_radps, limits.turn_accel_radps2, limits.turn_decel_radps2)};
  robot_.drive(command, kCommandValidFor);
}

void StandInController::report() {
  while (next_sip_ <= now_) {
    next_sip_ += std::chrono::milliseconds(options_.sip_cycle_ms);
  }
  send(sip_payload(sip()));
  if (state_.encoders) {
    send(encoders());
  }
  reported_travelled_m_ = travelled_m_;
  reported_ = now_;
}

void StandInController::send(const Bytes& payload) {
  const Time at = std::max(now_, line_free_);
  if (at - now_ > kMostWaiting) {
    return;
  }
  Bytes frame = arcos_frame(payload);
  line_free_ = at + std::chrono::nanoseconds(std::chrono::seconds(1)) *
                        static_cast<std::int64_t>(kBitsOfByte * frame.size()) / state_.baud;
  sent_.push_back({at, std::move(frame)});
}

Sip StandInController::sip() const {
  const Pose2 T_origin_body = T_odom_origin_.inverse() * odometry_.T_odom_body;
  const auto counter = [this](double metres) {
    const auto counts = static_cast<std::uint64_t>(std::llround(metres / model_.distance_m));
    return static_cast<std::uint16_t>(counts & ((1U << options_.counter_bits) - 1));
  };
  Sip sip;
  sip.x = counter(T_origin_body.x_m);
  sip.y = counter(T_origin_body.y_m);
  sip.theta = signed_whole(T_origin_body.theta_rad / model_.angle_rad);
  const Twist2& twist = odometry_.twist_body;
  const double half_mps = twist.w_radps / model_.turn_rad_per_m;
  sip.left = signed_whole((twist.v_mps - half_mps) / model_.speed_mps);
  sip.right = signed_whole((twist.v_mps + half_mps) / model_.speed_mps);
  sip.moving = sip.left != 0 || sip.right != 0;
  sip.battery_dv = kBattery_dv;
  const double told_mps = state_.command.v_mps;
  const double done_mps =
      now_ > reported_ ? (travelled_m_ - reported_travelled_m_) / to_seconds(now_ - reported_) : 0;
  const bool held = pressed_towards(told_mps) && now_ > reported_ &&
                    std::abs(done_mps) < kStalledShare * std::abs(told_mps);
  sip.left_stalled = sip.right_stalled = held || state_.bumper_holds;
  sip.front_bumpers = segments(health_, options_.front_bumpers, 0);
  sip.rear_bumpers = segments(health_, options_.rear_bumpers, std::numbers::pi);
  if (state_.goal_heading_rad) {
    sip.control = signed_whole(wrap_angle(*state_.goal_heading_rad - T_odom_origin_.theta_rad) /
                               model_.angle_rad);
  }
  sip.flags = static_cast<std::uint16_t>((state_.motors_on ? kFlagMotorsOn : 0) |
                                         (state_.emergency_stall ? kFlagEmergencyStall : 0));
  sip.battery_fine_dv = kBattery_dv;
  sip.charge_stage = 0;
  sip.turn_velocity = signed_whole(10 * rad_to_deg(twist.w_radps));
  sip.faults = 0;
  return sip;
}

Bytes StandInController::encoders() const {
  const auto ticks = [](double metres) {
    return static_cast<std::int32_t>(
        static_cast<std::uint32_t>(std::llround(1e3 * metres * kTicksPerMm)));
  };
  const double half_m = turned_rad_ * body_.wheel_base_m / 2;
  return encoder_payload(ticks(travelled_m_ - half_m), ticks(travelled_m_ + half_m));
}

ControllerConfig StandInController::config() const {
  const Limits own = own_limits();
  const auto baud = std::find(kBauds.begin(), kBauds.end(), state_.baud) - kBauds.begin();
  ControllerConfig c;
  c.class_name = options_.class_name;
  c.subclass = options_.subclass;
  c.serial = "stand-in";
  c.top_turn_degps = c.max_turn_degps = whole(rad_to_deg(own.turn_radps));
  c.top_speed_mmps = c.max_speed_mmps = whole(1e3 * own.speed_mps);
  c.top_turn_accel_degps2 = whole(rad_to_deg(own.turn_accel_radps2));
  c.turn_accel_degps2 = c.turn_decel_degps2 = c.top_turn_accel_degps2;
  c.top_accel_mmps2 = c.accel_mmps2 = c.decel_mmps2 = whole(1e3 * own.accel_mps2);
  c.most_pwm = 500;
  c.name = options_.name;
  c.sip_cycle_ms = static_cast<std::uint8_t>(options_.sip_cycle_ms);
  c.host_baud = static_cast<std::uint8_t>(baud);
  c.low_battery_dv = 115;
  c.rev_count = kRevCount;
  c.watchdog_ms = static_cast<std::uint16_t>(options_.watchdog_ms);
  c.stall_pwm = 200;
  c.stall_count = 200;
  c.joy_speed_mmps = c.max_speed_mmps;
  c.joy_turn_degps = c.max_turn_degps;
  c.front_bumpers = static_cast<std::uint8_t>(options_.front_bumpers);
  c.rear_bumpers = static_cast<std::uint8_t>(options_.rear_bumpers);
  c.ticks_per_mm = kTicksPerMm;
  c.shutdown_dv = 110;
  c.firmware = "2.9 stand-in";
  return c;
}

StandInController::Limits StandInController::own_limits() const {
  return {body_.max_speed_mps,  body_.max_accel_mps2,        body_.max_accel_mps2,
          body_.max_turn_radps, body_.max_turn_accel_radps2, body_.max_turn_accel_radps2};
}

void StandInController::reset() {
  let_go();
  state_ = {};
  state_.baud = options_.host_baud;
  state_.limits = own_limits();
  T_odom_origin_ = odometry_.T_odom_body;
  reader_.clear();
}

void StandInController::let_go() {
  state_.motors_on = false;
  state_.wanted = {};
  state_.goal_travelled_m.reset();
  state_.goal_heading_rad.reset();
  state_.command = {};
  state_.bumper_holds = false;
  robot_.stop();
}

// The three steps before a session; true where the packet was one of them. Out of order it begins
// anew. Once the names are given the same numbers mean PULSE, OPEN and CLOSE.
bool StandInController::synchronise(const CommandPacket& packet) {
  const auto number = static_cast<std::uint8_t>(packet.command);
  if (open() || number > 2) {
    return false;
  }
  if (number == 0) {
    send(Bytes{0});
    state_.link = Link::kSync0;
  } else if (number == 1 && state_.link == Link::kSync0) {
    send(Bytes{1});
    state_.link = Link::kSync1;
  } else if (number == 2 && state_.link == Link::kSync1) {
    send(names_payload({options_.name, options_.class_name, options_.subclass}));
    state_.link = Link::kSync2;
  } else if (number == 1 && state_.link == Link::kSync2) {
    state_.link = Link::kOpen;
    state_.limits = own_limits();
    T_odom_origin_ = odometry_.T_odom_body;
    next_sip_ = now_ + std::chrono::milliseconds(options_.sip_cycle_ms);
  } else {
    state_.link = Link::kIdle;
  }
  return true;
}

void StandInController::obey(const CommandPacket& packet) {
  if (packet.command == Command::kReset) {
    reset();
    return;
  }
  if (synchronise(packet) || !open()) {
    return;
  }
  const int* given = std::get_if<int>(&packet.argument);
  const int argument = given != nullptr ? *given : 0;
  switch (packet.command) {
    case Command::kClose:
      let_go();
      state_.link = Link::kIdle;
      state_.encoders = false;
      break;
    case Command::kEnable:
      if (argument == 0) {
        let_go();
      } else if (!state_.motors_on) {
        state_.motors_on = true;
        next_control_ = now_;
      }
      break;
    case Command::kSetOrigin:
      T_odom_origin_ = odometry_.T_odom_body;
      break;
    case Command::kStop:
    case Command::kEmergencyStop:
      state_.wanted = {};
      state_.goal_travelled_m.reset();
      state_.goal_heading_rad.reset();
      if (packet.command == Command::kEmergencyStop) {
        state_.command = {};
        robot_.stop();
      }
      break;
    case Command::kConfig:
      send(config_payload(config()));
      break;
    case Command::kEncoder:
      state_.encoders = argument > 1;
      if (argument == 1) {
        send(encoders());
      }
      break;
    case Command::kBumpStall:
      state_.bump_stall = argument & 3;
      break;
    case Command::kEmergencyStall:
      state_.emergency_stall = argument != 0;
      break;
    case Command::kHostBaud:
      if (argument >= 0 && argument < static_cast<int>(kBauds.size())) {
        state_.baud = kBauds[static_cast<std::size_t>(argument)];
      }
      break;
    case Command::kSetAcceleration:
    case Command::kSetMaxSpeed:
    case Command::kSetMaxTurn:
    case Command::kSetTurnAcceleration:
      set_limit(packet.command, argument);
      break;
    default:
      if (state_.motors_on && given != nullptr) {
        move(packet.command, argument);
      }
  }
}

// Beyond what the robot itself can, which it would follow only by falling behind, nothing is set.
void StandInController::set_limit(Command command, int argument) {
  Limits& limits = state_.limits;
  const Limits own = own_limits();
  const double metres = std::abs(argument) * 1e-3;
  const double radians = deg_to_rad(std::abs(argument));
  if (command == Command::kSetMaxSpeed) {
    limits.speed_mps = std::min(metres, own.speed_mps);
  } else if (command == Command::kSetMaxTurn) {
    limits.turn_radps = std::min(radians, own.turn_radps);
  } else if (command == Command::kSetAcceleration && argument != 0) {
    (argument > 0 ? limits.accel_mps2 : limits.decel_mps2) = std::min(metres, own.accel_mps2);
  } else if (command == Command::kSetTurnAcceleration && argument != 0) {
    (argument > 0 ? limits.turn_accel_radps2 : limits.turn_decel_radps2) =
        std::min(radians, own.turn_accel_radps2);
  }
}

void StandInController::move(Command command, int argument) {
  const double metres = argument * 1e-3;
  const double radians = deg_to_rad(argument);
  const double heading_rad = odometry_.T_odom_body.theta_rad;
  const auto go = [this](double v_mps) {
    state_.wanted.v_mps = v_mps;
    state_.goal_travelled_m.reset();
  };
  const auto turn = [this](double w_radps) {
    state_.wanted.w_radps = w_radps;
    state_.goal_heading_rad.reset();
  };
  switch (command) {
    case Command::kVelocity:
      go(metres);
      break;
    case Command::kMove:
      state_.goal_travelled_m = travelled_m_ + metres;
      break;
    case Command::kTurnVelocity:
    case Command::kRotate:
      turn(radians);
      break;
    case Command::kHead:
      state_.goal_heading_rad = T_odom_origin_.theta_rad + radians;
      break;
    case Command::kTurnBy:
      state_.goal_heading_rad = heading_rad + radians;
      break;
    case Command::kTurnByFromSetpoint:
      state_.goal_heading_rad = state_.goal_heading_rad.value_or(heading_rad) + radians;
      break;
    case Command::kWheelVelocities: {
      const auto wheels = static_cast<std::uint16_t>(argument);
      const double right_mps = static_cast<std::int8_t>(wheels & 0xFF) * model_.wheel_speed_mps;
      const double left_mps = static_cast<std::int8_t>(wheels >> 8) * model_.wheel_speed_mps;
      go((left_mps + right_mps) / 2);
      turn((right_mps - left_mps) / 2 * model_.turn_rad_per_m);
      break;
    }
    default:
      break;  // one that this robot has nothing for
  }
}

}  // namespace panoptes::hw
