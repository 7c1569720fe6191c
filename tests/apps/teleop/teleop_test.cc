// SPDX-License-Identifier: BSD-3-Clause
#include "apps/teleop/teleop.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panoptes {
namespace {

using testing::ElementsAre;
using enum TeleopKey;

constexpr double kHalf = 0.5;  // of the limits: what a key asks for at first

WallTime at(double s) { return WallTime(from_seconds(s)); }

class TeleopTest : public testing::Test {
 protected:
  Twist2 command(double s) { return teleop_.command(at(s), seen_); }
  void turn_to(double deg) { seen_.odometry.T_odom_body.theta_rad = deg_to_rad(deg); }

  Body body_;
  Teleop teleop_{body_};
  Observation seen_;
};

TEST_F(TeleopTest, NothingMovesBeforeAKeyIsPressed) {
  EXPECT_EQ(command(0).v_mps, 0);
  EXPECT_EQ(command(0).w_radps, 0);
}

TEST_F(TeleopTest, AKeyDrivesForAsLongAsItRepeats) {
  for (double s = 10; s < 12; s += 0.4) {
    teleop_.press(kForward, at(s));
    EXPECT_EQ(command(s + 0.39).v_mps, kHalf * body_.max_speed_mps);
    EXPECT_EQ(command(s + 0.39).w_radps, 0);
  }
  teleop_.press(kForward, at(20));
  EXPECT_GT(command(20.4999).v_mps, 0);
  EXPECT_EQ(command(20.5).v_mps, 0);
  EXPECT_EQ(command(25).v_mps, 0);
}

TEST_F(TeleopTest, AKeyCountsFromWhenItWasPressedNotFromWhenItWasRead) {
  teleop_.press(kForward, at(1));
  EXPECT_EQ(command(1.6).v_mps, 0);
}

TEST_F(TeleopTest, TwoKeysInTurnDriveAnArcAndTheLaterOfOppositeOnesCounts) {
  teleop_.press(kForward, at(1));
  teleop_.press(kLeft, at(1.1));
  EXPECT_EQ(command(1.2).v_mps, kHalf * body_.max_speed_mps);
  EXPECT_EQ(command(1.2).w_radps, kHalf * body_.max_turn_radps);
  teleop_.press(kBackward, at(1.3));
  teleop_.press(kRight, at(1.3));
  EXPECT_EQ(command(1.4).v_mps, -kHalf * body_.max_speed_mps);
  EXPECT_EQ(command(1.4).w_radps, -kHalf * body_.max_turn_radps);
}

TEST_F(TeleopTest, SpeedStaysWithinTheLimits) {
  for (int i = 0; i < 20; ++i) {
    teleop_.press(kFaster, at(1));
  }
  teleop_.press(kForward, at(1));
  EXPECT_EQ(command(1).v_mps, body_.max_speed_mps);
  teleop_.hold({true, 3, -3});
  EXPECT_EQ(command(1).v_mps, body_.max_speed_mps);
  EXPECT_EQ(command(1).w_radps, -body_.max_turn_radps);
  for (int i = 0; i < 20; ++i) {
    teleop_.press(kSlower, at(1));
  }
  EXPECT_GT(command(1).v_mps, 0);
  EXPECT_LE(command(1).v_mps, 0.11 * body_.max_speed_mps);
}

TEST_F(TeleopTest, AGamepadDrivesOnlyWhileItsDeadManButtonIsHeld) {
  teleop_.hold({false, 1, 1});
  EXPECT_EQ(command(1).v_mps, 0);
  teleop_.hold({true, 0.5, 0});
  EXPECT_EQ(command(1).v_mps, 0.5 * kHalf * body_.max_speed_mps);
  teleop_.hold({false, 0.5, 0});
  EXPECT_EQ(command(1).v_mps, 0);
}

TEST_F(TeleopTest, AHeldGamepadHasTheSay) {
  teleop_.press(kForward, at(1));
  teleop_.hold({true, 0, 0});
  EXPECT_EQ(command(1.1).v_mps, 0);
}

TEST_F(TeleopTest, AStopHoldsUntilTheKeysAreLetGo) {
  teleop_.press(kForward, at(1));
  teleop_.press(kStop, at(1.1));
  EXPECT_EQ(command(1.2).v_mps, 0);
  teleop_.press(kForward, at(1.3));
  EXPECT_GT(command(1.3).v_mps, 0);

  teleop_.hold({true, 1, 0});
  teleop_.press(kStop, at(2));
  EXPECT_EQ(command(2.1).v_mps, 0);
  EXPECT_EQ(teleop_.held_back(), "all");
  EXPECT_EQ(command(3).v_mps, 0);
  teleop_.hold({false, 1, 0});
  EXPECT_EQ(command(3.1).v_mps, 0);
  teleop_.hold({true, 1, 0});
  EXPECT_GT(command(3.2).v_mps, 0);
}

TEST_F(TeleopTest, ABumperHoldsForwardUntilReleasedAndTheKeysAreLetGo) {
  teleop_.press(kForward, at(1));
  EXPECT_GT(command(1).v_mps, 0);
  seen_.health.bumper_pressed = true;
  teleop_.press(kLeft, at(1.05));
  EXPECT_EQ(command(1.1).v_mps, 0);
  EXPECT_GT(command(1.1).w_radps, 0);  // turning stays free
  EXPECT_EQ(teleop_.held_back(), "forward");
  teleop_.press(kForward, at(2));  // let go, pressed again, but the bumper is still pressed
  EXPECT_EQ(command(1.8).v_mps, 0);
  EXPECT_EQ(command(2).v_mps, 0);
  seen_.health.bumper_pressed = false;
  teleop_.press(kForward, at(2.4));
  EXPECT_EQ(command(2.5).v_mps, 0);  // never let go since
  EXPECT_EQ(command(2.95).v_mps, 0);
  EXPECT_EQ(teleop_.held_back(), "");
  teleop_.press(kForward, at(3));
  EXPECT_GT(command(3).v_mps, 0);
}

TEST_F(TeleopTest, BackingAwayFromWhatWasTouchedIsFree) {
  teleop_.press(kForward, at(1));
  command(1);
  seen_.health.bumper_pressed = true;
  command(1.1);
  teleop_.press(kBackward, at(1.2));
  EXPECT_LT(command(1.2).v_mps, 0);
  EXPECT_LT(command(1.3).v_mps, 0);  // though it is the last motion now, with the bumper pressed
}

TEST_F(TeleopTest, WhatIsTouchedInReverseHoldsTheReverse) {
  teleop_.press(kBackward, at(1));
  command(1);
  seen_.health.bumper_pressed = true;
  EXPECT_EQ(command(1.1).v_mps, 0);
  EXPECT_EQ(teleop_.held_back(), "backward");
  teleop_.press(kForward, at(1.2));
  EXPECT_GT(command(1.2).v_mps, 0);
}

TEST_F(TeleopTest, WhoHasTurnedAwayFromWhatWasTouchedMayDriveAway) {
  turn_to(170);  // so that turning on crosses where headings wrap
  teleop_.press(kForward, at(1));
  command(1);
  seen_.health.bumper_pressed = true;
  teleop_.press(kForward, at(1.1));
  EXPECT_EQ(command(1.1).v_mps, 0);
  turn_to(-110);  // by 80 degrees: still towards it
  teleop_.press(kForward, at(2));
  EXPECT_EQ(command(2).v_mps, 0);
  EXPECT_EQ(teleop_.held_back(), "forward");
  turn_to(-90);
  teleop_.press(kForward, at(3));
  EXPECT_GT(command(3).v_mps, 0);
  EXPECT_EQ(teleop_.held_back(), "backward");
  turn_to(-10);
  teleop_.press(kForward, at(4));
  EXPECT_GT(command(4).v_mps, 0);
  teleop_.press(kBackward, at(4.1));  // what was the way out would lead into it now
  EXPECT_EQ(command(4.1).v_mps, 0);
  seen_.health.bumper_pressed = false;
  EXPECT_EQ(command(4.7).v_mps, 0);  // let go
  teleop_.press(kBackward, at(5));
  EXPECT_LT(command(5).v_mps, 0);
}

TEST_F(TeleopTest, WhereThePlatformSaysWhatIsTouchedThatHolds) {
  teleop_.press(kForward, at(1));
  command(1);
  seen_.health.bumper_pressed = true;
  seen_.health.bumper_bearings_rad = {deg_to_rad(150)};  // somebody has come from behind
  teleop_.press(kForward, at(1.1));
  EXPECT_GT(command(1.1).v_mps, 0);
  EXPECT_EQ(teleop_.held_back(), "backward");
  turn_to(90);  // and lies elsewhere as it turns
  seen_.health.bumper_bearings_rad = {deg_to_rad(60)};
  teleop_.press(kForward, at(2));
  EXPECT_EQ(command(2).v_mps, 0);
  seen_.health.bumper_bearings_rad = {deg_to_rad(-20), deg_to_rad(160)};
  EXPECT_EQ(command(2.1).v_mps, 0);
  EXPECT_EQ(teleop_.held_back(), "forward and backward");
  teleop_.press(kLeft, at(2.2));
  EXPECT_GT(command(2.2).w_radps, 0);
}

TEST_F(TeleopTest, AStopWhileABumperIsPressedDoesNotFreeIt) {
  teleop_.press(kForward, at(1));
  command(1);
  seen_.health.bumper_pressed = true;
  command(1.1);
  teleop_.press(kStop, at(1.2));
  command(1.2);
  teleop_.press(kForward, at(1.3));
  EXPECT_EQ(command(1.3).v_mps, 0);
}

TEST_F(TeleopTest, WhoHasEndedItDrivesNoMore) {
  teleop_.press(kForward, at(1));
  teleop_.press(kQuit, at(1));
  EXPECT_TRUE(teleop_.quit());
  EXPECT_EQ(command(1.1).v_mps, 0);
}

TEST_F(TeleopTest, ALineTellsWhatIsAskedAndWhy) {
  Observation seen;
  seen.odometry.T_odom_body = {1.204, -0.3, deg_to_rad(45)};
  teleop_.press(kForward, at(1));
  EXPECT_EQ(teleop_line(teleop_, seen, command(1), ""),
            "+0.30 m/s +0 deg/s (keys 0.30, 43), at 1.20 -0.30 m, 45 deg");
  seen_.health.bumper_pressed = seen.health.bumper_pressed = true;
  seen.health.motors_enabled = false;
  EXPECT_EQ(teleop_line(teleop_, seen, command(1.1), "2 keyframes"),
            "+0.00 m/s +0 deg/s (keys 0.30, 43), at 1.20 -0.30 m, 45 deg, MOTORS OFF, BUMPER, "
            "forward held, 2 keyframes");
}

TEST(KeyReader, KnowsArrowsAndLetters) {
  KeyReader reader;
  EXPECT_THAT(reader.read("wsadWSAD"),
              ElementsAre(kForward, kBackward, kLeft, kRight, kForward, kBackward, kLeft, kRight));
  EXPECT_THAT(reader.read("\x1b[A\x1b[B\x1b[D\x1b[C"),
              ElementsAre(kForward, kBackward, kLeft, kRight));
  EXPECT_THAT(reader.read("\x1bOA\x1bOD"), ElementsAre(kForward, kLeft));  // application mode
  EXPECT_THAT(reader.read("\x1b[1;2A"), ElementsAre(kForward));            // with shift
  EXPECT_THAT(reader.read("+=-_ q"), ElementsAre(kFaster, kFaster, kSlower, kSlower, kStop, kQuit));
}

TEST(KeyReader, AnyOtherKeyStops) {
  KeyReader reader;
  EXPECT_THAT(reader.read("x"), ElementsAre(kStop));
  EXPECT_THAT(reader.read("\r"), ElementsAre(kStop));
  EXPECT_THAT(reader.read("\x1b"), ElementsAre(kStop));
  reader = {};
  EXPECT_THAT(reader.read("\x1b[15~"), ElementsAre(kStop));  // F5
  EXPECT_THAT(reader.read("\x1b[[A"), ElementsAre(kStop));   // F1 on a console
  EXPECT_THAT(reader.read("\x1b[3~"), ElementsAre(kStop));   // delete
  EXPECT_THAT(reader.read("\x1bw"), ElementsAre(kStop));     // with alt
  EXPECT_THAT(reader.read("w"), ElementsAre(kForward));
}

TEST(KeyReader, PutsTogetherASequenceThatComesInPieces) {
  KeyReader reader;
  EXPECT_THAT(reader.read("\x1b"), ElementsAre(kStop));  // it might be the key of that name
  EXPECT_THAT(reader.read("["), ElementsAre());
  EXPECT_THAT(reader.read("A"), ElementsAre(kForward));
}

}  // namespace
}  // namespace panoptes
