// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/coverage.h"

#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-12;
constexpr double kPi = std::numbers::pi;

/// A layer of a 4 x 3 m room, its lower-left corner at (1, 2), set where the function says.
TruthLayer layer(double cell_m, const std::function<bool(double, double)>& is_set) {
  TruthLayer result;
  result.cell_m = cell_m;
  result.origin = {1, 2};
  result.columns = static_cast<int>(std::lround(4 / cell_m));
  result.rows = static_cast<int>(std::lround(3 / cell_m));
  for (int row = 0; row < result.rows; ++row) {
    for (int column = 0; column < result.columns; ++column) {
      result.cells.push_back(is_set((column + 0.5) * cell_m, (row + 0.5) * cell_m) ? 1 : 0);
    }
  }
  return result;
}

/// Walls of 10 cm around the room.
bool walls(double x, double y) { return x < 0.1 || y < 0.1 || x > 3.9 || y > 2.9; }

/// The map that a robot founded at `T_scene_map` would have of the whole room if it were perfect:
/// free where nothing is set, occupied elsewhere in the room.
OccupancyMap perfect_map(const TruthLayer& truth, const Pose2& T_scene_map) {
  OccupancyMap map;
  map.cell_m = 0.01;
  map.origin = {-6, -6};
  map.columns = 1200;
  map.rows = 1200;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Vec2 p = T_scene_map * map.centre(column, row);
      const bool inside = p.x() > 1 && p.y() > 2 && p.x() < 5 && p.y() < 5;
      map.cells.push_back(!inside ? Cell::kUnknown : truth.at(p) ? Cell::kOccupied : Cell::kFree);
    }
  }
  return map;
}

const Pose2 kFounded{1.5, 2.5, kPi / 2};  // cells fall on cells

TEST(Reachable, IsWhereTheDiscsCentreCanBe) {
  const TruthLayer reachable = reachable_floor(layer(0.01, walls), {3, 3.5}, 0.25);
  // 3.8 x 2.8 m between the walls, less the radius on each side
  EXPECT_NEAR(area_m2(reachable), 3.3 * 2.3, kRoundoff);
  EXPECT_TRUE(reachable.at({1.356, 3.5}));
  EXPECT_FALSE(reachable.at({1.344, 3.5}));
}

TEST(Reachable, EndsAtAGapNarrowerThanTheDisc) {
  for (const double gap_m : {0.48, 0.54}) {
    const TruthLayer body = layer(0.01, [&](double x, double y) {
      return walls(x, y) || (x > 2 && x < 2.1 && std::abs(y - 1.5) > gap_m / 2);
    });
    const TruthLayer reachable = reachable_floor(body, {2, 3.5}, 0.25);
    EXPECT_EQ(reachable.at({4.5, 3.5}), gap_m > 0.5) << gap_m;
    EXPECT_TRUE(reachable.at({2, 3}));
  }
}

TEST(Reachable, CountsFromTheNearestFitWhenTheStartIsTight) {
  const TruthLayer body = layer(0.01, walls);
  EXPECT_NEAR(area_m2(reachable_floor(body, {1.2, 3.5}, 0.25)), 3.3 * 2.3, kRoundoff);
  EXPECT_EQ(area_m2(reachable_floor(body, {-3, 3.5}, 0.25)), 0);
}

TEST(Coverage, IsTheShareOfReachableCellsThatAreFree) {
  const TruthLayer body = layer(0.01, walls);
  const TruthLayer reachable = reachable_floor(body, {3, 3.5}, 0.25);
  OccupancyMap map = perfect_map(body, kFounded);
  EXPECT_EQ(coverage(reachable, map, kFounded), 1.0);
  for (int row = 0; row < map.rows; ++row) {  // nothing mapped beyond the middle of the room
    for (int column = 0; column < map.columns; ++column) {
      if ((kFounded * map.centre(column, row)).x() > 3) {
        map.cells[static_cast<std::size_t>(row) * 1200 + static_cast<std::size_t>(column)] =
            Cell::kUnknown;
      }
    }
  }
  EXPECT_NEAR(*coverage(reachable, map, kFounded), 0.5, kRoundoff);
  EXPECT_EQ(coverage(reachable_floor(body, {-3, 0}, 0.25), map, kFounded), std::nullopt);
}

Truth desk_room() {
  Truth truth;
  truth.floor = layer(0.01, [](double x, double y) {
    return walls(x, y) || (x > 2 && x < 3 && y > 1 && y < 2);  // a desk of 1 x 1 m
  });
  truth.body = truth.floor;
  // all but the desk's inside was seen
  truth.seen =
      layer(0.05, [](double x, double y) { return !(x > 2.1 && x < 2.9 && y > 1.1 && y < 1.9); });
  return truth;
}

TEST(MapQuality, OfAPerfectMapIsOne) {
  const Truth truth = desk_room();
  const MapQuality quality = map_quality(truth, perfect_map(truth.floor, kFounded), kFounded);
  EXPECT_EQ(quality.cells, 80 * 60 - 16 * 16);
  EXPECT_EQ(quality.free_iou, 1.0);
  EXPECT_EQ(quality.free_precision, 1.0);
  EXPECT_EQ(quality.obstacle_recall, 1.0);
}

TEST(MapQuality, FallsWithADeskThatIsMissing) {
  const Truth truth = desk_room();
  const TruthLayer bare = layer(0.01, walls);
  const MapQuality quality = map_quality(truth, perfect_map(bare, kFounded), kFounded);
  const double free = (3.8 * 2.8 - 1) / 0.0025;  // cells truly free, all seen
  const double wrong = 20.0 * 20 - 16 * 16;      // of the desk, what was seen
  EXPECT_NEAR(*quality.free_precision, free / (free + wrong), kRoundoff);
  EXPECT_NEAR(*quality.free_iou, free / (free + wrong), kRoundoff);
  const double wall_edge = 2.0 * (76 + 56) + 4 - 4;  // 5 cm cells with the walls' faces
  const double desk_edge = 4.0 * 19;
  EXPECT_NEAR(*quality.obstacle_recall, wall_edge / (wall_edge + desk_edge), kRoundoff);
}

TEST(MapQuality, TakesUnknownForNotFree) {
  const Truth truth = desk_room();
  OccupancyMap map = perfect_map(truth.floor, kFounded);
  for (Cell& cell : map.cells) {
    cell = Cell::kUnknown;
  }
  const MapQuality quality = map_quality(truth, map, kFounded);
  EXPECT_EQ(quality.free_iou, 0.0);
  EXPECT_EQ(quality.free_precision, std::nullopt);
  EXPECT_EQ(quality.obstacle_recall, 0.0);
}

TEST(MapQuality, FindsABoundaryWithinFiveCentimetres) {
  const Truth truth = desk_room();
  const OccupancyMap map = perfect_map(truth.floor, kFounded);
  // the map drawn 4 cm, then 8 cm aside along the scene's x: both of the faces that lie across lose
  // their match where the map has free floor before them
  const auto recall = [&](double aside_m) {
    const Pose2 moved{kFounded.x_m + aside_m, kFounded.y_m, kFounded.theta_rad};
    return *map_quality(truth, map, moved).obstacle_recall;
  };
  EXPECT_EQ(recall(0.04), 1.0);
  EXPECT_LT(recall(0.08), 1.0);
}

/// A map that is free where the function, of places in the room's frame, says.
OccupancyMap map_free_where(const std::function<bool(double, double)>& is_free) {
  OccupancyMap map = perfect_map(layer(0.01, walls), kFounded);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Vec2 p = kFounded * map.centre(column, row) - Vec2(1, 2);
      map.cells[static_cast<std::size_t>(row) * 1200 + static_cast<std::size_t>(column)] =
          is_free(p.x(), p.y()) ? Cell::kFree : Cell::kUnknown;
    }
  }
  return map;
}

TEST(Leak, OfAPerfectMapIsNone) {
  const Truth truth = desk_room();
  const auto none = leak(truth.floor, perfect_map(truth.floor, kFounded), kFounded);
  EXPECT_EQ(none->area_m2, 0);
  EXPECT_EQ(none->share, 0);
}

TEST(Leak, IsNoneWhereTheFloorIsNear) {
  const Truth truth = desk_room();
  const OccupancyMap map = perfect_map(truth.floor, kFounded);
  const Pose2 aside{kFounded.x_m + 0.05, kFounded.y_m - 0.05, kFounded.theta_rad};
  EXPECT_EQ(leak(truth.floor, map, aside)->area_m2, 0);
}

TEST(Leak, IsWhatLiesUnderADeskBeyondTenCentimetres) {
  const Truth truth = desk_room();
  const auto under = leak(truth.floor, perfect_map(layer(0.01, walls), kFounded), kFounded);
  EXPECT_NEAR(under->area_m2, 0.8 * 0.8, kRoundoff);
  EXPECT_NEAR(*under->share, 0.8 * 0.8 / (3.8 * 2.8), kRoundoff);
}

TEST(Leak, IsAllThatLiesBeyondTheWorld) {
  const Truth truth = desk_room();
  const auto patch = [](double x, double y) { return x > 5 && x < 6 && y > 0 && y < 0.5; };
  const auto beyond = leak(truth.floor, map_free_where(patch), kFounded);
  EXPECT_NEAR(beyond->area_m2, 0.5, kRoundoff);
  EXPECT_EQ(beyond->share, 1.0);
}

TEST(Leak, TakesTheRimAroundAWorldForNoFloor) {
  TruthLayer floor = layer(0.01, walls);
  for (int row = 0; row < floor.rows; ++row) {  // as worlds are given: clear beyond their walls
    for (int column = 0; column < floor.columns; ++column) {
      if (column < 2 || row < 2 || column > floor.columns - 3 || row > floor.rows - 3) {
        floor.cells[static_cast<std::size_t>(row) * 400 + static_cast<std::size_t>(column)] = 0;
      }
    }
  }
  const auto fan = [](double x, double y) { return x > 3.9 && x < 4.5 && y > 1 && y < 2; };
  const auto beyond = leak(floor, map_free_where(fan), kFounded);
  EXPECT_NEAR(beyond->area_m2, 0.5, kRoundoff);  // but for the wall's own 10 cm
}

TEST(Leak, HasNoShareOfAnEmptyMapAndNothingToSayWithoutALayer) {
  const Truth truth = desk_room();
  const auto nothing =
      leak(truth.floor, map_free_where([](double, double) { return false; }), kFounded);
  EXPECT_EQ(nothing->area_m2, 0);
  EXPECT_EQ(nothing->share, std::nullopt);
  EXPECT_FALSE(leak({}, perfect_map(truth.floor, kFounded), kFounded));
}

TEST(TimeOfCoverage, IsBetweenSamples) {
  const std::vector<CoverageSample> samples = {
      {time_at(0), 0, 0.1}, {time_at(10), 1, 0.4}, {time_at(20), 2, 0.6}, {time_at(30), 3, 0.5}};
  EXPECT_NEAR(*time_of_coverage_s(samples, 0.5), 15, kRoundoff);
  EXPECT_NEAR(*time_of_coverage_s(samples, 0.05), 0, kRoundoff);
  EXPECT_FALSE(time_of_coverage_s(samples, 0.9));
  EXPECT_FALSE(time_of_coverage_s({{time_at(0), 3, std::nullopt}}, 0.5));
}

}  // namespace
}  // namespace panoptes
