// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/contours.h"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

// Points a centimetre apart along a polyline.
std::vector<Vec2> along(const std::vector<Vec2>& corners) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Vec2 d = corners[i + 1] - corners[i];
    for (double s = 0; s < d.norm(); s += 0.01) {
      points.push_back(corners[i] + d.normalized() * s);
    }
  }
  return points;
}

std::vector<Vec2> office() {
  std::vector<Vec2> points = along({{0.5, -1.2}, {2.1, -1.2}, {2.1, -0.4}, {3, -0.4}});
  for (const Vec2& p : along({{0.4, 1}, {1.3, 1}, {1.3, 1.4}, {2.6, 1.4}})) {
    points.push_back(p);
  }
  return points;
}

std::vector<Vec2> moved(const std::vector<Vec2>& points, const Pose2& T, double sigma_m, Rng& rng) {
  std::vector<Vec2> out;
  for (const Vec2& p : points) {
    out.push_back(T * p + Vec2(rng.normal(0, sigma_m), rng.normal(0, sigma_m)));
  }
  return out;
}

TEST(AlignContours, RecoversAKnownDisplacement) {
  Rng rng(1);
  const std::vector<Vec2> fixed = office();
  for (int i = 0; i < 20; ++i) {
    const Pose2 T_fixed_moving{rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4),
                               rng.uniform(-0.15, 0.15)};
    const std::vector<Vec2> moving = moved(fixed, T_fixed_moving.inverse(), 0, rng);
    // the prior is off by the displacement; the turn is about the contour's middle, 1.5 m ahead
    const auto match = align_contours({}, fixed, moving, {});
    ASSERT_TRUE(match);
    const Pose2 off = T_fixed_moving.inverse() * match->T_fixed_moving;
    EXPECT_LT(off.position().norm(), 0.015);  // the field's cell, and its half at 1.5 m
    EXPECT_LT(std::abs(off.theta_rad), 0.007);
    EXPECT_LT(match->mean_distance_m, 0.01);
    EXPECT_GT(match->overlap, 0.99);
    EXPECT_LT(match->ambiguity(), 0.5);
  }
}

TEST(AlignContours, NoisyAndPartlySeenStaysWithinItsCovariance) {
  Rng rng(2);
  const std::vector<Vec2> fixed = office();
  double worst = 0;
  for (int i = 0; i < 20; ++i) {
    const Pose2 T{rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(-0.05, 0.05)};
    std::vector<Vec2> moving = moved(fixed, T.inverse(), 0.015, rng);
    moving.erase(moving.begin() + 40, moving.begin() + 140);
    const auto match = align_contours({}, fixed, moving, {});
    ASSERT_TRUE(match);
    const Vec3 e(match->T_fixed_moving.x_m - T.x_m, match->T_fixed_moving.y_m - T.y_m,
                 match->T_fixed_moving.theta_rad - T.theta_rad);
    worst = std::max(worst, e.dot(match->information * e));
  }
  EXPECT_LT(worst, 16.3);  // chi-square of three degrees, one in a thousand
}

TEST(AlignContours, AnAisleLeavesTheWayAlongItOpen) {
  Rng rng(3);
  std::vector<Vec2> fixed = along({{-2, 0.5}, {4, 0.5}});
  for (const Vec2& p : along({{-2, -0.5}, {4, -0.5}})) {
    fixed.push_back(p);
  }
  std::vector<Vec2> moving = along({{0, 0.5}, {2.5, 0.5}});
  for (const Vec2& p : along({{0, -0.5}, {2.5, -0.5}})) {
    moving.push_back(p);
  }
  const auto match = align_contours({}, fixed, moving, {0.05, 0.1, 0.03});
  ASSERT_TRUE(match);
  EXPECT_NEAR(match->T_fixed_moving.y_m, 0, 0.015);
  EXPECT_NEAR(match->T_fixed_moving.theta_rad, 0, 0.01);
  EXPECT_GT(std::sqrt(match->covariance(0, 0)), 0.2);
  EXPECT_LT(std::sqrt(match->covariance(1, 1)), 0.03);
}

TEST(AlignContours, TwoEqualPlacesAreAmbiguous) {
  // table legs 0.3 m apart: a shift by one leg fits nearly as well
  std::vector<Vec2> fixed;
  for (int leg = 0; leg < 8; ++leg) {
    const double y = 0.3 * leg;
    for (const Vec2& p : along({{1, y}, {1.1, y}, {1.1, y + 0.1}, {1, y + 0.1}, {1, y}})) {
      fixed.push_back(p);
    }
  }
  const auto match = align_contours({}, fixed, fixed, {0, 0.1, 0});
  ASSERT_TRUE(match);
  const auto clear = align_contours({}, office(), office(), {0, 0.1, 0});
  ASSERT_TRUE(clear);
  EXPECT_LT(match->second_distance_m, clear->second_distance_m);
  EXPECT_LT(match->second_distance_m, 0.06);
}

TEST(AlignContours, RefusesTooFewPoints) {
  EXPECT_FALSE(align_contours({}, office(), {Vec2(0, 0), Vec2(1, 0)}, {}));
  EXPECT_FALSE(align_contours({}, {}, office(), {}));
}

TEST(ObstacleContour, LiesBetweenFreeAndOccupiedAlone) {
  OccupancyMap map;
  map.cell_m = 0.02;
  map.columns = 100;
  map.rows = 100;
  map.cells.assign(10000, Cell::kUnknown);
  const auto set = [&](int c0, int r0, int c1, int r1, Cell cell) {
    for (int r = r0; r < r1; ++r) {
      for (int c = c0; c < c1; ++c) {
        map.cells[static_cast<std::size_t>(r * 100 + c)] = cell;
      }
    }
  };
  set(10, 10, 80, 80, Cell::kFree);
  set(80, 20, 82, 60, Cell::kOccupied);  // a wall; the rest of the outline is unknown
  set(30, 30, 31, 31, Cell::kOccupied);  // a speck
  set(90, 90, 92, 92, Cell::kFree);      // a scrap of floor with a wall of its own
  set(92, 90, 93, 92, Cell::kOccupied);
  const std::vector<Vec2> contour = obstacle_contour(map);
  EXPECT_EQ(contour.size(), 40U);
  for (const Vec2& p : contour) {
    EXPECT_NEAR(p.x(), 80 * 0.02, 1e-9);
  }
  EXPECT_TRUE(obstacle_contour({}).empty());
}

}  // namespace
}  // namespace panoptes
