// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/rig_check.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kFrame_s = 1.0 / 15;
constexpr int kFramesAKeyframe = 9;

Time time_at(double at_s) { return Time{} + from_seconds(at_s); }

// A turn on the spot to the left, a rest, then two metres ahead, a rest, and again.
Pose2 pose_at(double at_s) {
  constexpr double kTurn_rad_s = 0.6;
  constexpr double kTurn_s = 8;
  constexpr double kRest_s = 1;
  constexpr double kAhead_m_s = 0.3;
  constexpr double kAhead_s = 6;
  Pose2 T_map_body{-1, -1, 0};
  for (double left_s = at_s; left_s > 0; left_s -= kTurn_s + kAhead_s + 2 * kRest_s) {
    T_map_body.theta_rad += kTurn_rad_s * std::min(left_s, kTurn_s);
    const double ahead_m = kAhead_m_s * std::clamp(left_s - kTurn_s - kRest_s, 0.0, kAhead_s);
    T_map_body = T_map_body * Pose2{ahead_m, 0, 0};
  }
  return T_map_body;
}

struct Robot {
  LoopCameras believed = testing::front_and_back();
  LoopCameras truth = believed;
  std::vector<double> stamp_late_s = std::vector<double>(believed.size(), 0.0);
  std::vector<double> told_late_s = std::vector<double>(believed.size(), 0.0);  // stamped so, too
  double wheels_turn = 1;                                                       // of the truth
  double turns_in_m = 0;  // where it turns: a room of its own, so small; 0: where it drives
};

// What is said of the rig, and after how long; "" when a minute of driving shows no fault.
std::pair<std::string, double> fault_of(const Robot& robot) {
  const testing::SyntheticRoom room(2000, 3, Rng(5));
  const testing::SyntheticRoom small_room(2000, std::max(0.5, robot.turns_in_m), Rng(6));
  RigCheck check({}, robot.believed);
  double keyframe_s = 0;
  for (int frame = 0; frame * kFrame_s < 60; ++frame) {
    const double at_s = 1 + frame * kFrame_s;
    check.add_odometry(time_at(at_s), robot.wheels_turn * pose_at(at_s).theta_rad);
    if (frame % kFramesAKeyframe != 0) {
      continue;
    }
    PlaceFeatures features(robot.truth.size());
    for (std::size_t camera = 0; camera < robot.truth.size(); ++camera) {
      const Pose2 T_map_body = pose_at(at_s - robot.stamp_late_s[camera]);
      const bool turns = robot.turns_in_m > 0 && std::fmod(at_s, 16) < 8;
      features[camera] = (turns ? small_room : room)
                             .seen_from({robot.truth[camera]},
                                        turns ? Pose2{0, 0, T_map_body.theta_rad} : T_map_body, 0.5,
                                        0.2, Rng(100 * frame + camera))[0];
    }
    Pose2 T_last_here = pose_at(keyframe_s).inverse() * pose_at(at_s);
    T_last_here.theta_rad *= robot.wheels_turn;
    const PictureTimes times{{}, robot.told_late_s};
    check.add_keyframe(time_at(at_s), times, features, T_last_here);
    if (!check.fault().empty()) {
      return {check.fault(), at_s};
    }
    keyframe_s = at_s;
  }
  return {"", 60};
}

TEST(RigCheck, WhatACalibrationLeavesIsNoFault) {
  for (int seed = 1; seed <= 5; ++seed) {
    Rng rng(seed);
    Robot robot;
    robot.wheels_turn = 1 + rng.normal(0, 0.02);
    for (LoopCamera& camera : robot.truth) {
      const Vec3 turn(rng.normal(0, 0.035), rng.normal(0, 0.035), rng.normal(0, 0.035));
      camera.T_body_camera.rotation =
          camera.T_body_camera.rotation *
          Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
      camera.T_body_camera.translation += Vec3(rng.normal(0, 0.02), rng.normal(0, 0.02), 0);
    }
    robot.stamp_late_s = {rng.normal(0, 0.02), rng.normal(0, 0.02)};
    EXPECT_THAT(fault_of(robot).first, IsEmpty());
  }
}

TEST(RigCheck, CamerasFarAheadOfTheAxisAreNoFault) {
  Robot robot;
  for (LoopCamera& camera : robot.truth) {
    camera.T_body_camera.translation.x() *= 2.5;
  }
  robot.believed = robot.truth;
  EXPECT_THAT(fault_of(robot).first, IsEmpty());
}

// It turns in a closet and drives through a hall: turns show more than what drives let expect.
TEST(RigCheck, ThingsNearWhereItTurnsAreNoFault) {
  for (const double turns_in_m :
       {1.3, 0.5}) {  // half its width; the cameras pass its walls by 20 cm
    SCOPED_TRACE(turns_in_m);
    Robot robot;
    robot.turns_in_m = turns_in_m;
    for (LoopCamera& camera : robot.truth) {
      camera.T_body_camera.translation.x() *= 2.5;
    }
    robot.believed = robot.truth;
    EXPECT_THAT(fault_of(robot).first, IsEmpty());
  }
}

TEST(RigCheck, SwappedCamerasAreNamed) {
  Robot robot;
  std::swap(robot.truth[0], robot.truth[1]);
  EXPECT_THAT(fault_of(robot).first, HasSubstr("front and back look swapped"));
}

// Of pictures of one instant, stamped by clocks that a good calibration leaves: some later than
// all that the wheels told.
TEST(RigCheck, ClocksAFewMillisecondsOffHideNoFault) {
  for (const double late_s : {-0.01, 0.005, 0.01}) {
    SCOPED_TRACE(late_s);
    Robot sound;
    sound.told_late_s = {late_s, -late_s};
    EXPECT_THAT(fault_of(sound).first, IsEmpty());
    Robot swapped = sound;
    std::swap(swapped.truth[0], swapped.truth[1]);
    EXPECT_THAT(fault_of(swapped).first, HasSubstr("front and back look swapped"));
    Robot wide = sound;
    wide.truth[1].intrinsics = pinhole(320, 240, deg_to_rad(96));
    EXPECT_THAT(fault_of(wide).first, HasSubstr("the field of view of back looks wrong"));
  }
}

TEST(RigCheck, ACameraThatLooksTheOtherWayIsNamed) {
  Robot robot;
  robot.believed[1].T_body_camera = mounted_camera({-0.15, 0, 0.75}, std::numbers::pi / 2, 0);
  robot.truth[1].T_body_camera = mounted_camera({-0.15, 0, 0.75}, -std::numbers::pi / 2, 0);
  EXPECT_THAT(fault_of(robot).first,
              AllOf(HasSubstr("back does not look where the rig file says"), HasSubstr("-90")));
}

TEST(RigCheck, AnUpsideDownCameraIsNamed) {
  Robot robot;
  Eigen::Quaterniond& rotation = robot.truth[0].T_body_camera.rotation;
  rotation = rotation * Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitZ()));
  EXPECT_THAT(fault_of(robot).first, HasSubstr("front looks mirrored or upside down"));
}

TEST(RigCheck, AFieldOfViewOfAnotherLensIsNamed) {
  for (const double fov_deg : {64.0, 96.0}) {
    Robot robot;
    robot.truth[1].intrinsics = pinhole(320, 240, deg_to_rad(fov_deg));
    const auto [fault, after_s] = fault_of(robot);
    EXPECT_THAT(fault, AllOf(HasSubstr("the field of view of back looks wrong"),
                             HasSubstr(fov_deg > 80 ? "smaller" : "larger")));
    EXPECT_LT(after_s, 30);
  }
}

TEST(RigCheck, AnotherClockIsNamed) {
  for (const double late_s : {-0.5, 0.5}) {
    Robot robot;
    robot.stamp_late_s[1] = late_s;
    const auto [fault, after_s] = fault_of(robot);
    EXPECT_THAT(fault, AllOf(HasSubstr("the stamps of back look 0.50 s"),
                             HasSubstr(late_s > 0 ? "late" : "early")));
    EXPECT_LT(after_s, 30);
  }
}

TEST(RigCheck, AWheelBaseThatIsWrongIsNotBlamedOnACamera) {
  Robot robot;
  robot.wheels_turn = 0.7;
  EXPECT_THAT(fault_of(robot).first, HasSubstr("the wheel base or all fields of view"));
}

}  // namespace
}  // namespace panoptes
