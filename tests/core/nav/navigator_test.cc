// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/navigator.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/nav/room_robot.h"

namespace panoptes {
namespace {

constexpr double kFrame_s = 1.0 / 15;

// Slam and the navigator beside it, and what both say of an observation.
struct Explorer {
  struct Step : PilotStep {
    SlamStep at;
  };
  Slam slam;
  Navigator navigator;

  explicit Explorer(const Rig& rig, const NavigatorOptions& options = {},
                    const StageListener& listener = {})
      : slam(options.slam, Body{}, rig, Rng(7), listener),
        navigator(options, Body{}, {from_seconds(kFrame_s), from_seconds(kFrame_s)}, slam, Rng(7),
                  listener) {}

  Step step(const Observation& seen) {
    SlamStep at = slam.step(seen);
    Step step{navigator.step(seen, at), {}};
    step.at = std::move(at);
    return step;
  }
};

// Drives an ideal robot by the navigator's commands.
std::vector<Explorer::Step> drive(Explorer& explorer, test::RoomRobot& robot, const Pose2& start,
                                  int frames) {
  std::vector<Explorer::Step> steps;
  Pose2 T_odom_body;
  Twist2 twist;
  for (int i = 0; i < frames; ++i) {
    Observation seen = robot.look(i * kFrame_s, start * T_odom_body, T_odom_body);
    seen.odometry.twist_body = twist;
    steps.push_back(explorer.step(seen));
    twist = steps.back().command_body;
    T_odom_body = T_odom_body * exp_twist(twist, kFrame_s);
  }
  return steps;
}

// Driven to goals until all are reached or refused, or time is out.
struct Sent {
  std::vector<GoalProgress> goals;
  std::vector<Pose2> T_map_ended;  // where the robot truly was when each ended,
  std::vector<Twist2> ended_at;    // and how fast
  bool done = false;
};
Sent send(const Pose2& start, const std::vector<Vec2>& goals_map, double most_s) {
  test::RoomRobot robot(12);
  Slam slam({}, Body{}, robot.rig(), Rng(7));
  Navigator navigator({}, Body{}, {from_seconds(kFrame_s), from_seconds(kFrame_s)}, slam, Rng(7),
                      {}, goals_map);
  Sent sent;
  Pose2 T_odom_body;
  Twist2 twist;
  for (int i = 0; i * kFrame_s < most_s && !navigator.done(); ++i) {
    Observation seen = robot.look(i * kFrame_s, start * T_odom_body, T_odom_body);
    seen.odometry.twist_body = twist;
    const SlamStep at = slam.step(seen);
    const PilotStep step = navigator.step(seen, at);
    sent.goals = step.goals;
    const auto ended = static_cast<std::size_t>(
        std::count_if(step.goals.begin(), step.goals.end(),
                      [](const GoalProgress& goal) { return goal.ended.has_value(); }));
    if (ended > sent.ended_at.size()) {
      sent.T_map_ended.push_back(T_odom_body);
      sent.ended_at.push_back(twist);
    }
    twist = step.command_body;
    T_odom_body = T_odom_body * exp_twist(twist, kFrame_s);
  }
  sent.done = navigator.done();
  return sent;
}

TEST(Navigator, DrivesToGoalsInTurnAndStandsAtEach) {
  const Sent sent = send({-1, -0.5, 0}, {{1.2, 0}, {1.2, -0.6}}, 40);
  EXPECT_TRUE(sent.done);
  ASSERT_EQ(sent.goals.size(), 2U);
  ASSERT_EQ(sent.ended_at.size(), 2U);
  constexpr double kReached_m = 0.15;
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(sent.goals[i].state, GoalProgress::State::kReached) << sent.goals[i].why;
    EXPECT_LT((sent.T_map_ended[i].position() - sent.goals[i].goal_map).norm(), kReached_m);
    EXPECT_LT(std::abs(sent.ended_at[i].v_mps), 0.01);
  }
  EXPECT_EQ(sent.goals[0].ended, sent.goals[1].began.value() - from_seconds(kFrame_s));
}

TEST(Navigator, RefusesAGoalInAWallAtAStandAndDrivesToTheNext) {
  const Sent sent = send({1.2, -1, 0}, {{1.8, 0}, {0.5, 0}}, 40);
  EXPECT_TRUE(sent.done);
  ASSERT_EQ(sent.goals.size(), 2U);
  EXPECT_EQ(sent.goals[0].state, GoalProgress::State::kRefused);
  EXPECT_EQ(sent.goals[0].why, "something stands there");
  ASSERT_FALSE(sent.ended_at.empty());
  EXPECT_EQ(sent.ended_at[0].v_mps, 0);
  EXPECT_EQ(sent.ended_at[0].w_radps, 0);
  EXPECT_EQ(sent.goals[1].state, GoalProgress::State::kReached) << sent.goals[1].why;
}

TEST(Navigator, HasReachedAGoalWhereItStandsWithoutMoving) {
  const Sent sent = send({-1, 0, 0}, {{0, 0}}, 5);
  EXPECT_TRUE(sent.done);
  ASSERT_EQ(sent.goals.size(), 1U);
  EXPECT_EQ(sent.goals[0].state, GoalProgress::State::kReached);
  EXPECT_EQ(sent.T_map_ended.at(0), Pose2());
}

TEST(Navigator, GivesTheSameStepsForTheSameObservations) {
  const Pose2 start{-1, 0, 0.4};
  std::vector<std::vector<Explorer::Step>> runs;
  for (int run = 0; run < 2; ++run) {
    test::RoomRobot robot(11);
    Explorer explorer(robot.rig());
    runs.push_back(drive(explorer, robot, start, 20));
  }
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    EXPECT_EQ(runs[0][i].at.T_map_body, runs[1][i].at.T_map_body);
    EXPECT_EQ(runs[0][i].command_body.v_mps, runs[1][i].command_body.v_mps);
    EXPECT_EQ(runs[0][i].command_body.w_radps, runs[1][i].command_body.w_radps);
    EXPECT_EQ(runs[0][i].reason, runs[1][i].reason);
  }
}

TEST(Navigator, MovesAndMapsFromAStartThatSeesFloor) {
  test::RoomRobot robot(12);
  Explorer explorer(robot.rig());
  const std::vector<Explorer::Step> steps = drive(explorer, robot, {-1, 0, 0.4}, 30);
  EXPECT_EQ(explorer.slam.start_fault(), "");
  EXPECT_GT(steps.back().mapped_free_m2, 1.0);
  EXPECT_TRUE(std::any_of(steps.begin(), steps.end(), [](const Explorer::Step& step) {
    return step.command_body.v_mps != 0 || step.command_body.w_radps != 0;
  }));
}

TEST(Navigator, MapsThroughLensesThatBend) {
  const Pose2 start{-1, 0, 0.4};
  for (const Distortion& lens :
       std::vector<Distortion>{BrownConrady{-0.25, 0.06, 0.001, -0.001, 0}, Equidistant{}}) {
    test::RoomRobot robot(12);
    robot.bend(lens);
    std::map<std::string, int> begun;
    Explorer explorer(robot.rig(), {}, [&begun](std::string_view stage, bool begins) {
      begun[std::string(stage)] += begins;
    });
    constexpr int kFrames = 8;
    const std::vector<Explorer::Step> steps = drive(explorer, robot, start, kFrames);
    EXPECT_EQ(begun["rectifying"], kFrames);
    EXPECT_EQ(explorer.slam.start_fault(), "");
    EXPECT_GT(steps.back().mapped_free_m2, 1.0);
    // Floor on the way to the box, and the box.
    const OccupancyMap map = explorer.slam.map(0.05);
    const auto in_map = [&start](const Vec2& p_scene) { return start.inverse() * p_scene; };
    EXPECT_EQ(map.at(in_map({0.5, 0.5})), Cell::kFree);
    EXPECT_NE(map.at(in_map({1.7, 1.0})), Cell::kFree);
  }
}

TEST(Navigator, MapsTheFloorBehindItWithASecondFloorCamera) {
  const Vec2 behind_map(-1, 0);
  const auto floor_behind = [&](test::RoomRobot& robot) {
    Explorer explorer(robot.rig());
    for (int i = 0; i < 5; ++i) {
      explorer.step(robot.look(i * kFrame_s, {-1, 0, 0}, {}));
    }
    return explorer.slam.map(0.05).at(behind_map);
  };
  test::RoomRobot one_camera(12);
  EXPECT_EQ(floor_behind(one_camera), Cell::kUnknown);
  test::RoomRobot two_cameras(12);
  two_cameras.look_back_at_the_floor();
  EXPECT_EQ(floor_behind(two_cameras), Cell::kFree);
}

TEST(Navigator, WaitsUntilItHasSeenTheFloorAndLivesWithSetsThatMissCameras) {
  test::RoomRobot robot(12);
  Explorer explorer(robot.rig());
  const Pose2 start{-1, 0, 0.4};
  Pose2 T_odom_body;
  bool moved = false;
  for (int i = 0; i < 40; ++i) {
    Observation seen = robot.look(i * kFrame_s, start * T_odom_body, T_odom_body);
    if (i < 3 || i % 4 == 0) {
      seen.pictures.erase("floor");
    }
    if (i % 5 == 3) {
      seen.pictures.erase("front");
    }
    const Explorer::Step step = explorer.step(seen);
    if (i < 3) {
      EXPECT_EQ(step.command_body.v_mps, 0);
      EXPECT_EQ(step.command_body.w_radps, 0);
      EXPECT_EQ(step.reason, "waits for the first pictures");
    }
    moved = moved || step.command_body.v_mps != 0 || step.command_body.w_radps != 0;
    T_odom_body = T_odom_body * exp_twist(step.command_body, kFrame_s);
  }
  EXPECT_EQ(explorer.slam.start_fault(), "");
  EXPECT_TRUE(moved);
}

// Drives until `bad_from`; from then on what `spoil` makes of it is seen.
struct Spoiled {
  Explorer::Step first;  // of those spoiled
  Explorer::Step last;
  double free_before_m2 = 0;
  double free_after_m2 = 0;
  std::size_t keyframes_before = 0;
  std::size_t keyframes_after = 0;
  std::string lost_cameras;
  bool done = false;
};
Spoiled spoiled(const std::function<void(Observation&)>& spoil, int frames) {
  test::RoomRobot robot(12);
  NavigatorOptions options;
  options.camera_patience_s = 1;
  Explorer explorer(robot.rig(), options);
  const Pose2 start{-1, 0, 0.4};
  Pose2 T_odom_body;
  Twist2 twist;
  constexpr int kBadFrom = 25;
  Spoiled out;
  for (int i = 0; i < kBadFrom + frames; ++i) {
    if (i == kBadFrom) {
      EXPECT_GT(std::abs(twist.v_mps) + std::abs(twist.w_radps), 0);
    }
    if (i == kBadFrom + 1) {  // what freezes has been seen once
      out.free_before_m2 = explorer.slam.map(0.05).area_m2(Cell::kFree);
      out.keyframes_before = explorer.slam.keyframes().size();
    }
    Observation seen = robot.look(i * kFrame_s, start * T_odom_body, T_odom_body);
    seen.odometry.twist_body = twist;
    if (i >= kBadFrom) {
      spoil(seen);
    }
    out.last = explorer.step(seen);
    if (i == kBadFrom) {
      out.first = out.last;
    }
    twist = out.last.command_body;
    T_odom_body = T_odom_body * exp_twist(twist, kFrame_s);
  }
  out.free_after_m2 = explorer.slam.map(0.05).area_m2(Cell::kFree);
  out.keyframes_after = explorer.slam.keyframes().size();
  out.lost_cameras = explorer.navigator.lost_cameras();
  out.done = explorer.navigator.done();
  return out;
}

std::function<void(Observation&)> freeze(const std::string& camera) {
  auto kept = std::make_shared<cv::Mat>();
  return [camera, kept](Observation& seen) {
    cv::Mat& bgr = seen.pictures.at(camera).bgr;
    *kept = kept->empty() ? bgr : *kept;
    bgr = *kept;
  };
}

std::function<void(Observation&)> darken(const std::vector<std::string>& cameras) {
  return [cameras](Observation& seen) {
    for (const std::string& camera : cameras) {
      cv::Mat& bgr = seen.pictures.at(camera).bgr;
      bgr = cv::Mat::zeros(bgr.size(), bgr.type());
    }
  };
}

TEST(Navigator, StandsAndMapsNothingWhileTheFloorCameraIsLost) {
  constexpr int kAWhile = 10;
  for (const auto& [fault, spoil] : std::map<std::string, std::function<void(Observation&)>>{
           {"frozen", freeze("floor")},
           {"dark", darken({"floor"})},
           {"missing", [](Observation& seen) { seen.pictures.erase("floor"); }}}) {
    const Spoiled run = spoiled(spoil, kAWhile);
    EXPECT_TRUE(run.last.camera_lost) << fault;
    EXPECT_EQ(run.last.state, PilotState::kStopped);
    EXPECT_EQ(run.last.command_body.v_mps, 0);
    EXPECT_EQ(run.last.command_body.w_radps, 0);
    EXPECT_EQ(run.last.reason, "camera floor: " + fault);
    EXPECT_FALSE(run.last.goal_map);
    // what the body covers while it comes to rest is free
    EXPECT_NEAR(run.free_after_m2, run.free_before_m2, 0.1) << fault;
    EXPECT_EQ(run.lost_cameras, "");
  }
}

TEST(Navigator, GivesUpOnAFloorCameraThatDoesNotComeBack) {
  constexpr int kLongerThanItWaits = 18;
  const Spoiled run = spoiled(darken({"front", "back", "floor"}), kLongerThanItWaits);
  EXPECT_EQ(run.lost_cameras, "camera back: dark; camera floor: dark; camera front: dark");
  EXPECT_FALSE(run.done);
}

TEST(Navigator, DrivesOnWhenItSeesTheFloorAgain) {
  int left = 8;
  const auto spoil = darken({"floor"});
  const Spoiled run = spoiled(
      [&](Observation& seen) {
        if (left-- > 0) {
          spoil(seen);
        }
      },
      20);
  EXPECT_TRUE(run.first.camera_lost);
  EXPECT_FALSE(run.last.camera_lost);
  EXPECT_GT(std::abs(run.last.command_body.v_mps) + std::abs(run.last.command_body.w_radps), 0);
  EXPECT_EQ(run.lost_cameras, "");
}

TEST(Navigator, DrivesOnAndMakesKeyframesWithoutALoopCamera) {
  const Spoiled run = spoiled([](Observation& seen) { seen.pictures.erase("front"); }, 60);
  EXPECT_FALSE(run.last.camera_lost);
  EXPECT_GT(run.keyframes_after, run.keyframes_before + 1);
  EXPECT_THAT(run.last.reason, testing::HasSubstr("; camera front: missing"));
}

TEST(Navigator, RefusesAStartBeforeAThingWheneverTheFloorCameraBeginsToSee) {
  test::RoomRobot robot(13);
  Explorer explorer(robot.rig());
  const Pose2 close{1.6 - 0.42, 1.0, 0};
  Observation without = robot.look(0, close, {});
  without.pictures.erase("floor");
  explorer.step(without);
  EXPECT_EQ(explorer.slam.start_fault(), "");
  explorer.step(robot.look(kFrame_s, close, {}));
  EXPECT_NE(explorer.slam.start_fault(), "");
}

TEST(Navigator, StandsStillWhereTheStartShowsNoFloor) {
  test::RoomRobot robot(13);
  Explorer explorer(robot.rig());
  const double close_m = 0.42;  // the box begins nearer than the floor is seen
  const std::vector<Explorer::Step> steps = drive(explorer, robot, {1.6 - close_m, 1.0, 0}, 5);
  EXPECT_NE(explorer.slam.start_fault(), "");
  for (const Explorer::Step& step : steps) {
    EXPECT_EQ(step.command_body.v_mps, 0);
    EXPECT_EQ(step.command_body.w_radps, 0);
    EXPECT_EQ(step.reason, explorer.slam.start_fault());
  }
}

TEST(Navigator, StandsWhileTheWheelsTellNoNumberAndGoesOnWhenTheyDo) {
  test::RoomRobot robot(12);
  Explorer explorer(robot.rig());
  test::RoomRobot same(12);
  Explorer undisturbed(same.rig());
  const Pose2 start{-1, 0, 0.4};
  Pose2 T_odom_body;
  for (int i = 0; i < 10; ++i) {
    const Observation seen = robot.look(i * kFrame_s, start * T_odom_body, T_odom_body);
    for (const double no_number : {std::nan(""), HUGE_VAL}) {
      Observation broken = seen;
      (i % 2 == 0 ? broken.odometry.T_odom_body.theta_rad : broken.odometry.twist_body.v_mps) =
          no_number;
      const Explorer::Step stands = explorer.step(broken);
      EXPECT_EQ(stands.command_body.v_mps, 0);
      EXPECT_EQ(stands.command_body.w_radps, 0);
      EXPECT_EQ(stands.state, PilotState::kStopped);
      EXPECT_EQ(stands.reason, "the wheels tell no number");
    }
    const Explorer::Step step = explorer.step(seen);
    const Explorer::Step wanted = undisturbed.step(seen);
    EXPECT_EQ(step.at.T_map_body, wanted.at.T_map_body);
    EXPECT_EQ(step.command_body.w_radps, wanted.command_body.w_radps);
    EXPECT_EQ(step.reason, wanted.reason);
    T_odom_body = T_odom_body * exp_twist(step.command_body, kFrame_s);
  }
}

// Its counters begin anew, as when the base is switched off and on.
TEST(Navigator, WheelsThatJumpMoveNothingInTheMap) {
  test::RoomRobot robot(12);
  Explorer explorer(robot.rig());
  const Pose2 start{-1, 0, 0.4};
  const Pose2 T_anew{5, -2, 1.3};
  Pose2 T_true;
  int told = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose2 T_odom_body = i < 30 ? T_true : T_anew * T_true;
    const Explorer::Step step =
        explorer.step(robot.look(i * kFrame_s, start * T_true, T_odom_body));
    if (step.reason.find("jumped by") != std::string::npos) {
      ++told;
      EXPECT_EQ(step.command_body.v_mps, 0);
      EXPECT_EQ(step.command_body.w_radps, 0);
    }
    EXPECT_LT((step.at.T_map_body.position() - T_true.position()).norm(), 0.05) << i;
    T_true = T_true * exp_twist(step.command_body, kFrame_s);
  }
  EXPECT_EQ(told, 1);
}

// The map after the robot was driven by hand along y = 1 through where it sees a box.
OccupancyMap map_driven_through_the_box(double step_m, bool touching) {
  test::RoomRobot robot(12);
  Explorer explorer(robot.rig());
  const Pose2 start{0.2, 1, 0};
  double at_s = 0;
  for (double x_m = 0; x_m <= 1.7; x_m += step_m) {
    Observation seen = robot.look(at_s += kFrame_s, start * Pose2{x_m, 0, 0}, {x_m, 0, 0});
    seen.health.bumper_pressed = touching;
    explorer.step(seen);
  }
  return explorer.slam.map(0.01);
}

TEST(Navigator, WhatTheBodyHasDrivenThroughIsFreeInTheMap) {
  const double radius_m = Body().radius_m;
  for (const double step_m : {0.04, 0.2}) {
    const OccupancyMap map = map_driven_through_the_box(step_m, false);
    for (double x = 0; x < 1.7; x += 0.01) {
      for (const double y : {-0.9 * radius_m, 0.0, 0.9 * radius_m}) {
        ASSERT_EQ(map.at(Vec2(x, y)), Cell::kFree) << step_m << ": " << x << " " << y;
      }
    }
  }
}

TEST(Navigator, WheelsThatTurnAgainstWhatTheBumperTouchesDriveThroughNothing) {
  const OccupancyMap map = map_driven_through_the_box(0.04, true);
  int occupied = 0;
  for (double x = 1; x < 1.7; x += 0.01) {
    occupied += map.at(Vec2(x, 0)) == Cell::kOccupied ? 1 : 0;
  }
  EXPECT_GT(occupied, 0);
}

TEST(Navigator, EveryStageThatBeginsEnds) {
  test::RoomRobot robot(14);
  std::map<std::string, int> open;
  std::map<std::string, int> times;
  Explorer explorer(robot.rig(), {}, [&](std::string_view stage, bool begins) {
    open[std::string(stage)] += begins ? 1 : -1;
    times[std::string(stage)] += begins ? 1 : 0;
  });
  drive(explorer, robot, {-1, 0, 0.4}, 3);
  EXPECT_THAT(open, testing::Each(testing::Pair(testing::_, 0)));
  EXPECT_THAT(times, testing::UnorderedElementsAre(
                         testing::Pair("odometry", 3), testing::Pair("slam", 3),
                         testing::Pair("mapping", 3), testing::Pair("planning", 3)));
}

}  // namespace
}  // namespace panoptes
