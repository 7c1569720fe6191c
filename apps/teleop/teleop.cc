// SPDX-License-Identifier: BSD-3-Clause
#include "apps/teleop/teleop.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace panoptes {
namespace {

constexpr int kLevels = 10;
constexpr char kEscape = '\x1b';

}  // namespace

const std::string_view kTeleopHelp =
    "w a s d or arrows  drive while the key is held (0.5 s after it the robot stops)\n"
    "+ -                faster, slower\n"
    "space              stop, and so does any other key\n"
    "q                  end; Ctrl-C as well\n"
    "gamepad            hold a shoulder button: left stick drives, right stick turns,\n"
    "                   D-pad up and down faster and slower, B stops, back ends\n";

void Teleop::press(TeleopKey key, WallTime at) {
  switch (key) {
    case TeleopKey::kForward:
      ahead_ = {1, at};
      break;
    case TeleopKey::kBackward:
      ahead_ = {-1, at};
      break;
    case TeleopKey::kLeft:
      aside_ = {1, at};
      break;
    case TeleopKey::kRight:
      aside_ = {-1, at};
      break;
    case TeleopKey::kFaster:
      level_ = std::min(level_ + 1, kLevels);
      break;
    case TeleopKey::kSlower:
      level_ = std::max(level_ - 1, 1);
      break;
    case TeleopKey::kStop:
      ahead_ = {};
      aside_ = {};
      stopped_ = true;
      stop_pressed_ = true;
      break;
    case TeleopKey::kQuit:
      quit_ = true;
      break;
  }
}

Twist2 Teleop::top() const {
  const double share = static_cast<double>(level_) / kLevels;
  return {share * body_.max_speed_mps, share * body_.max_turn_radps};
}

void Teleop::feel(const Observation& seen) {
  const Health& health = seen.health;
  heading_odom_rad_ = seen.odometry.T_odom_body.theta_rad;
  const bool strikes = health.bumper_pressed && !bumper_was_;
  bumper_was_ = health.bumper_pressed;
  if (health.bumper_pressed && !health.bumper_bearings_rad.empty()) {
    touched_odom_rad_.clear();
    for (const double bearing_rad : health.bumper_bearings_rad) {
      touched_odom_rad_.push_back(heading_odom_rad_ + bearing_rad);
    }
  } else if (strikes) {
    touched_odom_rad_.push_back(heading_odom_rad_ + (backward_last_ ? std::numbers::pi : 0));
  }
}

bool Teleop::towards_touched(double ahead) const {
  constexpr double kRoundoff = 1e-9;  // along it is not towards it
  return std::any_of(touched_odom_rad_.begin(), touched_odom_rad_.end(), [&](double touched_rad) {
    return ahead * std::cos(touched_rad - heading_odom_rad_) > kRoundoff;
  });
}

Twist2 Teleop::command(WallTime now, const Observation& seen) {
  const auto of_key = [now](const Direction& direction) {
    return now - direction.at < kKeyHeld ? static_cast<double>(direction.sign) : 0.0;
  };
  double ahead = sticks_.held ? std::clamp(sticks_.forward, -1.0, 1.0) : of_key(ahead_);
  double aside = sticks_.held ? std::clamp(sticks_.left, -1.0, 1.0) : of_key(aside_);
  feel(seen);
  stopped_ = stopped_ && (ahead != 0 || aside != 0);
  if (stopped_ || quit_) {
    return {};
  }
  if (towards_touched(ahead)) {
    ahead = 0;
  } else if (!seen.health.bumper_pressed) {
    touched_odom_rad_.clear();
  }
  if (ahead != 0) {
    backward_last_ = ahead < 0;
  }
  return {ahead * top().v_mps, aside * top().w_radps};
}

std::string Teleop::held_back() const {
  if (stopped_) {
    return "all";
  }
  const bool forward = towards_touched(1);
  if (towards_touched(-1)) {
    return forward ? "forward and backward" : "backward";
  }
  return forward ? "forward" : "";
}

std::vector<TeleopKey> KeyReader::read(std::string_view bytes) {
  std::vector<TeleopKey> keys;
  for (const char byte : bytes) {
    if (const std::optional<TeleopKey> key = take(byte)) {
      keys.push_back(*key);
    }
  }
  if (state_ == State::kEscape) {  // the key of that name, as far as one can know
    keys.push_back(TeleopKey::kStop);
  }
  return keys;
}

std::optional<TeleopKey> KeyReader::take(char byte) {
  if (byte == kEscape) {
    state_ = State::kEscape;
    return std::nullopt;
  }
  const State before = std::exchange(state_, State::kPlain);
  if (before == State::kEscape && (byte == '[' || byte == 'O')) {
    state_ = State::kSequence;
    sequence_.clear();
    return std::nullopt;
  }
  if (before == State::kEscape) {
    return TeleopKey::kStop;
  }
  if (before == State::kSequence) {
    // what may stand before the letter: numbers, and a second bracket (function keys on a console)
    if (std::isdigit(static_cast<unsigned char>(byte)) != 0 || byte == ';' || byte == '[') {
      state_ = State::kSequence;
      sequence_ += byte;
      return std::nullopt;
    }
    const bool arrow = sequence_.empty() || sequence_.starts_with("1;");  // 1;n: with shift, alt
    switch (arrow ? byte : '\0') {
      case 'A':
        return TeleopKey::kForward;
      case 'B':
        return TeleopKey::kBackward;
      case 'C':
        return TeleopKey::kRight;
      case 'D':
        return TeleopKey::kLeft;
      default:
        return TeleopKey::kStop;
    }
  }
  switch (std::tolower(static_cast<unsigned char>(byte))) {
    case 'w':
      return TeleopKey::kForward;
    case 's':
      return TeleopKey::kBackward;
    case 'a':
      return TeleopKey::kLeft;
    case 'd':
      return TeleopKey::kRight;
    case '+':
    case '=':
      return TeleopKey::kFaster;
    case '-':
    case '_':
      return TeleopKey::kSlower;
    case 'q':
      return TeleopKey::kQuit;
    default:
      return TeleopKey::kStop;
  }
}

std::string teleop_line(const Teleop& teleop, const Observation& seen, const Twist2& command_body,
                        const std::string& doing) {
  const Pose2& at = seen.odometry.T_odom_body;
  const Twist2 top = teleop.top();
  std::string line =
      fmt::format("{:+.2f} m/s {:+.0f} deg/s (keys {:.2f}, {:.0f}), at {:.2f} {:.2f} m, {:.0f} deg",
                  command_body.v_mps, rad_to_deg(command_body.w_radps), top.v_mps,
                  rad_to_deg(top.w_radps), at.x_m, at.y_m, rad_to_deg(at.theta_rad));
  if (!seen.health.motors_enabled) {
    line += ", MOTORS OFF";
  }
  if (seen.health.bumper_pressed) {
    line += ", BUMPER";
  }
  if (!seen.health.held_by.empty()) {
    line += ", HELD by " + seen.health.held_by + ": let go, then drive on";
  }
  if (!teleop.held_back().empty()) {
    line += ", " + teleop.held_back() + " held";
  }
  return doing.empty() ? line : line + ", " + doing;
}

}  // namespace panoptes
