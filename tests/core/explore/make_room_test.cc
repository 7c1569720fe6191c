// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/make_room.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/map/occupancy.h"
#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

DrivableGrid grid_of(const OccupancyMap& map) {
  const SearchOptions search;
  return drivable_grid_of_coarse(search, Body(), coarsen(map, search.cell_m, 0));
}

TEST(MakeRoom, GoesAwayFromWhereNothingGetsOn) {
  const DrivableGrid grid = grid_of(test::empty_room(6, 3, 0.01));
  const std::vector<Vec2> blocked = {Vec2(1, 1.5)};
  const Vec2 here(1.7, 1.5);
  const std::optional<Vec2> place = place_to_make_room({}, grid, here, blocked);
  ASSERT_TRUE(place);
  EXPECT_GT((*place - blocked.front()).norm(), 3);
  EXPECT_LT((*place - here).norm(), 3.1);
}

TEST(MakeRoom, StaysWhereNothingIsBetter) {
  const DrivableGrid grid = grid_of(test::empty_room(1, 1, 0.01));
  const std::vector<Vec2> blocked = {Vec2(0.5, 0)};
  EXPECT_FALSE(place_to_make_room({}, grid, Vec2(0.5, 0.6), blocked));
  EXPECT_FALSE(place_to_make_room({}, grid, Vec2(0.5, 0.6), {}));
}

}  // namespace
}  // namespace panoptes
