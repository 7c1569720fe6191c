// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/map_server.h"
#include "sim/physics/obstacles.h"
#include "sim/world/generate.h"
#include "sim/world/layers.h"
#include "sim/world/load.h"
#include "sim/world/map_walls.h"
#include "tests/support/scratch.h"

namespace panoptes::sim {
namespace {

using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Le;
using ::testing::Lt;

constexpr double kCell_m = 0.05;
constexpr double kRobotRadius_m = 0.25;
constexpr double kRobotHeight_m = 0.8;
// Outlines are simplified by up to a cell, and half a cell is the truth's.
constexpr double kOff_m = 1.6 * kCell_m;

/// Cells of 5 cm over 14 x 10 m, all unknown.
OccupancyMap unknown_map() {
  OccupancyMap map;
  map.cell_m = kCell_m;
  map.origin = {-3.0, 1.0};
  map.columns = 280;
  map.rows = 200;
  map.cells.assign(map.size(), Cell::kUnknown);
  return map;
}

/// Fills a rectangle given in metres from the map's corner, turned about the map's middle.
void fill(OccupancyMap& map, const Vec2& low, const Vec2& high, Cell cell, double turned_rad = 0) {
  const Vec2 middle(7, 5);
  const double c = std::cos(turned_rad);
  const double s = std::sin(turned_rad);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Vec2 p = kCell_m * Vec2(column + 0.5, row + 0.5) - middle;
      const Vec2 q = middle + Vec2(c * p.x() + s * p.y(), -s * p.x() + c * p.y());
      if ((q.array() > low.array()).all() && (q.array() < high.array()).all()) {
        map(column, row) = cell;
      }
    }
  }
}

/// Two rooms of 5 x 6 m with a doorway of 0.9 m between them, walls of 10 cm, a pillar of 0.3 m, a
/// speck, and a ray that nobody saw.
OccupancyMap two_rooms(double turned_rad = 0) {
  OccupancyMap map = unknown_map();
  fill(map, {1.9, 1.9}, {12.1, 8.1}, Cell::kOccupied, turned_rad);
  fill(map, {2, 2}, {6.95, 8}, Cell::kFree, turned_rad);
  fill(map, {7.05, 2}, {12, 8}, Cell::kFree, turned_rad);
  fill(map, {6.9, 4.5}, {7.1, 5.4}, Cell::kFree, turned_rad);
  fill(map, {4, 4}, {4.3, 4.3}, Cell::kOccupied, turned_rad);
  fill(map, {9, 6}, {9.1, 6.1}, Cell::kOccupied, turned_rad);
  fill(map, {8, 3}, {11, 3.05}, Cell::kUnknown, turned_rad);
  return map;
}

class Building : public ScratchTest {
 protected:
  BuildingPlan plan(const OccupancyMap& map) const {
    write_map_server(folder_ / "map", map);
    BuildingPlan plan;
    plan.map = (folder_ / "map.yaml").string();
    return plan;
  }
  static WorldSettings made(const BuildingPlan& plan) {
    WorldSettings settings;
    settings.generate = plan;
    return expanded(settings);
  }
  static World world(const BuildingPlan& plan) { return make_world(made(plan)); }
  static std::string refusal(const BuildingPlan& plan) {
    WorldSettings into;
    try {
      generate(plan, into);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(Building, TheFloorIsTheMapsAndItsWallsAreClosed) {
  const OccupancyMap map = two_rooms();
  const World house = world(plan(map));
  const TruthLayer body = occupancy(house, kFloorLayerTop_m, kRobotHeight_m, 0.02);
  // Whatever hangs together with a point inside is free by the map, or no farther than that from
  // it.
  std::vector<std::uint8_t> reached(body.cells.size(), 0);
  std::vector<std::size_t> open{
      body.index(body.column(map.origin + Vec2(3, 3)), body.row(map.origin + Vec2(3, 3)))};
  reached[open.front()] = 1;
  std::size_t count = 0;
  while (!open.empty()) {
    const std::size_t here = open.back();
    open.pop_back();
    ++count;
    const int column = static_cast<int>(here) % body.columns;
    const int row = static_cast<int>(here) / body.columns;
    const Vec2 p = body.centre(column, row) - map.origin;
    ASSERT_TRUE(p.x() > 2 - kOff_m && p.x() < 12 + kOff_m && p.y() > 2 - kOff_m &&
                p.y() < 8 + kOff_m)
        << p.transpose();
    for (const auto& [dc, dr] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      ASSERT_TRUE(body.contains(column + dc, row + dr));
      const std::size_t next = body.index(column + dc, row + dr);
      if (reached[next] == 0 && body.cells[next] == 0) {
        reached[next] = 1;
        open.push_back(next);
      }
    }
  }
  const double free_m2 = static_cast<double>(count) * body.cell_m * body.cell_m;
  EXPECT_NEAR(free_m2, 2 * 4.95 * 6 + 0.1 * 0.9 - 0.3 * 0.3, 0.02 * 60);
  // The second room is reached, the pillar stands, the speck and the ray are floor.
  const auto is_reached = [&](double x, double y) {
    const Vec2 p = map.origin + Vec2(x, y);
    return reached[body.index(body.column(p), body.row(p))] != 0;
  };
  EXPECT_TRUE(is_reached(11, 7));
  EXPECT_TRUE(is_reached(9.05, 6.05));
  EXPECT_TRUE(is_reached(9.5, 3.03));
  EXPECT_FALSE(is_reached(4.03, 4.15));
}

TEST_F(Building, WallsAreFull) {
  OccupancyMap map = unknown_map();
  fill(map, {1.8, 1.8}, {12.2, 8.2}, Cell::kOccupied);
  fill(map, {2, 2}, {6.9, 8}, Cell::kFree);
  fill(map, {7.1, 2}, {12, 8}, Cell::kFree);
  fill(map, {6.9, 4.5}, {7.1, 5.4}, Cell::kFree);
  const TruthLayer floor = occupancy(world(plan(map)), 0, kFloorLayerTop_m, 0.01);
  for (double x_m = 6.91; x_m < 7.1; x_m += 0.01) {
    EXPECT_TRUE(floor.at(map.origin + Vec2(x_m, 3.2)) != 0) << x_m;
  }
  EXPECT_EQ(floor.at(map.origin + Vec2(6.85, 3.2)), 0);
  EXPECT_EQ(floor.at(map.origin + Vec2(7.15, 3.2)), 0);
  EXPECT_EQ(floor.at(map.origin + Vec2(7, 5)), 0) << "the doorway";
}

TEST_F(Building, WallsAslantAreStraight) {
  constexpr double kTurned_rad = 0.12;
  const MapWalls walls = walls_of_map(two_rooms(kTurned_rad));
  // Four sides of each room, four jambs, the pillar's four: a few more where chance has it.
  EXPECT_THAT(walls.faces.size(), Le(24U));
  double longest_m = 0;
  for (const MapWalls::Face& face : walls.faces) {
    longest_m = std::max(longest_m, (face.to - face.from).norm());
  }
  EXPECT_THAT(longest_m, Gt(4.7));
}

TEST_F(Building, RoomsAreToldApart) {
  const MapWalls walls = walls_of_map(two_rooms());
  const auto room_at = [&walls](double x, double y) {
    return walls.room.at(Vec2(-3.0 + x, 1.0 + y));
  };
  EXPECT_NE(room_at(3, 3), room_at(11, 3));
  EXPECT_EQ(room_at(3, 3), room_at(6, 7));
  for (const MapWalls::Face& face : walls.faces) {
    EXPECT_THAT(face.room, Gt(0));
  }
}

TEST_F(Building, NobodyFitsAnywhereButOnItsFloor) {
  const Obstacles obstacles(
      outlines(world(plan(two_rooms(0.3))), kFloorLayerTop_m, kRobotHeight_m));
  // The region is the largest piece in which the body fits; were the walls hollow it would be
  // larger than the floor.
  const double area_m2 = FreeRegion(obstacles, kRobotRadius_m).area_m2();
  EXPECT_THAT(area_m2, Gt(35));
  EXPECT_THAT(area_m2, Lt(60));
}

TEST_F(Building, IsTheSameForTheSameSeedAndDressedOtherwiseForAnother) {
  BuildingPlan one = plan(two_rooms());
  const auto names = [](const WorldSettings& settings) {
    std::string all;
    for (const ObjectSettings& object : settings.objects) {
      all += fmt::format("{} {} {} {}\n", object.mesh, object.at.x_m, object.at.y_m, object.z_m);
    }
    for (const BoxSettings& box : settings.boxes) {
      all += fmt::format("{} {} {}\n", box.picture, box.at.x_m, box.at.y_m);
    }
    return all;
  };
  const std::string first = names(made(one));
  EXPECT_EQ(first, names(made(one)));
  one.seed = 2;
  EXPECT_NE(first, names(made(one)));
}

TEST_F(Building, MayBeScaledAndCropped) {
  BuildingPlan one = plan(two_rooms());
  one.scale = 2;
  one.low_m = Vec2(-3 + 1, 1 + 1);
  one.high_m = Vec2(-3 + 6.5, 1 + 9);
  Vec2 low(1e9, 1e9);
  Vec2 high(-1e9, -1e9);
  for (const BoxSettings& box : made(one).boxes) {
    if (box.name.starts_with("floor")) {
      low = box.at.position() - box.size_m.head<2>() / 2;
      high = box.at.position() + box.size_m.head<2>() / 2;
    }
  }
  constexpr double kTwoCells_m = 4 * kCell_m;
  EXPECT_NEAR(low.x(), 2 * (-3 + 2), kTwoCells_m);
  EXPECT_NEAR(high.x(), 2 * (-3 + 6.5), kTwoCells_m);
  EXPECT_NEAR(low.y(), 2 * (1 + 2), kTwoCells_m);
  EXPECT_NEAR(high.y(), 2 * (1 + 8), kTwoCells_m);
}

TEST_F(Building, MapsThatMakeNoBuildingAreRefused) {
  BuildingPlan none;
  none.map = (folder_ / "nowhere.yaml").string();
  EXPECT_THAT(refusal(none), HasSubstr("building.map: "));
  EXPECT_THAT(refusal(plan(unknown_map())), HasSubstr("has no free floor for a robot to start on"));
  OccupancyMap narrow = unknown_map();
  fill(narrow, {2, 2}, {12, 3.2}, Cell::kFree);  // a passage in which nobody can turn about
  EXPECT_THAT(refusal(plan(narrow)), HasSubstr("no place has 0.75 m clear all around"));
  OccupancyMap coarse = two_rooms();
  coarse.cell_m = 0.5;
  EXPECT_THAT(refusal(plan(coarse)),
              HasSubstr("0.5 m wide; walls are made of cells of 0.01 to 0.2"));
  BuildingPlan beside = plan(two_rooms());
  beside.low_m = Vec2(50, 50);
  beside.high_m = Vec2(60, 60);
  EXPECT_THAT(refusal(beside), HasSubstr("nothing of"));
}

TEST_F(Building, WithoutAMapOrWithOneThatIsNotThereIsRefusedInItsPlace) {
  const auto said = [](const std::string& text) -> std::string {
    try {
      read_settings_text<WorldSettings>(text, "w.yaml", {});
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(said("generate: {building: {seed: 1}}"),
              HasSubstr("generate.building.map: missing; it must name the yaml of a map"));
  EXPECT_THAT(said("generate: {building: {map: nowhere.yaml}}"), HasSubstr("nowhere.yaml"));
}

}  // namespace
}  // namespace panoptes::sim
