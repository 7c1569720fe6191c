// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/teleop/teleop.h"

namespace panoptes {

struct KeyPress {
  TeleopKey key;
  WallTime at;
};

/// The terminal on stdin, without echo and key by key for as long as this lives. It is given back
/// as it was however the program ends, but for SIGKILL. Ctrl-C still interrupts; Ctrl-Z, which
/// would leave a robot without its driver, does nothing. One at a time; make it after what handles
/// signals, whose handlers go on working.
class Keyboard {
 public:
  /// Why nobody can press keys on stdin; empty when somebody can.
  static std::string fault();

  Keyboard();
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// What was pressed since last asked, each with the time when it came, however long ago.
  std::vector<KeyPress> take();

  /// The terminal is gone.
  bool closed() const;

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace panoptes
