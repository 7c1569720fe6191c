// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/upright_points.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

const Surface kCarpet{Vec3(120, 110, 90), 0.25, 1};
const SceneBox kPrinter{Vec2(1.6, -0.35), Vec2(2.2, 0.4), 0.5, kCarpet};  // of the floor's colour
const SceneBox kFarWall{Vec2(8, -30), Vec2(8.2, 30), 2.5, {Vec3(180, 190, 200), 0.5, 2}};

FloorScene scene_of(std::vector<SceneBox> boxes) {
  FloorScene scene;
  scene.carpet = kCarpet;
  scene.boxes = std::move(boxes);
  scene.boxes.push_back(kFarWall);
  return scene;
}

struct Step {
  double ahead_m = 0;
  double turned_rad = 0;
};

/// A robot that drives through a scene; its wheels err by `wheel_noise` times what is usual.
struct Drive {
  explicit Drive(FloorScene world, double wheel_noise = 0, int seed = 1)
      : scene(std::move(world)), noise(wheel_noise), rng(seed) {}

  std::vector<UprightPoint> step(const Step& by) {
    const Pose2 moved{by.ahead_m, 0, by.turned_rad};
    T_scene_body = T_scene_body * moved;
    T_odom_body = T_odom_body * Pose2{by.ahead_m + noise * rng.normal(0, 0.001),
                                      noise * rng.normal(0, 0.0005),
                                      by.turned_rad + noise * rng.normal(0, deg_to_rad(0.05))};
    std::vector<UprightPoint> found =
        points.add(draw(scene, camera, T_scene_body, rng), T_odom_body);
    all.insert(all.end(), found.begin(), found.end());
    return found;
  }
  void go(int steps, const Step& by) {
    for (int i = 0; i < steps; ++i) {
      step(by);
    }
  }

  FloorScene scene;
  double noise;
  Rng rng;
  RigCamera camera = office_floor_camera();
  UprightPoints points{std::make_shared<FloorProjection>(project_floor(camera, Body{}))};
  Pose2 T_scene_body;
  Pose2 T_odom_body;
  std::vector<UprightPoint> all;
};

double from_box_m(const SceneBox& box, const Vec2& p) {
  const Vec2 outside = (box.low - p).cwiseMax(p - box.high).cwiseMax(0);
  const Vec2 inside = (p - box.low).cwiseMin(box.high - p).cwiseMax(0);
  return outside.norm() > 0 ? outside.norm() : std::min(inside.x(), inside.y());
}

class EveryWheel : public testing::TestWithParam<double> {};

TEST_P(EveryWheel, AThingOfTheFloorsColourIsFoundWhereItStands) {
  Drive drive(scene_of({kPrinter}), GetParam());
  drive.step({});
  drive.go(24, {0.04, 0});  // what is alone takes eight pictures
  ASSERT_GE(drive.all.size(), 6U);
  int near = 0;
  for (const UprightPoint& point : drive.all) {
    near += from_box_m(kPrinter, point.p_odom) < 3 * point.sigma_m ? 1 : 0;
    EXPECT_LT(from_box_m(kPrinter, point.p_odom), 0.15);
    EXPECT_GT(point.height_m, 0.03);
    EXPECT_LT(point.height_m, kPrinter.height_m + 0.15);
  }
  EXPECT_GE(near, static_cast<int>(0.9 * static_cast<double>(drive.all.size())));
}

TEST_P(EveryWheel, AFloorStandsNowhere) {
  Drive drive(scene_of({}), GetParam());
  drive.scene.second_carpet = {Vec3(60, 70, 160), 0.3, 4};  // with a border straight ahead,
  drive.scene.seam_x_m = 1.5;
  drive.step({});
  drive.go(15, {0.05, deg_to_rad(1)});  // driven at,
  drive.go(15, {0.03, deg_to_rad(6)});  // along,
  drive.go(15, {0.05, deg_to_rad(-3)});
  EXPECT_TRUE(drive.all.empty()) << drive.all.size();
}

INSTANTIATE_TEST_SUITE_P(Noise, EveryWheel, testing::Values(0.0, 1.0));

TEST(UprightPoints, NothingIsToldOnTheSpot) {
  Drive drive(scene_of({kPrinter}));
  drive.step({});
  drive.go(30, {0, deg_to_rad(5)});
  EXPECT_TRUE(drive.all.empty());
}

TEST(UprightPoints, WhatSlidesWithTheRobotIsNoThing) {
  Drive drive(scene_of({kPrinter}));
  for (int i = 0; i < 20; ++i) {  // wheels that turn on the spot against something
    drive.T_odom_body = drive.T_odom_body * Pose2{0.04, 0, 0};
    drive.step({});
  }
  EXPECT_TRUE(drive.all.empty());
}

TEST(UprightPoints, AreRememberedWhileTheCameraLooksOverThemAndForgottenAfterALongWay) {
  Drive drive(scene_of({kPrinter}));
  drive.step({});
  drive.go(20, {0.04, 0});
  const std::size_t found = drive.points.points().size();
  ASSERT_GT(found, 0U);
  drive.scene.boxes = {kFarWall};
  drive.go(5, {0, deg_to_rad(20)});  // away from it
  EXPECT_EQ(drive.points.points().size(), found);
  drive.go(30, {0.15, deg_to_rad(3)});
  EXPECT_TRUE(drive.points.points().empty());
}

TEST(UprightPoints, AreForgottenByARobotThatStandsAndWaits) {
  constexpr int kRate_hz = 15;
  Drive drive(scene_of({kPrinter}));
  drive.step({});
  drive.go(20, {0.04, 0});
  const std::size_t found = drive.points.points().size();
  ASSERT_GT(found, 0U);
  drive.go(10 * kRate_hz, {});
  EXPECT_EQ(drive.points.points().size(), found);
  drive.go(11 * kRate_hz, {});
  EXPECT_TRUE(drive.points.points().empty());
}

TEST(UprightPoints, WhatOtherWaysOfLookingSuggestStandsWhereFourPicturesAgree) {
  Drive drive(scene_of({}));
  const UprightPoint thing{Vec2(1, 0.2), 0.2, 0.03};
  for (int picture = 0; picture < 4; ++picture) {
    EXPECT_TRUE(drive.step({0.05, 0}).empty()) << picture;
    UprightPoint seen = thing;
    seen.p_odom.x() += 0.01 * (picture - 1.5);
    seen.height_m += 0.05 * picture;
    const UprightPoint elsewhere{Vec2(1 + 0.3 * picture, -0.5), 0.2, 0.03};  // each says otherwise
    const UprightPoint vague{Vec2(1, 0.6), 0.2, 0.1};
    drive.points.suggest({seen, seen, elsewhere, vague});
  }
  const std::vector<UprightPoint> found = drive.step({0.05, 0});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR((found[0].p_odom - thing.p_odom).norm(), 0, 0.01);
  EXPECT_NEAR(found[0].height_m, thing.height_m + 0.15, 1e-9) << "it reaches as high as was seen";
}

TEST(UprightPoints, TheSamePicturesMakeTheSameBits) {
  std::vector<std::vector<UprightPoint>> twice;
  for (int run = 0; run < 2; ++run) {
    Drive drive(scene_of({kPrinter}), 1);
    drive.step({});
    drive.go(15, {0.05, 0.01});
    twice.push_back(drive.all);
  }
  ASSERT_EQ(twice[0].size(), twice[1].size());
  for (std::size_t i = 0; i < twice[0].size(); ++i) {
    EXPECT_EQ(twice[0][i].p_odom, twice[1][i].p_odom);
    EXPECT_EQ(twice[0][i].sigma_m, twice[1][i].sigma_m);
  }
}

}  // namespace
}  // namespace panoptes
