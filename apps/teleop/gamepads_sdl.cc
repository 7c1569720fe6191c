// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <SDL.h>

#include "apps/teleop/gamepads.h"

namespace panoptes {
namespace {

// Where a stick that is let go may still rest (XInput's dead zone of the left one).
constexpr double kRest = 7849.0 / SDL_JOYSTICK_AXIS_MAX;

struct Button {
  SDL_GameControllerButton button;
  TeleopKey key;
};
constexpr std::array<Button, 4> kButtons{{
    {SDL_CONTROLLER_BUTTON_DPAD_UP, TeleopKey::kFaster},
    {SDL_CONTROLLER_BUTTON_DPAD_DOWN, TeleopKey::kSlower},
    {SDL_CONTROLLER_BUTTON_B, TeleopKey::kStop},
    {SDL_CONTROLLER_BUTTON_BACK, TeleopKey::kQuit},
}};

std::string words(const char* name) { return name == nullptr ? "a gamepad" : name; }

}  // namespace

class Gamepads::Sdl {
 public:
  Sdl() {
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");  // we have no window
    running_ = SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) == 0;
    SDL_GameControllerEventState(SDL_IGNORE);
    SDL_JoystickEventState(SDL_IGNORE);
  }
  ~Sdl() {
    for (const Pad& pad : pads_) {
      SDL_GameControllerClose(pad.controller);
    }
    if (running_) {
      SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
    }
  }
  Sdl(const Sdl&) = delete;
  Sdl& operator=(const Sdl&) = delete;

  void poll() {
    pressed_.clear();
    if (!running_) {
      return;
    }
    SDL_GameControllerUpdate();
    SDL_FlushEvents(SDL_FIRSTEVENT, SDL_LASTEVENT);
    std::erase_if(pads_, [](const Pad& pad) {
      const bool gone = SDL_GameControllerGetAttached(pad.controller) == SDL_FALSE;
      if (gone) {
        SDL_GameControllerClose(pad.controller);
      }
      return gone;
    });
    for (int i = 0; i < SDL_NumJoysticks(); ++i) {
      if (SDL_IsGameController(i) == SDL_TRUE &&
          SDL_GameControllerFromInstanceID(SDL_JoystickGetDeviceInstanceID(i)) == nullptr) {
        if (SDL_GameController* controller = SDL_GameControllerOpen(i)) {
          pads_.push_back({controller, {}});
        }
      }
    }
    for (Pad& pad : pads_) {
      for (std::size_t b = 0; b < kButtons.size(); ++b) {
        const bool down = is_down(pad, kButtons[b].button);
        if (down && !std::exchange(pad.down[b], down)) {
          pressed_.push_back(kButtons[b].key);
        }
        pad.down[b] = down;
      }
    }
  }

  GamepadSticks sticks() const {
    for (const Pad& pad : pads_) {
      if (is_down(pad, SDL_CONTROLLER_BUTTON_LEFTSHOULDER) ||
          is_down(pad, SDL_CONTROLLER_BUTTON_RIGHTSHOULDER)) {
        const double left = tilt(pad, SDL_CONTROLLER_AXIS_LEFTX);
        const double right = tilt(pad, SDL_CONTROLLER_AXIS_RIGHTX);
        return {true, tilt(pad, SDL_CONTROLLER_AXIS_LEFTY),
                std::abs(left) > std::abs(right) ? left : right};
      }
    }
    return {};
  }

  const std::vector<TeleopKey>& pressed() const { return pressed_; }

  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const Pad& pad : pads_) {
      out.push_back(words(SDL_GameControllerName(pad.controller)));
    }
    return out;
  }

  std::vector<std::string> unknown() const {
    std::vector<std::string> out;
    for (int i = 0; running_ && i < SDL_NumJoysticks(); ++i) {
      if (SDL_IsGameController(i) == SDL_FALSE) {
        out.push_back(words(SDL_JoystickNameForIndex(i)));
      }
    }
    return out;
  }

 private:
  struct Pad {
    SDL_GameController* controller;
    std::array<bool, kButtons.size()> down;  // at the last look
  };

  static bool is_down(const Pad& pad, SDL_GameControllerButton button) {
    return SDL_GameControllerGetButton(pad.controller, button) != 0;
  }
  // Forward or left, as SDL has neither, from -1 to 1; 0 at rest, without a jump at the edge of it.
  static double tilt(const Pad& pad, SDL_GameControllerAxis axis) {
    const double raw =
        SDL_GameControllerGetAxis(pad.controller, axis) / double{SDL_JOYSTICK_AXIS_MAX};
    const double beyond = std::max(std::abs(raw) - kRest, 0.0) / (1 - kRest);
    return beyond == 0 ? 0 : std::copysign(std::min(beyond, 1.0), -raw);
  }

  bool running_ = false;
  std::vector<Pad> pads_;
  std::vector<TeleopKey> pressed_;
};

Gamepads::Gamepads() : sdl_(std::make_unique<Sdl>()) { poll(); }
Gamepads::~Gamepads() = default;
void Gamepads::poll() { sdl_->poll(); }
GamepadSticks Gamepads::sticks() const { return sdl_->sticks(); }
const std::vector<TeleopKey>& Gamepads::pressed() const { return sdl_->pressed(); }
std::vector<std::string> Gamepads::names() const { return sdl_->names(); }
std::vector<std::string> Gamepads::unknown() const { return sdl_->unknown(); }

}  // namespace panoptes
