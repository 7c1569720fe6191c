// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/occupancy.h"

#include <vector>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(OccupancyMap, IsUnknownOutside) {
  OccupancyMap map{0.1, Vec2(-1, 2), 2, 1, {Cell::kFree, Cell::kOccupied}};
  EXPECT_EQ(map.at(0, 0), Cell::kFree);
  EXPECT_EQ(map.at(1, 0), Cell::kOccupied);
  EXPECT_EQ(map.at(2, 0), Cell::kUnknown);
  EXPECT_EQ(map.at(0, -1), Cell::kUnknown);
  EXPECT_EQ(map.at(Vec2(-0.95, 2.05)), Cell::kFree);
  EXPECT_EQ(map.at(Vec2(-0.85, 2.05)), Cell::kOccupied);
  EXPECT_EQ(map.at(Vec2(-1.01, 2.05)), Cell::kUnknown);
  EXPECT_EQ(map.at(Vec2(1e30, 0)), Cell::kUnknown);
}

TEST(OccupancyMap, CountsFreeFloor) {
  OccupancyMap map{
      0.1, Vec2::Zero(), 2, 2, {Cell::kFree, Cell::kOccupied, Cell::kFree, Cell::kUnknown}};
  EXPECT_NEAR(map.area_m2(Cell::kFree), 0.02, 1e-12);
  EXPECT_EQ(map.at(map.centre(0, 1)), Cell::kFree);
}

TEST(Resampled, IsOccupiedWhereAnyPartIsAndFreeWhereHalfAre) {
  const auto of = [](const std::vector<Cell>& parts) {
    return resampled(2, [&](int column, int row) { return parts[2 * row + column]; });
  };
  constexpr Cell kU = Cell::kUnknown;
  constexpr Cell kF = Cell::kFree;
  constexpr Cell kO = Cell::kOccupied;
  EXPECT_EQ(of({kU, kU, kU, kU}), kU);
  EXPECT_EQ(of({kU, kF, kU, kU}), kU);
  EXPECT_EQ(of({kU, kF, kF, kU}), kF);
  EXPECT_EQ(of({kF, kF, kF, kO}), kO);
  EXPECT_EQ(resampled(1, [](int, int) { return kF; }), kF);
  EXPECT_EQ(parts_a_side(0.05, 0.01), 5);
  EXPECT_EQ(parts_a_side(0.02, 0.05), 1);
}

}  // namespace
}  // namespace panoptes
