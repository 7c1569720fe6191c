// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/shortest_path.h"

#include <cmath>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

/// 6 x 4 m of floor, all of which can be reached.
TruthLayer open_floor() {
  TruthLayer layer;
  layer.cell_m = 0.01;
  layer.assign(600, 400, 1);
  return layer;
}

constexpr double kMoved_m = 0.15;
constexpr double kCells_m = 0.03;  // what fast marching makes too long, over some metres

TEST(ShortestPath, IsTheStraightLineOverOpenFloorInAnyDirection) {
  const Vec2 from(1, 1);
  for (double angle = 0; angle < 1.5; angle += 0.2) {
    const Vec2 to = from + 2.5 * Vec2(std::cos(angle), std::sin(angle));
    EXPECT_NEAR(shortest_path_m(open_floor(), from, to, kMoved_m).value(), 2.5, kCells_m) << angle;
  }
}

TEST(ShortestPath, LeadsAroundTheEndOfAWall) {
  TruthLayer layer = open_floor();
  for (int row = 0; row < 300; ++row) {
    layer(300, row) = 0;
  }
  const double by_the_end_m = 2 * std::hypot(2, 2);
  EXPECT_NEAR(shortest_path_m(layer, {1, 1}, {5, 1}, kMoved_m).value(), by_the_end_m, 3 * kCells_m);
}

TEST(ShortestPath, CountsFromTheNearestFloorAndIsNotThereWithoutAWay) {
  TruthLayer layer = open_floor();
  for (int row = 0; row < 400; ++row) {
    for (int column = 300; column < 320; ++column) {
      layer(column, row) = 0;
    }
  }
  EXPECT_NEAR(shortest_path_m(layer, {1, 1}, {3.07, 1}, kMoved_m).value(), 2, kCells_m);
  EXPECT_FALSE(shortest_path_m(layer, {1, 1}, {5, 1}, kMoved_m));
  EXPECT_FALSE(shortest_path_m(layer, {1, 1}, {50, 1}, kMoved_m));
}

}  // namespace
}  // namespace panoptes
