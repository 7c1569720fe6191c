// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/obstacles.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "tests/sim/physics/rooms.h"

namespace panoptes::sim {
namespace {

constexpr double kRoundoff_m = 1e-12;

TEST(NearestOn, KnowsInsideSidesAndCorners) {
  const Outline desk = box("desk", 1, 1, 3, 2);
  EXPECT_EQ(nearest_on(desk, {2, 1.5}).distance_m, 0);
  EXPECT_NEAR(nearest_on(desk, {2, 0.6}).distance_m, 0.4, kRoundoff_m);
  EXPECT_NEAR(nearest_on(desk, {3.3, 2.4}).distance_m, 0.5, kRoundoff_m);
  const Outline sheet{"screen", {{0, 0}, {1, 0}}};
  EXPECT_NEAR(nearest_on(sheet, {0.5, -0.2}).distance_m, 0.2, kRoundoff_m);
}

TEST(Obstacles, FindsWhatAnExhaustiveSearchFinds) {
  Rng rng(7);
  std::vector<Outline> things = walls(10);
  for (int i = 0; i < 60; ++i) {
    const double x = rng.uniform(0, 9);
    const double y = rng.uniform(0, 9);
    things.push_back({"thing", {{x, y}, {x + rng.uniform(), y}, {x, y + rng.uniform()}}});
  }
  const Obstacles obstacles(things);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 p(rng.uniform(-3, 13), rng.uniform(-3, 13));
    double expected_m = std::numeric_limits<double>::infinity();
    for (const Outline& thing : things) {
      expected_m = std::min(expected_m, nearest_on(thing, p).distance_m);
    }
    ASSERT_TRUE(obstacles.nearest(p));
    EXPECT_EQ(obstacles.nearest(p)->distance_m, expected_m);
    EXPECT_EQ(obstacles.nearest(p, 0.3).has_value(), expected_m <= 0.3);
  }
}

TEST(FreeRegion, IsTheLargestConnectedOne) {
  std::vector<Outline> things = walls(6);
  things.push_back(box("partition", 4, 0, 4.1, 6));
  const FreeRegion region(Obstacles(things), 0.25);
  EXPECT_TRUE(region.contains({2, 3}));
  EXPECT_FALSE(region.contains({5, 3}));    // the smaller room
  EXPECT_FALSE(region.contains({0.1, 3}));  // too near to the wall
  EXPECT_FALSE(region.contains({-2, 3}));
  const double fringe_m2 = 2 * (3.5 + 5.5) * 0.05;  // a cell along the border
  EXPECT_NEAR(region.area_m2(), 3.5 * 5.5, fringe_m2);
}

TEST(FreeRegion, IsEmptyWhereNothingFits) {
  const FreeRegion region(Obstacles(walls(0.4)), 0.25);
  EXPECT_EQ(region.area_m2(), 0);
  EXPECT_FALSE(region.contains({0.2, 0.2}));
}

}  // namespace
}  // namespace panoptes::sim
