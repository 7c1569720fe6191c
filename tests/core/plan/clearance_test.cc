// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/clearance.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_m = 1e-5;  // distances are floats of some metres

TEST(Clearance, DistancesAreThoseOfTryingEveryCell) {
  Rng rng(1);
  constexpr int kColumns = 37;
  constexpr int kRows = 23;
  constexpr double kCell_m = 0.05;
  // By what is near alone, and by what is far as well.
  for (const double cap_m : {0.13, 0.9, 1.7}) {
    for (const double share : {0.0, 0.003, 0.05, 0.5}) {
      std::vector<std::uint8_t> blocks(kColumns * kRows);
      std::generate(blocks.begin(), blocks.end(),
                    [&] { return rng.uniform() < share ? std::uint8_t{1} : std::uint8_t{0}; });
      const std::vector<float> found = distance_m(blocks, kColumns, kRows, kCell_m, cap_m);
      for (int i = 0; i < kColumns * kRows; ++i) {
        double nearest = cap_m;
        for (int j = 0; j < kColumns * kRows; ++j) {
          if (blocks[j] != 0) {
            nearest = std::min(nearest, kCell_m * std::hypot(i % kColumns - j % kColumns,
                                                             i / kColumns - j / kColumns));
          }
        }
        ASSERT_NEAR(found[i], nearest, kRoundoff_m);
      }
    }
  }
}

TEST(Clearance, OutsideTheMapIsUnknown) {
  const ClearanceMap map =
      clearance_map(test::floor_plan({".....", ".....", "....."}, 0.1, 0.1), 1);
  EXPECT_NEAR(map.to_unknown_m[map.index(0, 1)], 0.1, kRoundoff_m);
  EXPECT_NEAR(map.to_unknown_m[map.index(2, 1)], 0.2, kRoundoff_m);
  EXPECT_NEAR(map.to_occupied_m[map.index(2, 1)], 1.0, kRoundoff_m);
}

TEST(Clearance, CoarseCellsNeverLoseAnObstacle) {
  Rng rng(2);
  OccupancyMap map = test::empty_room(3, 2, 0.01);
  for (int i = 0; i < 40; ++i) {
    map.cells[static_cast<std::size_t>(rng.index(static_cast<int>(map.cells.size())))] =
        Cell::kOccupied;
  }
  const OccupancyMap coarse = coarsen(map, 0.05, 0.2);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Vec2 p = map.centre(column, row);
      if (map.at(p) == Cell::kOccupied) {
        EXPECT_EQ(coarse.at(p), Cell::kOccupied);
      }
    }
  }
}

TEST(Clearance, OnlyTheKnownPartIsKeptInsideItsBorder) {
  OccupancyMap map;
  map.cell_m = 0.01;
  map.origin = {-5, -5};
  map.columns = map.rows = 1000;
  map.cells.assign(1000000, Cell::kUnknown);
  EXPECT_TRUE(coarsen(map, 0.05, 1.0).cells.empty());
  test::fill(map, 0.5, 1.0, 1.5, 1.2, Cell::kFree);
  const OccupancyMap coarse = coarsen(map, 0.05, 0.2);
  EXPECT_EQ(coarse.columns, 20 + 8);
  EXPECT_EQ(coarse.rows, 4 + 8);
  EXPECT_EQ(coarse.at(Vec2(0.52, 1.02)), Cell::kFree);
  EXPECT_EQ(coarse.at(Vec2(0.48, 1.02)), Cell::kUnknown);
}

}  // namespace
}  // namespace panoptes
