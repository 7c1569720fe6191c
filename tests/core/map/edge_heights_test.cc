// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/edge_heights.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/geometry/pose3.h"
#include "tests/support/floor_scene.h"

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

/// A camera beneath the floor camera, 0.3 m lower, level.
RigCamera lower_camera() {
  RigCamera camera = office_floor_camera();
  camera.floor.reset();
  camera.T_body_camera = mounted_camera(camera.T_body_camera.translation - Vec3(0, 0, 0.3), 0, 0);
  camera.sigma.rotation_rad.setConstant(deg_to_rad(0.4));
  camera.sigma.position_m.setConstant(0.004);
  return camera;
}

struct Drive {
  explicit Drive(Look world, double noise = 0)
      : look(std::move(world)), wheels(noise), heights(projection) {}

  /// With the lower camera, which is tilted by this, and higher by the share, than it is said to
  /// be.
  static Drive with_second(Look world, double noise, double tilt_rad, double higher) {
    Drive drive(std::move(world), noise);
    drive.second = second_view(*drive.projection, lower_camera());
    drive.error = {higher, tilt_rad, 0};
    drive.heights = EdgeHeights(drive.projection, drive.second);
    return drive;
  }

  void step(const Pose2& by) {
    T_scene_body = T_scene_body * by;
    T_odom_body =
        T_odom_body * Pose2{by.x_m + wheels * rng.normal(0, 0.001), wheels * rng.normal(0, 0.0005),
                            by.theta_rad + wheels * rng.normal(0, deg_to_rad(0.05))};
    std::optional<EdgeHeights::Second> below;
    if (second) {
      below = {scan(second->foot_view, second->height_m * (1 + error.x()), second->depth_m,
                    [&](double range_m, double angle) {
                      return second->range_error(range_m, angle).dot(error);
                    }),
               T_odom_body};
    }
    const EdgeHeights::Found found =
        heights.add(scan(projection->foot_view, projection->height_m, projection->depth_m,
                         [](double, double) { return 0.0; }),
                    T_odom_body, below);
    upright.insert(upright.end(), found.upright.begin(), found.upright.end());
    marks.insert(marks.end(), found.marks_odom.begin(), found.marks_odom.end());
  }
  /// `error_m`: by which the floor is farther than the sample's range, by that and its direction.
  std::vector<std::int8_t> scan(const Vec2& foot_view, double height_m,
                                const std::vector<float>& depth_m,
                                const std::function<double(double, double)>& error_m) {
    const FloorProjection& p = *projection;
    const Pose2 T_scene_view = T_scene_body * p.T_body_view;
    const Vec2 foot = T_scene_view * foot_view;
    std::vector<std::int8_t> out(p.pixel.size());
    for (int row = 0; row < p.rows; ++row) {
      for (int ray = 0; ray < p.rays; ++ray) {
        const auto i = static_cast<std::size_t>(row * p.rays + ray);
        const double angle = p.first_ray_rad + ray * p.ray_step_rad;
        // a pixel that rocks with the body
        const double range_m = static_cast<double>(p.range_m[i]) +
                               wheels * 0.3 * static_cast<double>(depth_m[i]) * rng.normal(0, 1);
        const Vec2 to = T_scene_view * Vec2(foot_view + (range_m + error_m(range_m, angle)) *
                                                            Vec2(std::cos(angle), std::sin(angle)));
        out[i] = look(foot, to, height_m);
      }
    }
    return out;
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
  std::optional<SecondView> second;
  Vec3 error = Vec3::Zero();
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

/// Bars on the floor across the way, and a band of this height along it, to the left.
std::int8_t band(const Vec2& from, const Vec2& to, double h, double height_m) {
  const double beside = 0.45;
  const double beyond = 0.55;
  if (to.y() < 0.3) {
    return std::fmod(to.x() + 100, 0.7) < 0.08 ? kOther : kFloor;
  }
  const double side = height_at_x({from.y(), 0}, {to.y(), 0}, h, beside);
  const double back = height_at_x({from.y(), 0}, {to.y(), 0}, h, beyond);
  return to.y() > beside && side >= 0 && back <= height_m ? kOther : kFloor;
}

class EdgesAlongTheMotion : public testing::TestWithParam<double> {};

TEST_P(EdgesAlongTheMotion, APaintedBandIsAMarkToTwoCameras) {
  Drive drive = Drive::with_second(
      [](const Vec2& from, const Vec2& to, double h) { return band(from, to, h, 0); }, GetParam(),
      deg_to_rad(0.3), 0.004);
  drive.go(110, {0.025, 0, 0});
  EXPECT_LE(100 * drive.upright.size(), drive.marks.size());
  const auto beside = std::count_if(drive.marks.begin(), drive.marks.end(),
                                    [](const Vec2& mark) { return mark.y() > 0.4; });
  EXPECT_GE(beside, 100);
  for (const Vec2& mark : drive.marks) {
    if (mark.y() > 0.4) {
      EXPECT_NEAR(mark.y(), 0.55, 0.06);
    }
  }
}

TEST_P(EdgesAlongTheMotion, ABeamIsNoMarkToTwoCameras) {
  Drive drive = Drive::with_second(
      [](const Vec2& from, const Vec2& to, double h) { return band(from, to, h, 0.12); },
      GetParam(), deg_to_rad(0.3), 0.004);
  drive.go(110, {0.025, 0, 0});
  EXPECT_GE(drive.marks.size(), 100U) << "the bars";
  EXPECT_TRUE(std::none_of(drive.marks.begin(), drive.marks.end(),
                           [](const Vec2& mark) { return mark.y() > 0.35; }));
}

INSTANTIATE_TEST_SUITE_P(Noise, EdgesAlongTheMotion, testing::Values(0.0, 1.0));

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
