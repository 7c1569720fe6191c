// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/teleop/teleop.h"

namespace panoptes {

/// The gamepads that are plugged in; none where Panoptes was built without SDL. Their dead-man
/// button is either shoulder button.
class Gamepads {
 public:
  Gamepads();
  ~Gamepads();
  Gamepads(const Gamepads&) = delete;
  Gamepads& operator=(const Gamepads&) = delete;

  /// As they are now; finds those plugged in since, forgets those pulled out.
  void poll();

  /// Of the first whose dead-man button is held.
  GamepadSticks sticks() const;
  /// What their buttons were pressed for between the last two polls.
  const std::vector<TeleopKey>& pressed() const;

  std::vector<std::string> names() const;
  /// Those whose buttons nobody knows, by name: of no use.
  std::vector<std::string> unknown() const;

 private:
  class Sdl;
  std::unique_ptr<Sdl> sdl_;
};

}  // namespace panoptes
