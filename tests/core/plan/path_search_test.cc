// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/path_search.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/floor_plan.h"

namespace panoptes {
namespace {

using ::testing::HasSubstr;

/// Two rooms joined by a gap of `gap_m` about y = 2 in a wall at x = 2.
OccupancyMap two_rooms(double gap_m) {
  OccupancyMap map = test::empty_room(4, 4, 0.01);
  test::fill(map, 1.9, 0, 2.1, 2 - 0.5 * gap_m, Cell::kOccupied);
  test::fill(map, 1.9, 2 + 0.5 * gap_m, 2.1, 4, Cell::kOccupied);
  return map;
}

PathSearch find(const OccupancyMap& map, const Vec2& start, const Vec2& goal) {
  const SearchOptions options;
  return search_path(options, drivable_grid(options, Body(), map), start, goal);
}

TEST(PathSearch, PassesTheNarrowestGapOfTheOffice) {
  const PathSearch found = find(two_rooms(0.88), {1, 1}, {3, 3});
  ASSERT_TRUE(found.path) << found.reason;
  // Through the middle of the gap, give or take a cell.
  for (const Vec2& p : found.path->points) {
    if (std::abs(p.x() - 2) < 0.1) {
      EXPECT_NEAR(p.y(), 2, 0.1);
    }
  }
  EXPECT_LE((found.path->points.back() - Vec2(3, 3)).norm(), 0.036);  // half a cell's diagonal
}

TEST(PathSearch, PassesTheGapWithFourCentimetresOfSmearOnEitherSide) {
  EXPECT_TRUE(find(two_rooms(0.80), {1, 1}, {3, 3}).path);
}

TEST(PathSearch, RefusesAGapNarrowerThanTheRobot) {
  const PathSearch found = find(two_rooms(0.5), {1, 1}, {3, 3});
  EXPECT_FALSE(found.path);
  EXPECT_THAT(found.reason, HasSubstr("no way to the goal"));
}

TEST(PathSearch, GoesRoundAndKeepsItsMargin) {
  OccupancyMap map = test::empty_room(4, 4, 0.01);
  test::fill(map, 1, 1.8, 4, 2.2, Cell::kOccupied);
  const SearchOptions options;
  const Body body;
  const DrivableGrid grid = drivable_grid(options, body, map);
  const PathSearch found = search_path(options, grid, {3.5, 1.2}, {3.5, 2.8});
  ASSERT_TRUE(found.path) << found.reason;
  EXPECT_GE(found.path->min_clearance_m, 0);
  EXPECT_GT(found.path->length_m, 2 * 2.5);
  const ClearanceMap fine = clearance_map(map, 1);
  for (const Vec2& p : found.path->points) {
    // Coarse cells move an obstacle by half a cell at most.
    EXPECT_GE(fine.to_occupied_m[fine.index(fine.column(p), fine.row(p))],
              body.radius_m + options.margin_m - 0.036);
  }
}

TEST(PathSearch, NeverLeavesKnownFloorUnlessAllowed) {
  OccupancyMap map = test::empty_room(4, 2, 0.01);
  test::fill(map, 1.5, 0, 2.5, 2, Cell::kUnknown);
  EXPECT_FALSE(find(map, {0.7, 1}, {3.3, 1}).path);
  SearchOptions bold;
  bold.through_unknown = true;
  EXPECT_TRUE(search_path(bold, drivable_grid(bold, Body(), map), {0.7, 1}, {3.3, 1}).path);
}

TEST(PathSearch, AStartInsideTheMarginMayLeaveIt) {
  const OccupancyMap map = test::empty_room(4, 4, 0.01);
  const PathSearch found = find(map, {0.2, 2}, {3, 2});  // the disc would reach into the wall
  ASSERT_TRUE(found.path) << found.reason;
  EXPECT_LT(found.path->min_clearance_m, 0);
}

TEST(PathSearch, AGoalInAnObstacleIsMovedALittleOrRefused) {
  OccupancyMap map = test::empty_room(4, 4, 0.01);
  test::fill(map, 2.9, 2.9, 3.1, 3.1, Cell::kOccupied);
  EXPECT_FALSE(find(map, {1, 1}, {3, 3}).path);
  const PathSearch beside = find(map, {1, 1}, {2.7, 2.9});
  ASSERT_TRUE(beside.path) << beside.reason;
  EXPECT_LE((beside.path->points.back() - Vec2(2.7, 2.9)).norm(), SearchOptions().goal_tolerance_m);
}

TEST(PathSearch, TheFloodIsAsFarAsTheWay) {
  SearchOptions options;
  options.clearance_weight = 0;
  const DrivableGrid grid = drivable_grid(options, Body(), test::empty_room(20, 12, 0.05));
  const OccupancyMap& map = grid.clearance.map;
  const Vec2 start(4.31, 7.77);
  const CostField field = flood(options, grid, start);
  constexpr double kRounded_m = 1e-3;  // of a few hundred sums in single precision
  int reached = 0;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const double cost_m = field.cost_m[map.index(column, row)];
      ASSERT_EQ(std::isfinite(cost_m), grid.drivable(column, row)) << column << " " << row;
      if (std::isfinite(cost_m)) {
        const int dx = std::abs(column - map.column(start));
        const int dy = std::abs(row - map.row(start));
        const double way_m =
            map.cell_m * (std::max(dx, dy) + (std::sqrt(2.0) - 1) * std::min(dx, dy));
        EXPECT_NEAR(cost_m, way_m, kRounded_m);
        ++reached;
      }
    }
  }
  EXPECT_GT(reached, 80000);
}

TEST(PathSearch, AgreesWithTheFlood) {
  const OccupancyMap map = two_rooms(0.9);
  const SearchOptions options;
  const DrivableGrid grid = drivable_grid(options, Body(), map);
  const Vec2 start(0.6, 0.7);
  const CostField field = flood(options, grid, start);
  const Vec2 goal(3.33, 3.18);
  const int cell =
      static_cast<int>(grid.clearance.index(grid.clearance.column(goal), grid.clearance.row(goal)));
  const PathSearch found = search_path(options, grid, start, goal);
  ASSERT_TRUE(found.path);
  const std::vector<Vec2> path = path_to(grid, field, cell);
  // The search may break ties differently, so lengths are compared, up to a cell's diagonal.
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length += (path[i] - path[i - 1]).norm();
  }
  EXPECT_NEAR(length, found.path->length_m, 0.08);
}

/// The window of a robot at (1.2, 2) in a frame that is turned and shifted against the map's, of a
/// room that a wall divides but for a gap of this width, whose middle is at y = `middle_m`.
NearMap near_a_gap(double width_m, double middle_m, const Pose2& T_window_map) {
  NearMap near;
  near.T_window_map = T_window_map;
  near.robot_map = {1.2, 2};
  near.within_m = 2.2;
  OccupancyMap window;
  window.cell_m = 0.02;
  window.assign(300, 300);
  window.origin = T_window_map * near.robot_map - Vec2::Constant(150 * window.cell_m);
  const Pose2 T_map_window = T_window_map.inverse();
  for (int row = 0; row < window.rows; ++row) {
    for (int column = 0; column < window.columns; ++column) {
      const Vec2 p = T_map_window * window.centre(column, row);
      const bool in_wall = std::abs(p.x() - 2) < 0.05 && std::abs(p.y() - middle_m) > 0.5 * width_m;
      window(column, row) = in_wall ? Cell::kOccupied : Cell::kFree;
    }
  }
  near.window = clearance_map(std::move(window), 1);
  return near;
}

TEST(NearMap, PassesAGapTenCentimetresWiderThanTheRobotWhereverItsCellsLie) {
  const SearchOptions options;
  const Body body;
  const OccupancyMap map = test::empty_room(4, 4, options.cell_m);
  const auto crosses = [&](double width_m, double middle_m, const Pose2& T_window_map) {
    const DrivableGrid grid =
        drivable_grid_with(options, body, map, near_a_gap(width_m, middle_m, T_window_map));
    const PathSearch found = search_path(options, grid, {1.2, 2}, {3, 2});
    if (!found.path) {
      return false;
    }
    for (const Vec2& p : found.path->points) {  // in the middle of the gap, not of a cell
      if (std::abs(p.x() - 2) < 0.05) {
        EXPECT_NEAR(p.y(), middle_m, 0.02);
      }
    }
    return true;
  };
  for (const double turn_rad : {0.0, 0.4, 0.785}) {
    for (const double middle_m : {2.0, 2.013, 2.025, 2.037}) {
      const Pose2 T_window_map{0.3, -0.7, turn_rad};
      EXPECT_TRUE(crosses(2 * (body.radius_m + options.margin_m) + 0.04, middle_m, T_window_map))
          << turn_rad << " " << middle_m;
      EXPECT_FALSE(crosses(2 * body.radius_m, middle_m, T_window_map));
    }
  }
}

TEST(NearMap, CountsInItsDiscAlone) {
  const SearchOptions options;
  const OccupancyMap map = test::empty_room(4, 4, options.cell_m);
  NearMap near = near_a_gap(0, 2, {});
  near.within_m = 0.5;  // the wall is farther away
  EXPECT_TRUE(
      search_path(options, drivable_grid_with(options, Body(), map, near), {1.2, 2}, {3, 2}).path);
}

TEST(Lookahead, IsAheadOnThePathAndCutsNoCorner) {
  OccupancyMap map = test::empty_room(4, 4, 0.01);
  test::fill(map, 0, 1.5, 2.5, 2.5, Cell::kOccupied);  // an L about (2.5, 1.5)
  const SearchOptions options;
  const DrivableGrid grid = drivable_grid(options, Body(), map);
  const PathSearch found = search_path(options, grid, {0.7, 0.8}, {0.7, 3.2});
  ASSERT_TRUE(found.path) << found.reason;
  std::size_t along = 0;
  for (const Vec2& robot : found.path->points) {
    const Lookahead lookahead = lookahead_point(grid, *found.path, robot, 0.7, along);
    EXPECT_LE((lookahead.point - robot).norm(), 0.7 + 0.08);
    EXPECT_TRUE(straight_line_clear(grid, robot, lookahead.point, -0.03));
    EXPECT_EQ(lookahead.last,
              lookahead.to_go_m <= 0.71 && lookahead.point == found.path->points.back());
  }
}

}  // namespace
}  // namespace panoptes
