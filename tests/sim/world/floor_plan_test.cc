// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/floor_plan.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/io/file.h"
#include "core/io/map_server.h"
#include "sim/world/layers.h"
#include "tests/support/scratch.h"

namespace panoptes::sim {
namespace {

class FloorPlan : public ScratchTest {
 protected:
  std::string write(const OccupancyMap& map, double yaw_rad = 0) const {
    write_map_server(folder_ / "map", map);
    if (yaw_rad != 0) {
      std::string yaml = read_file(folder_ / "map.yaml");
      const std::string tail = ", 0]";
      yaml.replace(yaml.find(tail), tail.size(), ", " + std::to_string(yaw_rad) + "]");
      write_file(folder_ / "map.yaml", yaml);
    }
    return (folder_ / "map.yaml").string();
  }
  static World make(const std::string& map, bool has_ceiling = true) {
    WorldSettings settings;
    settings.floor_plan.emplace();
    settings.floor_plan->map = map;
    settings.floor_plan->has_ceiling = has_ceiling;
    return make_world(settings);
  }
};

/// Walls around, a pillar and a slanting wall inside.
OccupancyMap small_map() {
  OccupancyMap map;
  map.cell_m = 0.1;
  map.origin = {-1.3, 0.4};
  map.columns = 40;
  map.rows = 30;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const bool around =
          row == 0 || column == 0 || row == map.rows - 1 || column == map.columns - 1;
      const bool pillar = row > 20 && row < 25 && column > 5 && column < 9;
      const bool slanting = column > 12 && row == column - 8 && row < 22;
      map.cells.push_back(around || pillar || slanting ? Cell::kOccupied
                          : row > 25                   ? Cell::kUnknown
                                                       : Cell::kFree);
    }
  }
  return map;
}

TEST_F(FloorPlan, TheTruthIsTheMap) {
  const OccupancyMap map = small_map();
  const World world = make(write(map));
  const TruthLayer body = occupancy(world, kFloorLayerTop_m, 0.8, 0.02);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      for (const double dx : {-0.04, 0.0, 0.04}) {
        const Vec2 p = map.centre(column, row) + Vec2(dx, -dx);
        ASSERT_EQ(body.at(p), map.at(column, row) == Cell::kOccupied) << p.transpose();
      }
    }
  }
}

// The same law as a closed room's: every face is a side of a wall cell towards one that is none.
TEST_F(FloorPlan, FacesCoverEverySideOfEveryWallOnce) {
  const OccupancyMap map = small_map();
  const World world = make(write(map));
  const auto is_wall = [&map](int column, int row) {  // with the wall around the map
    const bool around = column == -1 || row == -1 || column == map.columns || row == map.rows;
    const bool beyond = column < -1 || row < -1 || column > map.columns || row > map.rows;
    return !beyond && (around || map.at(column, row) == Cell::kOccupied);
  };
  double sides_m = 0;
  for (int row = -1; row <= map.rows; ++row) {
    for (int column = -1; column <= map.columns; ++column) {
      if (is_wall(column, row)) {
        for (const auto& [dc, dr] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
          sides_m += is_wall(column + dc, row + dr) ? 0 : map.cell_m;
        }
      }
    }
  }
  const Object& walls = world.objects[0];
  double area_m2 = 0;
  for (const Triangle& t : walls.triangles) {
    const Vec3 a = t.corners[1].p_object - t.corners[0].p_object;
    const Vec3 b = t.corners[2].p_object - t.corners[0].p_object;
    area_m2 += a.cross(b).norm() / 2;
    // A step in front of it there is no wall, a step behind it there is.
    const Vec3 normal = a.cross(b).normalized();
    const Vec3 inside =
        walls.T_scene_object *
        Vec3((t.corners[0].p_object + t.corners[1].p_object + t.corners[2].p_object) / 3);
    const Vec2 off_corners = 0.01 * Vec2(std::abs(normal.y()), std::abs(normal.x()));
    const auto wall_at = [&](const Vec2& p) {
      const Vec2 cell = (p - map.origin) / map.cell_m;
      return is_wall(static_cast<int>(std::floor(cell.x())),
                     static_cast<int>(std::floor(cell.y())));
    };
    const Vec2 p = inside.head<2>() + off_corners;
    EXPECT_FALSE(wall_at(p + 0.05 * normal.head<2>()));
    EXPECT_TRUE(wall_at(p - 0.05 * normal.head<2>()));
  }
  EXPECT_NEAR(area_m2, 2.5 * sides_m, 1e-9);
}

TEST_F(FloorPlan, AStraightWallIsOneFace) {
  OccupancyMap map;
  map.cell_m = 0.05;
  map.columns = map.rows = 400;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      map.cells.push_back(row < 2 || column < 2 || row >= 398 || column >= 398 ? Cell::kOccupied
                                                                               : Cell::kFree);
    }
  }
  const World world = make(write(map));
  EXPECT_EQ(world.objects[0].triangles.size(), 16U);
  EXPECT_EQ(world.objects.size(), 3U);
  EXPECT_EQ(world.objects[1].triangles.size(), 2U);
  EXPECT_EQ(make(write(map), false).objects.size(), 2U);
}

TEST_F(FloorPlan, WhatIsUnknownMayBeWall) {
  const OccupancyMap map = small_map();
  WorldSettings settings;
  settings.floor_plan.emplace();
  settings.floor_plan->map = write(map);
  settings.floor_plan->unknown_is_wall = true;
  const TruthLayer body = occupancy(make_world(settings), kFloorLayerTop_m, 0.8, 0.05);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      ASSERT_EQ(body.at(map.centre(column, row)), map.at(column, row) != Cell::kFree);
    }
  }
}

TEST_F(FloorPlan, ATurnedOriginTurnsTheWalls) {
  const OccupancyMap map = small_map();
  const World world = make(write(map, 0.5));
  const TruthLayer body = occupancy(world, kFloorLayerTop_m, 0.8, 0.02);
  const Pose2 T_scene_map{map.origin.x(), map.origin.y(), 0.5};
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Vec2 p = T_scene_map * (map.centre(column, row) - map.origin);
      ASSERT_EQ(body.at(p), map.at(column, row) == Cell::kOccupied) << p.transpose();
    }
  }
}

// Noise is the worst a map can be: its walls grow into coarser cells until they can be drawn.
TEST_F(FloorPlan, TooManyFacesAreJoinedAndKeepEveryWall) {
  OccupancyMap map;
  map.cell_m = 0.05;
  map.columns = map.rows = 500;
  Rng rng(3);
  for (int i = 0; i < map.columns * map.rows; ++i) {
    map.cells.push_back(rng.uniform() < 0.2 ? Cell::kOccupied : Cell::kFree);
  }
  const World world = make(write(map));
  EXPECT_LE(world.objects[0].triangles.size(), 50'000U);
  const TruthLayer body = occupancy(world, kFloorLayerTop_m, 0.8, 0.05);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      ASSERT_TRUE(map.at(column, row) != Cell::kOccupied || body.at(map.centre(column, row)));
    }
  }
}

TEST_F(FloorPlan, AMapWithoutWallsIsRefused) {
  OccupancyMap map = small_map();
  std::fill(map.cells.begin(), map.cells.end(), Cell::kFree);
  const std::string file = write(map);
  try {
    make(file);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.what(), "floor plan: by the thresholds of '" + file +
                                "' none of its cells is wall; correct occupied_thresh or negate "
                                "there");
  }
}

TEST_F(FloorPlan, AMissingPictureIsSaidWithTheWorldsPlace) {
  const std::string file = write(small_map());
  std::filesystem::remove(folder_ / "map.pgm");
  write_file(folder_ / "world.yaml", "floor_plan: {map: map.yaml}\n");
  try {
    load_world((folder_ / "world.yaml").string());
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.what(), (folder_ / "world.yaml").string() +
                                ":1:19: floor plan: " + (folder_ / "map.pgm").string() +
                                ": cannot be opened: No such file or directory");
  }
}

}  // namespace
}  // namespace panoptes::sim
