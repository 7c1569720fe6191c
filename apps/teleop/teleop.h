// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// The clock of whoever holds the keys: goes on whatever the platform's does.
using WallTime = std::chrono::steady_clock::time_point;

/// For so long after it was pressed or last repeated, a key of a terminal counts as held: terminals
/// tell no release. A keyboard that first repeats later (the X server's own default is 0.66 s,
/// desktops set 0.25 to 0.5 s) makes the robot hesitate once, which is the safe side of it.
inline constexpr Duration kKeyHeld = std::chrono::milliseconds(500);

enum class TeleopKey {
  kForward,
  kBackward,
  kLeft,
  kRight,
  kFaster,
  kSlower,
  kStop,
  kQuit,
};

/// A gamepad's sticks, as they are now.
struct GamepadSticks {
  bool held = false;   ///< the dead-man button
  double forward = 0;  ///< from -1 to 1
  double left = 0;
};

/// What a person who drives by hand wants, told by keys and gamepads, as a velocity within the
/// body's limits (its ramps are the platform's business). Nothing moves unless a key keeps
/// repeating or a gamepad's dead-man button is held, which has the say then.
class Teleop {
 public:
  explicit Teleop(const Body& body) : body_(body) {}

  void press(TeleopKey key, WallTime at);
  void hold(const GamepadSticks& sticks) { sticks_ = sticks; }

  /// Where a bumper is pressed, no way on towards what it touches, as the robot stands now: whoever
  /// has turned away from it may drive away. What it touches lies where the platform says, else in
  /// the direction that was driven last; it holds until the bumper is released and the keys that
  /// drive towards it are let go. A stop holds everything until all keys are.
  Twist2 command(WallTime now, const Observation& seen);

  /// The speed that a key asks for.
  Twist2 top() const;
  bool quit() const { return quit_; }
  /// Whether a stop was pressed since this was asked last.
  bool take_stop() { return std::exchange(stop_pressed_, false); }

  /// What the bumper or a stop keeps from moving: "forward", "backward", both, "all"; empty:
  /// nothing.
  std::string held_back() const;

 private:
  struct Direction {  // of two opposite keys the one pressed last
    int sign = 0;
    WallTime at;
  };

  void feel(const Observation& seen);
  bool towards_touched(double ahead) const;

  int level_ = 5;  // of kLevels
  Body body_;
  Direction ahead_;
  Direction aside_;
  GamepadSticks sticks_;
  bool stopped_ = false;
  std::vector<double> touched_odom_rad_;  // the directions in which something is touched
  double heading_odom_rad_ = 0;
  bool bumper_was_ = false;
  bool backward_last_ = false;  // the last motion asked for
  bool quit_ = false;
  bool stop_pressed_ = false;
};

/// Keys out of the bytes that a terminal sends: arrows and WASD, + and -, space, q. Any other key
/// stops, as space does. Remembers a sequence that has not come whole.
class KeyReader {
 public:
  std::vector<TeleopKey> read(std::string_view bytes);

 private:
  std::optional<TeleopKey> take(char byte);

  enum class State { kPlain, kEscape, kSequence };
  State state_ = State::kPlain;
  std::string sequence_;
};

/// What the keys do, a line each.
extern const std::string_view kTeleopHelp;

/// One line for who drives: speed asked for and its top, pose by odometry, and what is held back.
std::string teleop_line(const Teleop& teleop, const Observation& seen, const Twist2& command_body,
                        const std::string& doing);

}  // namespace panoptes
