// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "apps/process/progress.h"
#include "apps/teleop/gamepads.h"
#include "apps/teleop/keyboard.h"
#include "apps/teleop/teleop.h"
#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/geometry/body.h"

namespace panoptes {

/// Where a person drives a robot by hand: the terminal on stdin, gamepads, and a line on stderr
/// that tells how it goes. Make it after what handles signals.
class TeleopConsole {
 public:
  /// Throws DeviceError where there is neither a terminal nor a gamepad.
  TeleopConsole(const Body& body, bool quiet);

  /// For platforms whose time moves as fast as they are observed: waits until as much of it has
  /// gone by on the wall as between this observation and the last. What the computer was slower
  /// with than real is not made up for by haste.
  void keep_pace(Time now);

  /// What the person wants now, and shows it; the first time what the keys do as well.
  Twist2 command(const Observation& seen, const std::string& doing);

  /// The person has said stop since this was asked last.
  bool take_stop() { return teleop_.take_stop(); }

  /// With what was commanded last the person has seen that something holds the robot: the keys were
  /// let go, and now one is pressed anew.
  bool acknowledges() const { return acknowledges_; }

  /// The person ended it, or the terminal is gone.
  bool left() const;

 private:
  std::optional<Keyboard> keyboard_;
  Gamepads gamepads_;
  Teleop teleop_;
  bool told_;  // what the keys do
  ProgressLine line_;
  bool let_go_ = false;  // while something held the robot
  bool acknowledges_ = false;
  std::optional<Time> last_;
  WallTime due_;
};

}  // namespace panoptes
