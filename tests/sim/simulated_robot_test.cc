// SPDX-License-Identifier: BSD-3-Clause
#include "sim/simulated_robot.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "tests/sim/physics/rooms.h"

namespace panoptes::sim {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

TruthLayer layer_of(double size_m) {
  TruthLayer layer;
  layer.cell_m = 0.01;
  layer.origin_scene = {-0.2, -0.2};
  layer.columns = layer.rows = static_cast<int>(std::lround((size_m + 0.4) / layer.cell_m));
  layer.cells.resize(static_cast<std::size_t>(layer.columns) *
                     static_cast<std::size_t>(layer.rows));
  return layer;
}

// A room of 6 x 6 m with a desk; the pictures are grey, all floor below the middle.
Surroundings room() {
  Surroundings around;
  around.outlines = walls(6);
  around.outlines.push_back(box("desk", 2, 2, 4, 3));
  around.floor = layer_of(6);
  around.body = layer_of(6);
  around.draw = [](const View& view, const Ask& ask, const Moment&) {
    Drawn drawn;
    const int rows = view.intrinsics.height_px;
    const int columns = view.intrinsics.width_px;
    drawn.bgr = cv::Mat(rows, columns, CV_8UC3, cv::Scalar::all(120));
    if (ask.floor_label) {
      drawn.floor_label = cv::Mat(rows, columns, CV_8UC1, cv::Scalar(0));
      drawn.floor_label.rowRange(rows / 2, rows).setTo(255);
    }
    return drawn;
  };
  return around;
}

Rig two_cameras() {
  Rig rig;
  rig.cameras["front"].roles = {"loop_front"};
  rig.cameras["front"].intrinsics = pinhole(64, 48, deg_to_rad(80));
  rig.cameras["front"].T_body_camera = mounted_camera({0.02, 0, 0.78}, 0, 0);
  rig.cameras["floor"] = rig.cameras["front"];
  rig.cameras["floor"].roles = {"floor"};
  rig.cameras["floor"].T_body_camera = mounted_camera({0.02, 0, 0.75}, 0, deg_to_rad(28));
  rig.cameras["floor"].floor = FloorView{};
  return rig;
}

SimulatedOptions starting_at(double x_m, double y_m, double theta_rad = 0) {
  SimulatedOptions options;
  options.start = Pose2{x_m, y_m, theta_rad};
  return options;
}

SimulatedRobot robot_with(const SimulatedOptions& options, std::uint64_t seed = 1) {
  return SimulatedRobot(options, room(), Body{}, two_cameras(), Rng(seed));
}

std::string refusal(const std::function<void()>& what) {
  try {
    what();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "nothing refused";
}

TEST(SimulatedOptions, AreReadWithAllTheirErrors) {
  const std::string name = std::string(PANOPTES_SOURCE_DIR) + "/scenes/missions/some.yaml";
  const auto read = [&](const std::string& text) {
    return read_settings_text<SimulatedOptions>(text, name);
  };
  const SimulatedOptions options = read(
      "world: ../worlds/office.yaml\n"
      "start: {x_m: 2, y_m: 3, theta_deg: 90}\n"
      "mounting_error: {sigma_deg: 1, sigma_m: 0.005}\n"
      "wheel_error: {noise_m_per_sqrt_m: 0.01, diameter_difference: 0, base_error: 0, turn_slip: "
      "0}\n"
      "image_noise: {sigma_grey: 0}\n");
  EXPECT_FALSE(options.world.objects.empty());
  EXPECT_EQ(options.start->theta_rad, deg_to_rad(90));
  EXPECT_EQ(options.mounting_error.sigma_deg, 1);
  EXPECT_EQ(options.wheel_error.noise_m_per_sqrt_m, 0.01);
  EXPECT_EQ(options.image_noise.sigma_grey, 0);
  EXPECT_EQ(refusal([&] { read("image_noise: {sigma_gray: 1}\nwheel_error: {turn_slip: -1}\n"); }),
            name + ":1:1: world: missing; it must name the world's file\n" + name +
                ":1:15: image_noise.sigma_gray: unknown key; did you mean sigma_grey?\n" + name +
                ":2:26: wheel_error.turn_slip: must be from 0 to 0.2, got -1");
}

TEST(SimulatedRobot, DeliversFrameSetsOnTheRigsGridFromTimeZero) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  for (std::int64_t k = 0; k < 31; ++k) {
    const Observation seen = robot.observe(robot.now() + std::chrono::seconds(1));
    const std::int64_t expected_ns = (k * 1'000'000'000 + 7) / 15;
    EXPECT_EQ(seen.stamp.time_since_epoch().count(), expected_ns);
    EXPECT_EQ(robot.now(), seen.stamp);
    ASSERT_THAT(seen.pictures, SizeIs(2));
    EXPECT_EQ(seen.pictures.at("front").stamp, seen.stamp);
    EXPECT_EQ(seen.pictures.at("front").bgr.cols, 64);
  }
  EXPECT_THAT(robot.truth()->poses, SizeIs(31));
}

TEST(SimulatedRobot, ReturnsWithoutPicturesAtADeadlineAndLosesNoFrame) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  robot.observe(time_at(1));
  robot.drive({0.4, 0}, std::chrono::seconds(1));
  const Observation early = robot.observe(time_at(0.05));
  EXPECT_THAT(early.pictures, IsEmpty());
  EXPECT_EQ(early.stamp, time_at(0.05));
  EXPECT_EQ(robot.now(), time_at(0.05));
  const Observation past = robot.observe(time_at(0.01));
  EXPECT_THAT(past.pictures, IsEmpty());
  EXPECT_EQ(past.stamp, time_at(0.05)) << "time does not go back";
  const Observation frame = robot.observe(time_at(1));
  EXPECT_THAT(frame.pictures, SizeIs(2));
  EXPECT_EQ(frame.stamp.time_since_epoch().count(), 66'666'667);
  EXPECT_THAT(robot.truth()->poses, SizeIs(2));
}

TEST(SimulatedRobot, DrivesTheSameWhateverDeadlinesCutItsTime) {
  const auto drive = [](double deadline_s) {
    SimulatedRobot robot = robot_with(starting_at(1, 1));
    robot.observe(Time());
    robot.drive({0.4, 0.2}, std::chrono::seconds(10));
    while (robot.now() < time_at(2)) {
      robot.observe(std::min(time_at(2), robot.now() + from_seconds(deadline_s)));
    }
    return robot.truth()->poses.back().T_scene_body;
  };
  EXPECT_TRUE(drive(1) == drive(0.013));
}

TEST(SimulatedRobot, StopsWhenNotTold) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  robot.observe(Time());
  robot.drive({0.5, 0}, std::chrono::milliseconds(500));
  while (robot.now() < time_at(3)) {
    robot.observe(time_at(3));
  }
  const Truth truth = *robot.truth();
  EXPECT_EQ(truth.poses.back().twist_body.v_mps, 0);
  // 0.5 s up at 0.6 m/s2 and the same down
  const double way_m = 0.6 * 0.5 * 0.5;
  const double step_m = 0.3 / DriveWorld::kStepsPerSecond;
  EXPECT_NEAR(truth.path_m, way_m, step_m);
  EXPECT_NEAR(truth.poses.back().T_scene_body.x_m, 1 + way_m, step_m);
}

TEST(SimulatedRobot, OdometryStartsAtTheOriginOfOdom) {
  SimulatedRobot robot = robot_with(starting_at(1, 1, 2));
  EXPECT_TRUE(robot.observe(Time()).odometry.T_odom_body == Pose2());
}

TEST(SimulatedRobot, NeverWritesDeliveredPixelsAgain) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  const Observation first = robot.observe(time_at(1));
  const cv::Mat copy = first.pictures.at("front").bgr.clone();
  const Observation second = robot.observe(time_at(1));
  EXPECT_EQ(cv::norm(copy, first.pictures.at("front").bgr, cv::NORM_INF), 0);
  EXPECT_NE(first.pictures.at("front").bgr.data, second.pictures.at("front").bgr.data);
}

TEST(SimulatedRobot, TellsContactsClearanceAndBumper) {
  SimulatedRobot robot = robot_with(starting_at(1, 1, std::numbers::pi));
  EXPECT_NEAR(robot.truth()->path_m, 0, 0);
  Observation seen = robot.observe(Time());
  EXPECT_NEAR(robot.truth()->poses.front().clearance_m, 0.75, 1e-9);
  EXPECT_FALSE(seen.health.bumper_pressed);
  robot.drive({0.5, 0}, std::chrono::seconds(10));
  while (robot.now() < time_at(5)) {
    seen = robot.observe(time_at(5));
  }
  EXPECT_TRUE(seen.health.bumper_pressed);
  const Truth truth = *robot.truth();
  ASSERT_THAT(truth.contacts, SizeIs(1));
  EXPECT_EQ(truth.contacts.front().object, "west wall");
  EXPECT_TRUE(truth.contacts.front().while_moving);
}

TEST(SimulatedRobot, MarksWhatTheFloorCameraSaw) {
  SimulatedRobot robot = robot_with(starting_at(1, 1, 0));
  robot.observe(Time());
  const TruthLayer seen = robot.truth()->seen;
  EXPECT_EQ(seen.cell_m, 0.05);
  EXPECT_TRUE(seen.at({1 + 0.25 + 0.6, 1}));
  EXPECT_FALSE(seen.at({1 + 0.25 + 0.1, 1})) << "the blind gap";
  EXPECT_FALSE(seen.at({0.5, 1})) << "behind";
}

TEST(SimulatedRobot, SurveysTheFloorOfTheTrueRig) {
  const SimulatedRobot robot = robot_with(starting_at(1, 1));
  EXPECT_THAT(robot.rig().cameras.at("floor").floor->marks, SizeIs(4));
  EXPECT_FALSE(robot.rig().cameras.at("front").floor.has_value());
  Rig known = two_cameras();
  known.cameras["floor"].floor->H_body_px = Mat3::Identity();
  const SimulatedRobot told(starting_at(1, 1), room(), Body{}, known, Rng(1));
  EXPECT_THAT(told.rig().cameras.at("floor").floor->marks, IsEmpty()) << "nothing to survey";
}

TEST(SimulatedRobot, DrawsAStartWithRoomAroundItFromTheSeed) {
  const Obstacles obstacles(room().outlines);
  std::vector<double> xs;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SimulatedRobot robot = robot_with({}, seed);
    robot.observe(Time());
    const Pose2 start = robot.truth()->poses.front().T_scene_body;
    EXPECT_FALSE(obstacles.nearest(start.position(), 0.7));
    EXPECT_TRUE(start.x_m > 0 && start.x_m < 6 && start.y_m > 0 && start.y_m < 6);
    xs.push_back(start.x_m);
    SimulatedRobot again = robot_with({}, seed);
    again.observe(Time());
    EXPECT_TRUE(again.truth()->poses.front().T_scene_body == start);
  }
  EXPECT_GT(*std::max_element(xs.begin(), xs.end()) - *std::min_element(xs.begin(), xs.end()), 2);
}

TEST(SimulatedRobot, RefusesAStartInsideOrTouchingSomething) {
  EXPECT_EQ(
      refusal([] { robot_with(starting_at(3, 2.5)); }),
      "platform.start: x_m: 3.000, y_m: 2.500 is inside desk; move the start, or leave it out "
      "to have one drawn from the seed");
  EXPECT_EQ(
      refusal([] { robot_with(starting_at(3, 1.85)); }),
      "platform.start: x_m: 3.000, y_m: 1.850 is 0.150 m from desk, but 0.70 m about the start "
      "must be clear, for the robot cannot see the floor at its feet and takes it for free; move "
      "the start, or leave it out to "
      "have one drawn from the seed");
  EXPECT_EQ(
      refusal([] { robot_with(starting_at(9, 1)); }),
      "platform.start: x_m: 9.000, y_m: 1.000 is outside of the world, which reaches from "
      "(-0.10, -0.10) to (6.10, 6.10); move the start, or leave it out to have one drawn from "
      "the seed");
}

TEST(SimulatedRobot, RefusesAWorldWithoutRoomForAStart) {
  Surroundings cell = room();
  cell.outlines = walls(1.2);
  EXPECT_EQ(
      refusal([&] { SimulatedRobot({}, cell, Body{}, two_cameras(), Rng(1)); }),
      "platform.start: no place in the world has 0.70 m clear all around where the robot could "
      "start; give a start");
}

TEST(SimulatedRobot, RefusesRatesThatItCannotKeep) {
  Rig uneven = two_cameras();
  uneven.cameras["front"].rate_hz = 30;
  EXPECT_EQ(refusal([&] { SimulatedRobot(starting_at(1, 1), room(), Body{}, uneven, Rng(1)); }),
            "rig.cameras.front.rate_hz: is 30, but floor has 15; the simulated cameras are "
            "synchronous and must have one rate");
  Rig odd = two_cameras();
  odd.cameras["front"].rate_hz = odd.cameras["floor"].rate_hz = 25;
  EXPECT_EQ(refusal([&] { SimulatedRobot(starting_at(1, 1), room(), Body{}, odd, Rng(1)); }),
            "rig.cameras.floor.rate_hz: is 25; the simulated cameras' must go into 120 Hz without "
            "remainder (10, 12, 15, 20, 24, 30, 60, ...)");
}

TEST(SimulatedRobot, FollowsARouteWhateverItIsTold) {
  SimulatedRobot robot = robot_with(starting_at(1, 1));
  robot.follow({{{3, 1}, {5, 1}, {5, 4}}, 0.5});
  while (!robot.route_done() && robot.now() < time_at(40)) {
    robot.observe(time_at(40));
    robot.drive({-0.5, 1}, std::chrono::seconds(1));
  }
  EXPECT_TRUE(robot.route_done());
  const Truth truth = *robot.truth();
  EXPECT_THAT(truth.contacts, IsEmpty());
  EXPECT_NEAR((truth.poses.back().T_scene_body.position() - Vec2(5, 4)).norm(), 0, 0.1);
}

TEST(SimulatedRobot, RepeatsItselfBitForBit) {
  const auto drive = [](std::uint64_t seed) {
    SimulatedRobot robot = robot_with({}, seed);
    Rng rng(9);
    Observation last;
    while (robot.now() < time_at(20)) {
      last = robot.observe(time_at(20));
      robot.drive({rng.uniform(-0.6, 0.6), rng.uniform(-1.5, 1.5)}, std::chrono::seconds(1));
    }
    return last;
  };
  const Observation a = drive(3);
  const Observation b = drive(3);
  EXPECT_TRUE(a.odometry.T_odom_body == b.odometry.T_odom_body);
  EXPECT_EQ(cv::norm(a.pictures.at("front").bgr, b.pictures.at("front").bgr, cv::NORM_INF), 0);
  EXPECT_FALSE(a.odometry.T_odom_body == drive(4).odometry.T_odom_body);
}

}  // namespace
}  // namespace panoptes::sim
