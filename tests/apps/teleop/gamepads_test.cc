// SPDX-License-Identifier: BSD-3-Clause
#include "apps/teleop/gamepads.h"

#include <SDL.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panoptes {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using enum TeleopKey;

constexpr double kStep = 1e-3;  // a step of 16 bits, with room

/// A gamepad that exists in SDL alone.
class VirtualPad {
 public:
  VirtualPad()
      : index_(SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER, SDL_CONTROLLER_AXIS_MAX,
                                         SDL_CONTROLLER_BUTTON_MAX, 0)),
        joystick_(SDL_JoystickOpen(index_)) {
    tilt(SDL_CONTROLLER_AXIS_LEFTY, 0);
  }
  ~VirtualPad() { pull_out(); }
  VirtualPad(const VirtualPad&) = delete;
  VirtualPad& operator=(const VirtualPad&) = delete;

  void press(SDL_GameControllerButton button, bool down) {
    SDL_JoystickSetVirtualButton(joystick_, button, down ? 1 : 0);
  }
  void tilt(SDL_GameControllerAxis axis, double share) {
    SDL_JoystickSetVirtualAxis(joystick_, axis, static_cast<Sint16>(share * SDL_JOYSTICK_AXIS_MAX));
  }
  void pull_out() {
    if (joystick_ != nullptr) {
      SDL_JoystickClose(joystick_);
      SDL_JoystickDetachVirtual(index_);
      joystick_ = nullptr;
    }
  }

 private:
  int index_;
  SDL_Joystick* joystick_;
};

TEST(Gamepads, AreFoundWhenPluggedInAndForgottenWhenPulledOut) {
  Gamepads gamepads;
  const std::size_t before = gamepads.names().size();
  VirtualPad pad;
  gamepads.poll();
  EXPECT_THAT(gamepads.names(), SizeIs(before + 1));
  pad.press(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  pad.tilt(SDL_CONTROLLER_AXIS_LEFTY, -1);
  gamepads.poll();
  EXPECT_TRUE(gamepads.sticks().held);
  pad.pull_out();
  gamepads.poll();
  EXPECT_THAT(gamepads.names(), SizeIs(before));
  EXPECT_FALSE(gamepads.sticks().held);
}

TEST(Gamepads, SticksTellForwardAndLeftWhileAShoulderButtonIsHeld) {
  Gamepads gamepads;
  VirtualPad pad;
  pad.tilt(SDL_CONTROLLER_AXIS_LEFTY, -1);
  gamepads.poll();
  EXPECT_FALSE(gamepads.sticks().held);
  for (const auto shoulder :
       {SDL_CONTROLLER_BUTTON_LEFTSHOULDER, SDL_CONTROLLER_BUTTON_RIGHTSHOULDER}) {
    pad.press(shoulder, true);
    gamepads.poll();
    EXPECT_TRUE(gamepads.sticks().held);
    EXPECT_NEAR(gamepads.sticks().forward, 1, kStep);
    EXPECT_EQ(gamepads.sticks().left, 0);
    pad.press(shoulder, false);
    gamepads.poll();
    EXPECT_FALSE(gamepads.sticks().held);
  }
  pad.press(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  pad.tilt(SDL_CONTROLLER_AXIS_LEFTY, 0.2);  // a stick that does not come home
  pad.tilt(SDL_CONTROLLER_AXIS_RIGHTX, 1);
  gamepads.poll();
  EXPECT_EQ(gamepads.sticks().forward, 0);
  EXPECT_NEAR(gamepads.sticks().left, -1, kStep);
  pad.tilt(SDL_CONTROLLER_AXIS_RIGHTX, 0);
  pad.tilt(SDL_CONTROLLER_AXIS_LEFTX, -1);
  gamepads.poll();
  EXPECT_NEAR(gamepads.sticks().left, 1, kStep);
}

TEST(Gamepads, AButtonCountsOnceHoweverLongItIsPressed) {
  Gamepads gamepads;
  VirtualPad pad;
  gamepads.poll();
  EXPECT_THAT(gamepads.pressed(), IsEmpty());
  pad.press(SDL_CONTROLLER_BUTTON_DPAD_UP, true);
  gamepads.poll();
  EXPECT_THAT(gamepads.pressed(), ElementsAre(kFaster));
  gamepads.poll();
  EXPECT_THAT(gamepads.pressed(), IsEmpty());
  pad.press(SDL_CONTROLLER_BUTTON_DPAD_UP, false);
  pad.press(SDL_CONTROLLER_BUTTON_B, true);
  pad.press(SDL_CONTROLLER_BUTTON_BACK, true);
  gamepads.poll();
  EXPECT_THAT(gamepads.pressed(), ElementsAre(kStop, kQuit));
}

}  // namespace
}  // namespace panoptes
