// SPDX-License-Identifier: BSD-3-Clause
#include "apps/teleop/teleop_console.h"

#include <algorithm>
#include <cstdio>
#include <thread>
#include <utility>

#include "core/base/error.h"

namespace panoptes {

TeleopConsole::TeleopConsole(const Body& body, bool quiet)
    : teleop_(body), told_(quiet), line_(quiet) {
  const std::string fault = Keyboard::fault();
  if (fault.empty()) {
    keyboard_.emplace();
  } else if (gamepads_.names().empty()) {
    throw DeviceError("teleop: nobody can drive: " + fault +
                      " and no gamepad is plugged in; run it in the foreground of a terminal, or "
                      "plug one in (panoptes doctor lists them)");
  }
}

void TeleopConsole::keep_pace(Time now) {
  const WallTime wall = std::chrono::steady_clock::now();
  due_ = last_ ? std::max(due_ + (now - *last_), wall) : wall;
  last_ = now;
  std::this_thread::sleep_until(due_);
}

Twist2 TeleopConsole::command(const Observation& seen, const std::string& doing) {
  if (!std::exchange(told_, true)) {
    std::fprintf(stderr, "%s", kTeleopHelp.data());
  }
  if (keyboard_) {
    for (const KeyPress& press : keyboard_->take()) {
      teleop_.press(press.key, press.at);
    }
  }
  const WallTime now = std::chrono::steady_clock::now();
  gamepads_.poll();
  for (const TeleopKey key : gamepads_.pressed()) {
    teleop_.press(key, now);
  }
  teleop_.hold(gamepads_.sticks());
  const Twist2 command_body = teleop_.command(now, seen);
  const bool held = !seen.health.held_by.empty();
  const bool stands = command_body.v_mps == 0 && command_body.w_radps == 0;
  acknowledges_ = held && let_go_ && !stands;
  let_go_ = held && (let_go_ || stands);
  if (line_.due()) {
    line_.show(teleop_line(teleop_, seen, command_body, doing));
  }
  return command_body;
}

bool TeleopConsole::left() const { return teleop_.quit() || (keyboard_ && keyboard_->closed()); }

}  // namespace panoptes
