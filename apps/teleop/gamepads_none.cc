// SPDX-License-Identifier: BSD-3-Clause
#include "apps/teleop/gamepads.h"

namespace panoptes {

class Gamepads::Sdl {
 public:
  std::vector<TeleopKey> pressed;  // stays empty
};

Gamepads::Gamepads() : sdl_(std::make_unique<Sdl>()) {}
Gamepads::~Gamepads() = default;
void Gamepads::poll() {}
GamepadSticks Gamepads::sticks() const { return {}; }
const std::vector<TeleopKey>& Gamepads::pressed() const { return sdl_->pressed; }
std::vector<std::string> Gamepads::names() const { return {}; }
std::vector<std::string> Gamepads::unknown() const { return {}; }

}  // namespace panoptes
