// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/occupancy.h"

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

}  // namespace
}  // namespace panoptes
