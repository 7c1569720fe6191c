// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/io/map_server.h"
#include "sim/world/generate.h"
#include "sim/world/load.h"
#include "sim/world/map_walls.h"
#include "sim/world/room_plan.h"

namespace panoptes::sim {
namespace {

constexpr double kFinest_m = 0.01;
constexpr double kCoarsest_m = 0.2;
constexpr double kWidest_m = 200;
constexpr double kStart_m = 0.75;       // floor that is clear about a start, and half a cell
constexpr double kLeastSheet_m = 0.03;  // of wall behind a face,
constexpr double kMostSheet_m = 0.1;    // which is half of a wall, so that none is hollow
constexpr double kLampPitch_m = 3.2;
constexpr double kLampClear_m = 0.35;  // half a lamp's width
constexpr double kLampPower = 0.9;
constexpr double kLeastDressed_m = 0.4;
const std::array<const char*, 7> kPapers{
    "office/wall",   "corridors/wall_a",       "office/wall_b",       "corridors/wall_b",
    "office/wall_b", "home/wallpaper_stripes", "home/wallpaper_retro"};
const std::array<FloorPicture, 4> kFloors{{{"corridors/linoleum", 2.0},
                                           {"office/carpet_sand", 2.0},
                                           {"office/carpet_blue", 2.0},
                                           {"home/parquet", 1.6}}};

/// The part of a map between two corners of its own frame.
OccupancyMap cropped(const OccupancyMap& map, const Vec2& low, const Vec2& high) {
  const auto clamped = [](int at, int count) { return std::clamp(at, 0, count); };
  const int column = clamped(map.column(low), map.columns);
  const int row = clamped(map.row(low), map.rows);
  OccupancyMap part;
  part.cell_m = map.cell_m;
  part.origin = map.point(column, row);
  part.assign(std::max(0, clamped(map.column(high), map.columns) - column),
              std::max(0, clamped(map.row(high), map.rows) - row));
  for (int r = 0; r < part.rows; ++r) {
    for (int c = 0; c < part.columns; ++c) {
      part(c, r) = map(column + c, row + r);
    }
  }
  return part;
}

/// The part of a map that is taken, in a frame at the map's lower left corner, and where that is.
struct PlacedMap {
  OccupancyMap map;
  Pose2 T_scene_map;
};

PlacedMap read_map(const BuildingPlan& plan) {
  MapServerMap read;
  try {
    read = read_turned_map_server(plan.map);
  } catch (const IoError& error) {
    throw IoError(std::string("building.map: ") + error.what());
  } catch (const ConfigError& error) {
    throw ConfigError(std::string("building.map: ") + error.what());
  }
  OccupancyMap& map = read.map;
  const Vec2 corner = map.origin;
  map.origin = Vec2::Zero();
  if (plan.low_m || plan.high_m) {
    const Vec2 all = map.point(map.columns, map.rows);
    const Vec2 low = plan.low_m ? Vec2(*plan.low_m - corner) : Vec2::Zero();
    const Vec2 high = plan.high_m ? Vec2(*plan.high_m - corner) : all;
    map = cropped(map, low, high);
    if (map.cells.empty()) {
      throw ConfigError(fmt::format(
          "building.low_m, high_m: nothing of '{}' lies between them; it reaches from [{:g}, {:g}] "
          "to [{:g}, {:g}]",
          plan.map, corner.x(), corner.y(), corner.x() + all.x(), corner.y() + all.y()));
    }
  }
  map.cell_m *= plan.scale;
  map.origin = plan.scale * map.origin;
  if (map.cell_m < kFinest_m - 1e-9 || map.cell_m > kCoarsest_m + 1e-9) {
    throw ConfigError(fmt::format(
        "building.map: the cells of '{}' are {:g} m wide{}; walls are made of cells of {:g} to "
        "{:g} "
        "m: correct resolution there",
        plan.map, map.cell_m, plan.scale == 1 ? "" : " at this scale", kFinest_m, kCoarsest_m));
  }
  const double widest_m = map.cell_m * std::max(map.columns, map.rows);
  if (widest_m > kWidest_m) {
    throw ConfigError(fmt::format(
        "building.map: '{}' is {:.4g} m wide; a building may be {:g}: take a part by low_m and "
        "high_m",
        plan.map, widest_m, kWidest_m));
  }
  // The map's own frame is the scene's, its origin the same and its lengths as the plan says.
  return {std::move(map), {plan.scale * corner.x(), plan.scale * corner.y(), read.yaw_rad}};
}

/// How much of the wall behind a face is the face's: half of it.
double sheet_m(const MapWalls& walls, const MapWalls::Face& face) {
  const Vec2 along = face.to - face.from;
  const Vec2 behind = Vec2(along.y(), -along.x()).normalized();  // the floor lies to the left
  const double step_m = walls.floor.cell_m / 4;
  const int samples = std::max(2, static_cast<int>(along.norm() / walls.floor.cell_m));
  double least_m = 2 * kMostSheet_m;
  for (int k = 0; k < samples; ++k) {
    const Vec2 p = face.from + along * ((k + 0.5) / samples);
    for (double depth_m = walls.floor.cell_m / 2; depth_m < least_m; depth_m += step_m) {
      if (walls.floor.at(p + depth_m * behind) != 0) {
        least_m = depth_m;
      }
    }
  }
  return std::max(least_m / 2, kLeastSheet_m);
}

/// Doors, boards, pictures and what else hangs on walls.
void dress_face(WorldSettings& into, WallFace& face, Rng& rng) {
  constexpr double kDoorHalf_m = 0.53;
  for (double s_m = rng.uniform(0.7, 2.4); s_m < face.length_m(); s_m += rng.uniform(2.2, 6.0)) {
    const Rectangle leaf{{s_m - kDoorHalf_m, 0}, {s_m + kDoorHalf_m, 2.14}};
    if (rng.uniform() < 0.6 && face.is_clear(leaf.grown(0.05))) {
      face.take(leaf);
      put(into, std::string("corridors/door_") + "abcd"[rng.index(4)], face.at(s_m), 1.07);
    }
  }
  for (double s_m = rng.uniform(0.5, 3); s_m < face.length_m(); s_m += rng.uniform(2.0, 5.0)) {
    hang(into, face, {std::string("corridors/board_") + "abc" [rng.index(3)], { 1.60, 1.10 }}, s_m,
         1.55);
  }
  dress(into, face, 0.85, rng);
}

/// Lamps about every 3 m where there is floor below them, each where it has most room.
void put_lamps_over(WorldSettings& into, const MapWalls& walls, const Pose2& T_scene_map) {
  const int pitch = std::max(1, static_cast<int>(std::lround(kLampPitch_m / walls.floor.cell_m)));
  for (int row = 0; row < walls.floor.rows; row += pitch) {
    for (int column = 0; column < walls.floor.columns; column += pitch) {
      double most_m = kLampClear_m;
      Vec2 at = Vec2::Zero();
      const Vec2 middle = walls.floor.point(column + pitch / 2.0, row + pitch / 2.0);
      for (int r = row; r < std::min(walls.floor.rows, row + pitch); ++r) {
        for (int c = column; c < std::min(walls.floor.columns, column + pitch); ++c) {
          const Vec2 here = walls.floor.centre(c, r);
          const double clear_m = walls.clearance_m(c, r) - 0.3 * (here - middle).norm();
          if (walls.clearance_m(c, r) > kLampClear_m && (at.isZero() || clear_m > most_m)) {
            most_m = clear_m;
            at = here;
          }
        }
      }
      if (!at.isZero()) {
        const Vec2 p = T_scene_map * at;
        put_lamp(into, {p.x(), p.y(), T_scene_map.theta_rad}, kLampPower);
      }
    }
  }
}

}  // namespace

void bind(Fields& f, BuildingPlan& o) {
  f.require(f.present("map"), "map", "missing; it must name the yaml of a map");
  f.path("map", o.map);
  f("scale", o.scale, between(0.1, 10));
  f("low_m", o.low_m);
  f("high_m", o.high_m);
  f("seed", o.seed);
  f.require(!o.low_m || !o.high_m || (o.high_m->array() > o.low_m->array()).all(), "high_m",
            "must be above low_m along both axes");
}

void generate(const BuildingPlan& plan, WorldSettings& into) {
  const PlacedMap placed = read_map(plan);
  const Pose2& T_scene_map = placed.T_scene_map;
  const MapWalls walls = walls_of_map(placed.map);
  const double area_m2 = walls.floor.area_m2(1);
  const float most_clear_m =
      walls.clearance_m.cells.empty()
          ? 0
          : *std::max_element(walls.clearance_m.cells.begin(), walls.clearance_m.cells.end());
  if (most_clear_m < kStart_m) {
    throw ConfigError(fmt::format(
        "building.map: '{}' has no free floor for a robot to start on: of its {:.3g} m2 of floor "
        "no place has {:g} m clear all around; correct free_thresh, negate or resolution there, or "
        "scale",
        plan.map, area_m2, kStart_m));
  }
  Rng rng = Rng(plan.seed).fork("building");
  into.ambient = 0.5;
  Rng surfaces = rng.fork("surfaces");
  const FloorPicture& floor = one_of(kFloors, surfaces);
  std::vector<std::string> papers(
      1 + *std::max_element(walls.room.cells.begin(), walls.room.cells.end()));
  for (std::string& paper : papers) {
    paper = one_of(kPapers, surfaces);
  }
  Vec2 low = T_scene_map * walls.faces.front().from;
  Vec2 high = low;
  Rng things = rng.fork("walls");
  for (const MapWalls::Face& stretch : walls.faces) {
    const Vec2 from = T_scene_map * stretch.from;
    const Vec2 to = T_scene_map * stretch.to;
    low = low.cwiseMin(from);
    high = high.cwiseMax(from);
    // Seen from the floor, which lies to the left of the way from one to the other, `to` is the
    // left end.
    WallFace face(to, from);
    const Pose2 at = face.at(face.length_m() / 2);
    const double thick_m = sheet_m(walls, stretch);
    const Vec2 middle = at * Vec2(-thick_m / 2, 0);
    const std::string& paper = papers[static_cast<std::size_t>(stretch.room)];
    const double repeat_m = wall_repeat_m(paper);
    BoxSettings& sheet =
        put_box(into, "wall", Vec3(thick_m, face.length_m(), kRoomHeight_m),
                {middle.x(), middle.y(), at.theta_rad}, 0, paper, Vec2(repeat_m, repeat_m));
    sheet.faces = {{"back", ""}, {"left", ""}, {"right", ""}, {"top", ""}, {"bottom", ""}};
    if (face.length_m() >= kLeastDressed_m) {
      dress_face(into, face, things);
    }
  }
  // What is no floor is full, up to above the ceiling, so that nobody starts inside.
  for (const auto& [column, row, end_column, end_row] : walls.solid) {
    const Vec2 size = walls.floor.cell_m * Vec2(end_column - column, end_row - row);
    const Vec2 middle =
        T_scene_map * walls.floor.point((column + end_column) / 2.0, (row + end_row) / 2.0);
    BoxSettings& block =
        put_box(into, "solid", Vec3(size.x(), size.y(), kRoomHeight_m + 0.1),
                {middle.x(), middle.y(), T_scene_map.theta_rad}, 0, papers.front());
    block.faces = {{"front", ""}, {"back", ""}, {"left", ""}, {"right", ""}, {"bottom", ""}};
  }
  put_floor(into, low, high, floor.picture, floor.tile_m);
  put_ceiling(into, low, high);
  put_lamps_over(into, walls, T_scene_map);
}

}  // namespace panoptes::sim
