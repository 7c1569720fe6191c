// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/reached_floor.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

constexpr double kSquare_m = 0.1;
constexpr double kPassage_m = 0.2;

// A room on the left, whose wall has a crack of `crack` squares; free floor is seen behind it.
OccupancyMap room_with_crack(int crack, double cell_m) {
  std::vector<std::string> lines(12, "..........#..........");
  for (int i = 0; i < crack; ++i) {
    lines[static_cast<std::size_t>(5 + i)][10] = '.';
  }
  return test::floor_plan(lines, kSquare_m, cell_m);
}

const std::vector<Vec2> kWay{{0.45, 0.5}, {0.45, 0.8}};

TEST(ReachedFloor, NothingIsFreeBehindACrack) {
  for (const double cell_m : {0.01, 0.05}) {
    const OccupancyMap map = reached_floor(room_with_crack(1, cell_m), kWay, kPassage_m);
    EXPECT_EQ(map.at({0.45, 0.65}), Cell::kFree);
    EXPECT_EQ(map.at({0.96, 0.65}), Cell::kFree);  // its margins are kept
    EXPECT_EQ(map.at({0.03, 0.03}), Cell::kFree);
    EXPECT_EQ(map.at({1.5, 0.65}), Cell::kUnknown);
    EXPECT_EQ(map.at({1.35, 0.35}), Cell::kUnknown);
    EXPECT_EQ(map.at({1.05, 1.05}), Cell::kOccupied);
  }
}

TEST(ReachedFloor, WhatAPassageLeadsToIsFree) {
  for (const double cell_m : {0.01, 0.05}) {
    const OccupancyMap before = room_with_crack(3, cell_m);
    EXPECT_EQ(reached_floor(before, kWay, kPassage_m).cells, before.cells);
  }
}

TEST(ReachedFloor, PatchesFarFromTheWayAreNotFree) {
  const OccupancyMap map =
      reached_floor(test::floor_plan({".......???.", ".......????", ".......??..", ".......??.."},
                                     kSquare_m, 0.02),
                    std::vector<Vec2>{{0.3, 0.2}}, kPassage_m);
  EXPECT_EQ(map.at({0.65, 0.35}), Cell::kFree);
  EXPECT_EQ(map.at({1.05, 0.35}), Cell::kUnknown);
  EXPECT_EQ(map.at({1.0, 0.1}), Cell::kUnknown);
}

TEST(ReachedFloor, WithoutAWayTheMapIsLeftAsItIs) {
  const OccupancyMap before = room_with_crack(1, 0.02);
  EXPECT_EQ(reached_floor(before, {}, kPassage_m).cells, before.cells);
  EXPECT_EQ(reached_floor(before, std::vector<Vec2>{{9, 9}}, kPassage_m).cells, before.cells);
  EXPECT_TRUE(reached_floor({}, kWay, kPassage_m).cells.empty());
}

}  // namespace
}  // namespace panoptes
