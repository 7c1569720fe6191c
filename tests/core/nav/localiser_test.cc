// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/localiser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/core/nav/room_robot.h"

namespace panoptes {
namespace {

std::vector<Vec2> no_contours(int /*keyframe*/) { return {}; }

TEST(Localiser, FirstObservationFoundsTheMap) {
  test::RoomRobot robot(1);
  Localiser localiser({}, Body{}, robot.rig(), Rng(1));
  const Located at = localiser.step(robot.look(0, {0.5, 0.2, 0.3}, {}), no_contours);
  EXPECT_EQ(at.keyframe_made, 0);
  EXPECT_EQ(at.T_map_body, Pose2{});
  EXPECT_EQ(localiser.keyframes().size(), 1U);
}

TEST(Localiser, RemembersAPlaceAfterTheWayOrTheTurnThatOptionsSay) {
  test::RoomRobot robot(2);
  Localiser localiser({}, Body{}, robot.rig(), Rng(2));
  localiser.step(robot.look(0, {}, {}), no_contours);
  EXPECT_FALSE(localiser.step(robot.look(1, {0.2, 0, 0}, {0.2, 0, 0}), no_contours).keyframe_made);
  EXPECT_TRUE(localiser.step(robot.look(2, {0.26, 0, 0}, {0.26, 0, 0}), no_contours).keyframe_made);
  const double turn_rad = deg_to_rad(16);
  const Pose2 turned{0.26, 0, turn_rad};
  EXPECT_TRUE(localiser.step(robot.look(3, turned, turned), no_contours).keyframe_made);
}

TEST(Localiser, PicturesMendTheHeadingThatWheelsGetWrong) {
  // what feature matching leaves over a dozen keyframes is a tenth of a degree each at the worst
  constexpr double kHeadingLeft_deg = 1.2;
  test::RoomRobot robot(3);
  Localiser localiser({}, Body{}, robot.rig(), Rng(3));
  Pose2 T_scene_body{-1.5, -0.5, 0};
  const Pose2 T_scene_map = T_scene_body;
  Pose2 T_odom_body;
  localiser.step(robot.look(0, T_scene_body, T_odom_body), no_contours);
  Located at;
  for (int i = 1; i <= 12; ++i) {
    const Pose2 moved{0.25, 0, deg_to_rad(4)};
    T_scene_body = T_scene_body * moved;
    T_odom_body = T_odom_body * Pose2{0.25, 0, deg_to_rad(4.6)};  // wheels turn too far each time
    at = localiser.step(robot.look(i, T_scene_body, T_odom_body), no_contours);
  }
  const Pose2 error = (T_scene_map * at.T_map_body).inverse() * T_scene_body;
  const Pose2 wheels = (T_scene_map * T_odom_body).inverse() * T_scene_body;
  EXPECT_GT(std::abs(rad_to_deg(wheels.theta_rad)), 5 * kHeadingLeft_deg);
  EXPECT_LT(std::abs(rad_to_deg(error.theta_rad)), kHeadingLeft_deg);
}

TEST(Localiser, GoesOnByTheWheelsWithoutPictures) {
  test::RoomRobot robot(4);
  Localiser localiser({}, Body{}, robot.rig(), Rng(4));
  localiser.step(robot.look(0, {}, {}), no_contours);
  Observation blind;
  blind.stamp = time_at(1);
  blind.odometry.T_odom_body = {0.7, 0.1, 0.2};
  const Located at = localiser.step(blind, no_contours);
  EXPECT_FALSE(at.keyframe_made);
  EXPECT_EQ(at.T_map_body, blind.odometry.T_odom_body);
}

TEST(Localiser, PlacesPicturesWhereTheyWereTaken) {
  test::RoomRobot robot(6);
  Localiser localiser({}, Body{}, robot.rig(), Rng(6));
  localiser.step(robot.look(0, {}, {}), no_contours);
  // The cameras have seen it at 0.3 m, 50 ms before the set, when the wheels are 2 cm farther.
  const Pose2 then{0.3, 0, 0};
  const Twist2 twist{0.4, 0.2};
  Observation seen = robot.look(2, then, then * exp_twist(twist, 0.05));
  seen.odometry.twist_body = twist;
  seen.pictures.at("front").stamp = seen.pictures.at("back").stamp = time_at(1.95);
  const Located at = localiser.step(seen, no_contours);
  ASSERT_TRUE(at.keyframe_made);
  const Keyframe& keyframe = localiser.keyframes().back();
  EXPECT_EQ(keyframe.stamp, time_at(1.95));
  constexpr double kRoundoff = 1e-12;
  EXPECT_NEAR((keyframe.T_wheels_body.position() - then.position()).norm(), 0, kRoundoff);
  EXPECT_NEAR(keyframe.T_wheels_body.theta_rad, 0, kRoundoff);
  const Pose2 ahead = keyframe.T_odom_body.inverse() * at.T_odom_body;
  EXPECT_NEAR((ahead.position() - exp_twist(twist, 0.05).position()).norm(), 0, kRoundoff);
}

TEST(Localiser, RefusesARigThatCannotRecognisePlaces) {
  test::RoomRobot robot(5);
  Rig rig = robot.rig();
  rig.cameras.erase("back");
  EXPECT_THROW(Localiser({}, Body{}, rig, Rng(5)), ConfigError);
}

}  // namespace
}  // namespace panoptes
