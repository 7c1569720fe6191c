// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/edge_heights.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "tests/core/map/floor_scene.h"

namespace panoptes {
namespace {

constexpr std::int8_t kFloor = 12;
constexpr std::int8_t kOther = -12;

/// What a line of sight shows: it begins `from_scene`, at the camera's height h, and meets the
/// floor at `to_scene`.
using Look = std::function<std::int8_t(const Vec2& from_scene, const Vec2& to_scene, double h)>;

/// Height over the floor at which the line of sight crosses the plane x = `x_m`; negative behind
/// the floor's end of it.
double height_at_x(const Vec2& from, const Vec2& to, double h, double x_m) {
  return to.x() <= from.x() ? -1 : h * (1 - (x_m - from.x()) / (to.x() - from.x()));
}

/// A plain wall 2 m ahead, with a skirting board of the floor's colour.
constexpr double kWall_m = 2;
constexpr double kBoard_m = 0.07;
std::int8_t skirting(const Vec2& from, const Vec2& to, double h) {
  return height_at_x(from, to, h, kWall_m) > kBoard_m ? kOther : kFloor;
}

/// A bar across the way, of another colour and this height.
constexpr double kBar_m = 1.5;
constexpr double kBarEnd_m = 1.58;
std::int8_t bar(const Vec2& from, const Vec2& to, double h, double height_m) {
  const double front = height_at_x(from, to, h, kBar_m);
  const double back = height_at_x(from, to, h, kBarEnd_m);
  const bool on_it = to.x() >= kBar_m && front >= 0 && back <= height_m;
  return on_it ? kOther : kFloor;
}

struct Drive {
  explicit Drive(Look world, double noise = 0)
      : look(std::move(world)), wheels(noise), heights(projection) {}

  void step(const Pose2& by) {
    T_scene_body = T_scene_body * by;
    T_odom_body =
        T_odom_body * Pose2{by.x_m + wheels * rng.normal(0, 0.001), wheels * rng.normal(0, 0.0005),
                            by.theta_rad + wheels * rng.normal(0, deg_to_rad(0.05))};
    const FloorProjection& p = *projection;
    const Pose2 T_scene_view = T_scene_body * p.T_body_view;
    const Vec2 foot = T_scene_view * p.foot_view;
    std::vector<std::int8_t> scan(p.pixel.size());
    for (int row = 0; row < p.rows; ++row) {
      for (int ray = 0; ray < p.rays; ++ray) {
        const auto i = static_cast<std::size_t>(row * p.rays + ray);
        const double angle = p.first_ray_rad + ray * p.ray_step_rad;
        // a pixel that rocks with the body
        const double range_m = static_cast<double>(p.range_m[i]) +
                               wheels * 0.3 * static_cast<double>(p.depth_m[i]) * rng.normal(0, 1);
        const Vec2 to =
            T_scene_view * Vec2(p.foot_view + range_m * Vec2(std::cos(angle), std::sin(angle)));
        scan[i] = look(foot, to, p.height_m);
      }
    }
    const EdgeHeights::Found found = heights.add(scan, T_odom_body);
    upright.insert(upright.end(), found.upright.begin(), found.upright.end());
    marks.insert(marks.end(), found.marks_odom.begin(), found.marks_odom.end());
  }
  void go(int steps, const Pose2& by) {
    for (int i = 0; i < steps; ++i) {
      step(by);
    }
  }

  Look look;
  double wheels;
  Rng rng{3};
  std::shared_ptr<const FloorProjection> projection =
      std::make_shared<FloorProjection>(project_floor(office_floor_camera(), Body{}));
  EdgeHeights heights;
  Pose2 T_scene_body;
  Pose2 T_odom_body;
  std::vector<UprightPoint> upright;
  std::vector<Vec2> marks;
};

class EdgeHeightsOnEveryWheel : public testing::TestWithParam<double> {};

TEST_P(EdgeHeightsOnEveryWheel, AWallIsFoundBehindItsSkirtingBoard) {
  Drive drive(skirting, GetParam());
  drive.go(50, {0.025, 0, 0});
  ASSERT_GE(drive.upright.size(), 100U);
  double height_m = 0;
  for (const UprightPoint& point : drive.upright) {
    EXPECT_NEAR(point.p_odom.x(), kWall_m, 0.06 + 3 * point.sigma_m);
    height_m += point.height_m / static_cast<double>(drive.upright.size());
  }
  EXPECT_NEAR(height_m, kBoard_m, 0.015);
  EXPECT_TRUE(drive.marks.empty());
}

TEST_P(EdgeHeightsOnEveryWheel, WhatIsPaintedOnTheFloorIsAMark) {
  Drive drive([](const Vec2& from, const Vec2& to, double h) { return bar(from, to, h, 0); },
              GetParam());
  drive.go(44, {0.025, 0, 0});
  EXPECT_TRUE(drive.upright.empty()) << drive.upright.size();
  ASSERT_GE(drive.marks.size(), 50U);
  const auto near = std::count_if(drive.marks.begin(), drive.marks.end(), [](const Vec2& mark) {
    return std::abs(mark.x() - kBarEnd_m) < 0.05;
  });
  EXPECT_GE(near, static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(drive.marks.size())));
}

TEST_P(EdgeHeightsOnEveryWheel, ABarOfSixCentimetresIsNoMark) {
  Drive drive([](const Vec2& from, const Vec2& to, double h) { return bar(from, to, h, 0.06); },
              GetParam());
  drive.go(44, {0.025, 0, 0});
  EXPECT_TRUE(drive.marks.empty()) << drive.marks.size();
  ASSERT_GE(drive.upright.size(), 20U);
  for (const UprightPoint& point : drive.upright) {
    EXPECT_NEAR(point.p_odom.x(), kBarEnd_m, 0.06 + 3 * point.sigma_m);
  }
}

INSTANTIATE_TEST_SUITE_P(Noise, EdgeHeightsOnEveryWheel, testing::Values(0.0, 1.0));

TEST(EdgeHeights, NothingIsToldOnTheSpot) {
  Drive drive(skirting);
  drive.go(30, {0.025, 0, 0});
  drive.upright.clear();
  drive.go(5, {0, 0, deg_to_rad(5)});  // what is left of the last picture
  drive.upright.clear();
  drive.go(40, {0, 0, deg_to_rad(5)});
  EXPECT_TRUE(drive.upright.empty());
}

TEST(EdgeHeights, NothingIsToldOfAnEdgeAlongTheMotion) {
  // a wall to the left, with its board
  Drive drive([](const Vec2& from, const Vec2& to, double h) {
    return height_at_x({from.y(), 0}, {to.y(), 0}, h, 0.6) > kBoard_m ? kOther : kFloor;
  });
  drive.go(60, {0.025, 0, 0});
  EXPECT_TRUE(drive.upright.empty()) << drive.upright.size();
  EXPECT_TRUE(drive.marks.empty());
}

TEST(EdgeHeights, AJumpOfTheWheelsStartsAnew) {
  Drive drive(skirting);
  drive.go(30, {0.025, 0, 0});
  drive.T_odom_body = Pose2{50, -20, 1};
  drive.upright.clear();
  drive.go(4, {0.025, 0, 0});
  EXPECT_TRUE(drive.upright.empty()) << "too few pictures since";
}

}  // namespace
}  // namespace panoptes
