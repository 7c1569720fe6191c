// SPDX-License-Identifier: BSD-3-Clause
#include "tests/hw/replay/scripted_robot.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/rng.h"

namespace panoptes::hw {
namespace {

cv::Mat noise(Rng rng) {
  cv::Mat bgr(6, 8, CV_8UC3);
  for (int i = 0; i < 6 * 8 * 3; ++i) {
    bgr.data[i] = static_cast<unsigned char>(rng.index(256));
  }
  return bgr;
}

TruthLayer layer(double cell_m, int columns, int rows) {
  TruthLayer made{cell_m, {-0.1, 1.0 / 3}, columns, rows, {}};
  made.cells.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  return made;
}

void expect_same(double a, double b) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b)) << a << " " << b;
}

void expect_same(const Pose2& a, const Pose2& b) {
  expect_same(a.x_m, b.x_m);
  expect_same(a.y_m, b.y_m);
  expect_same(a.theta_rad, b.theta_rad);
}

void expect_same(const Twist2& a, const Twist2& b) {
  expect_same(a.v_mps, b.v_mps);
  expect_same(a.w_radps, b.w_radps);
}

void expect_same(const TruthLayer& a, const TruthLayer& b) {
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.rows, b.rows);
  expect_same(a.cell_m, b.cell_m);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_TRUE(a.cells == b.cells);
}

}  // namespace

Rig small_rig() {
  Rig rig;
  for (const char* name : {"floor", "front"}) {
    RigCamera camera;
    camera.roles = {name};
    camera.rate_hz = 10;
    camera.intrinsics = pinhole(8, 6, 1.2);
    rig.cameras[name] = camera;
  }
  FloorView view;
  view.marks = {{{1, 1}, {0, 5}}, {{1, -1}, {7, 5}}, {{2, 1}, {0, 3}}, {{2, -1}, {7, 3}}};
  rig.cameras["floor"].floor = view;
  return rig;
}

ScriptedRobot::ScriptedRobot(int observations) : left_(observations) {
  truth_.floor = layer(0.01, 30, 20);
  truth_.body = truth_.floor;
  truth_.seen = layer(0.05, 6, 4);
  truth_.floor.cells[35] = 1;
  truth_.body.cells[599] = 1;
  truth_.rig = small_rig();
  truth_.rig->cameras["front"].clock_offset_s = 0.1 / 3;
  truth_.rig->cameras["front"].T_body_camera = mounted_camera({0.1, 1.0 / 3, 0.7}, 0.3, 0.1);
  truth_.wheels = {0.0975 / 3, 0.0976, 1.0 / 3};
}

Observation ScriptedRobot::observe(Time /*deadline*/) {
  if (left_-- == 0) {
    throw DeviceError("the robot does not answer");
  }
  const int i = count_++;
  Rng rng = Rng(11).fork("observation").fork(std::to_string(i));
  Observation seen;
  seen.stamp = Time(Duration(100'000'000LL * i));
  now_ = seen.stamp + Duration(i % 2);
  seen.odometry.T_odom_body = {rng.normal(), i == 1 ? -0.0 : rng.normal() / 3, rng.normal()};
  seen.odometry.twist_body = {rng.normal(), rng.normal()};
  seen.health.bumper_pressed = i % 4 == 3;
  truth_.path_m += std::abs(rng.normal()) / 7;
  if (i % 5 == 4) {
    return seen;  // the deadline
  }
  for (const char* name : {"floor", "front"}) {
    if (i != 2 || name != std::string("front")) {
      seen.pictures[name] = {seen.stamp, noise(rng.fork(name))};
    }
  }
  TruePose pose;
  pose.stamp = seen.stamp;
  pose.T_scene_body = {rng.normal(), rng.normal(), rng.normal()};
  pose.twist_body = {rng.normal(), rng.normal()};
  pose.clearance_m = i == 0 ? std::numeric_limits<double>::infinity() : std::abs(rng.normal());
  pose.pitch_rad = rng.normal() / 50;
  pose.roll_rad = rng.normal() / 50;
  pose.heave_m = rng.normal() / 100;
  truth_.poses.push_back(pose);
  if (i % 4 == 3) {
    truth_.contacts.push_back({seen.stamp - Duration(7), {rng.normal(), 1}, "desk-01", i > 4});
  }
  truth_.seen.cells[static_cast<std::size_t>(rng.index(24))] = 1;
  truth_.seen.cells[static_cast<std::size_t>(rng.index(24))] = 1;
  return seen;
}

Twist2 made_up_command(int i) { return {i / 3.0, -i / 7.0}; }

std::vector<Observation> drive_on(Robot& robot, int count, int from) {
  std::vector<Observation> seen;
  for (int i = from; i < from + count; ++i) {
    seen.push_back(robot.observe(robot.now() + std::chrono::seconds(1)));
    robot.drive(made_up_command(i), std::chrono::milliseconds(400));
  }
  return seen;
}

void expect_same(const Observation& a, const Observation& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  expect_same(a.odometry.T_odom_body, b.odometry.T_odom_body);
  expect_same(a.odometry.twist_body, b.odometry.twist_body);
  EXPECT_EQ(a.health.bumper_pressed, b.health.bumper_pressed);
  EXPECT_EQ(a.health.motors_enabled, b.health.motors_enabled);
  ASSERT_EQ(a.pictures.size(), b.pictures.size());
  for (const auto& [name, picture] : a.pictures) {
    ASSERT_TRUE(b.pictures.contains(name)) << name;
    const Picture& other = b.pictures.at(name);
    EXPECT_EQ(picture.stamp, other.stamp);
    ASSERT_EQ(picture.bgr.size(), other.bgr.size());
    ASSERT_EQ(picture.bgr.type(), other.bgr.type());
    EXPECT_EQ(std::memcmp(picture.bgr.data, other.bgr.data, picture.bgr.total() * 3), 0);
  }
}

void expect_same(const Truth& a, const Truth& b) {
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(a.poses[i].stamp, b.poses[i].stamp);
    expect_same(a.poses[i].T_scene_body, b.poses[i].T_scene_body);
    expect_same(a.poses[i].twist_body, b.poses[i].twist_body);
    expect_same(a.poses[i].clearance_m, b.poses[i].clearance_m);
    expect_same(a.poses[i].pitch_rad, b.poses[i].pitch_rad);
    expect_same(a.poses[i].roll_rad, b.poses[i].roll_rad);
    expect_same(a.poses[i].heave_m, b.poses[i].heave_m);
  }
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    EXPECT_EQ(a.contacts[i].stamp, b.contacts[i].stamp);
    EXPECT_EQ(a.contacts[i].p_scene, b.contacts[i].p_scene);
    EXPECT_EQ(a.contacts[i].object, b.contacts[i].object);
    EXPECT_EQ(a.contacts[i].while_moving, b.contacts[i].while_moving);
  }
  expect_same(a.floor, b.floor);
  expect_same(a.body, b.body);
  expect_same(a.seen, b.seen);
  expect_same(a.path_m, b.path_m);
  EXPECT_EQ(write_settings(TruePlatform{a.rig, a.wheels}),
            write_settings(TruePlatform{b.rig, b.wheels}));
}

}  // namespace panoptes::hw
