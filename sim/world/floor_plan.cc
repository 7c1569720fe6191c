// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/geometry/grid2.h"
#include "core/io/map_server.h"
#include "sim/world/boxes.h"

namespace panoptes::sim {
namespace {

// Beyond this a picture takes noticeably longer to draw (10 ms for 640x480 with 40 k triangles).
constexpr std::size_t kMostWallTriangles = 50'000;
constexpr double kFloorPicture_m = 2;  // of our own pictures' sides
constexpr double kCeilingPicture_m = 2.4;

/// Which cells are wall; nothing outside is.
using Walls = Grid2<std::uint8_t>;

/// The walls of a map, and one around it, so that nobody looks or drives out of it: the cell
/// (0, 0) is diagonally before the map's first.
Walls walls_of(const OccupancyMap& map, bool unknown_is_wall) {
  Walls walls;
  walls.cell_m = map.cell_m;
  walls.assign(map.columns + 2, map.rows + 2, 1);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Cell cell = map.at(column, row);
      const bool is_wall = cell == Cell::kOccupied || (unknown_is_wall && cell == Cell::kUnknown);
      walls(column + 1, row + 1) = is_wall ? 1 : 0;
    }
  }
  return walls;
}

/// Two by two cells in one, wall where any of them is.
Walls halved(const Walls& fine) {
  Walls walls;
  walls.cell_m = 2 * fine.cell_m;
  walls.assign((fine.columns + 1) / 2, (fine.rows + 1) / 2);
  for (int row = 0; row < fine.rows; ++row) {
    for (int column = 0; column < fine.columns; ++column) {
      if (fine.at(column, row) != 0) {
        walls(column / 2, row / 2) = 1;
      }
    }
  }
  return walls;
}

/// A rectangle of wall cells, ends excluded.
struct Block {
  int column = 0;
  int row = 0;
  int end_column = 0;
  int end_row = 0;
};

/// All wall cells, each in one block: row by row, each run as far up as it goes.
std::vector<Block> blocks_of(Walls walls) {
  std::vector<Block> blocks;
  for (int row = 0; row < walls.rows; ++row) {
    for (int column = 0; column < walls.columns; ++column) {
      if (walls.at(column, row) == 0) {
        continue;
      }
      Block block{column, row, column + 1, row + 1};
      while (walls.at(block.end_column, row) != 0) {
        ++block.end_column;
      }
      const auto row_is_wall = [&](int r) {
        for (int c = block.column; c < block.end_column; ++c) {
          if (walls.at(c, r) == 0) {
            return false;
          }
        }
        return true;
      };
      while (row_is_wall(block.end_row)) {
        ++block.end_row;
      }
      for (int r = block.row; r < block.end_row; ++r) {
        for (int c = block.column; c < block.end_column; ++c) {
          walls(c, r) = 0;
        }
      }
      blocks.push_back(block);
    }
  }
  return blocks;
}

/// A straight stretch of wall face between cell corners; the wall lies to the left of the way from
/// `from` to `to`.
struct Stretch {
  int from_column = 0;
  int from_row = 0;
  int to_column = 0;
  int to_row = 0;
};

/// The faces that something free is in front of, as long as they run straight.
std::vector<Stretch> stretches_of(const Walls& walls) {
  std::vector<Stretch> found;
  // Along rows: the faces below a row's cells, looking down, and above, looking up.
  for (int row = 0; row < walls.rows; ++row) {
    for (const int towards : {-1, 1}) {
      for (int column = 0; column < walls.columns; ++column) {
        const int first = column;
        while (column < walls.columns && walls.at(column, row) != 0 &&
               walls.at(column, row + towards) == 0) {
          ++column;
        }
        if (column > first) {
          const int edge = towards < 0 ? row : row + 1;
          found.push_back(towards < 0 ? Stretch{first, edge, column, edge}
                                      : Stretch{column, edge, first, edge});
        }
      }
    }
  }
  for (int column = 0; column < walls.columns; ++column) {
    for (const int towards : {-1, 1}) {
      for (int row = 0; row < walls.rows; ++row) {
        const int first = row;
        while (row < walls.rows && walls.at(column, row) != 0 &&
               walls.at(column + towards, row) == 0) {
          ++row;
        }
        if (row > first) {
          const int edge = towards < 0 ? column : column + 1;
          found.push_back(towards < 0 ? Stretch{edge, row, edge, first}
                                      : Stretch{edge, first, edge, row});
        }
      }
    }
  }
  return found;
}

std::size_t triangles_for(const std::vector<Stretch>& stretches, const std::vector<Block>& tops) {
  return 2 * (stretches.size() + tops.size());
}

/// Width of a picture that stands as high as the wall.
double picture_width_m(const cv::Mat& picture, double height_m) {
  return picture.empty() ? height_m : height_m * picture.cols / picture.rows;
}

/// A sheet over the whole map.
Object sheet(const std::string& name, const Walls& walls, double z_m, bool looks_up,
             double picture_m, int texture, const Pose3& T_scene_object) {
  const Vec2 size = walls.cell_m * Vec2(walls.columns, walls.rows);
  std::array<Vec3, 4> corners{Vec3(0, 0, z_m), Vec3(size.x(), 0, z_m),
                              Vec3(size.x(), size.y(), z_m), Vec3(0, size.y(), z_m)};
  if (!looks_up) {
    std::swap(corners[0], corners[1]);
    std::swap(corners[2], corners[3]);
  }
  Object object;
  object.name = name;
  object.T_scene_object = T_scene_object;
  const Vec2 repeats = size / picture_m;
  append_rectangle(corners, {0, repeats.y()}, {repeats.x(), 0}, texture, object.triangles);
  return object;
}

}  // namespace

std::vector<Object> make_floor_plan(const FloorPlanSettings& settings, Pictures& pictures) {
  const std::string prefix = settings.mention.empty() ? "" : settings.mention + ": ";
  MapServerMap read;
  try {
    read = read_turned_map_server(settings.map);
  } catch (const IoError& error) {
    throw IoError(prefix + "floor plan: " + error.what());
  } catch (const ConfigError& error) {
    throw ConfigError(prefix + "floor plan: " + error.what());
  }
  const auto occupied = std::count(read.map.cells.begin(), read.map.cells.end(), Cell::kOccupied);
  if (occupied == 0 || occupied == static_cast<std::ptrdiff_t>(read.map.cells.size())) {
    throw ConfigError(fmt::format(
        "{}floor plan: by the thresholds of '{}' {} of its cells is wall; correct occupied_thresh "
        "or negate there",
        prefix, settings.map, occupied == 0 ? "none" : "every one"));
  }
  Walls walls = walls_of(read.map, settings.unknown_is_wall);
  std::vector<Block> blocks = blocks_of(walls);
  std::vector<Stretch> stretches = stretches_of(walls);
  const std::vector<Block> none;
  while (triangles_for(stretches, settings.has_ceiling ? none : blocks) > kMostWallTriangles) {
    walls = halved(walls);
    blocks = blocks_of(walls);
    stretches = stretches_of(walls);
  }

  const auto picture = [&](const std::string& given, const std::string& mention, const char* ours) {
    return given.empty() ? pictures.from_file(ours, settings.mention)
                         : pictures.from_file(given, mention);
  };
  const Pose2 T_scene_map{read.map.origin.x(), read.map.origin.y(), read.yaw_rad};
  const Pose3 T_scene_walls = on_floor(T_scene_map * Pose2{-read.map.cell_m, -read.map.cell_m, 0});
  const int wall_texture = picture(settings.wall, settings.wall_mention, "data:office/wall.png");
  const double repeat_m = picture_width_m(pictures.at(wall_texture), settings.height_m);

  Object faces;
  faces.name = "floor-plan-walls";
  faces.T_scene_object = T_scene_walls;
  for (const Stretch& s : stretches) {
    const Vec3 from = walls.cell_m * Vec3(s.from_column, s.from_row, 0);
    const Vec3 to = walls.cell_m * Vec3(s.to_column, s.to_row, 0);
    const Vec3 up(0, 0, settings.height_m);
    // The picture runs on from stretch to stretch of the same direction.
    const Vec3 along = (to - from).normalized();
    append_rectangle({from, to, to + up, from + up}, {along.dot(from) / repeat_m, 1},
                     {along.dot(to) / repeat_m, 0}, wall_texture, faces.triangles);
  }
  for (const Block& block : blocks) {
    const Vec2 low = walls.cell_m * Vec2(block.column, block.row);
    const Vec2 high = walls.cell_m * Vec2(block.end_column, block.end_row);
    const std::vector<Vec2> corners{low, {high.x(), low.y()}, high, {low.x(), high.y()}};
    if (!settings.has_ceiling) {
      const double z_m = settings.height_m;
      append_rectangle({Vec3(low.x(), low.y(), z_m), Vec3(high.x(), low.y(), z_m),
                        Vec3(high.x(), high.y(), z_m), Vec3(low.x(), high.y(), z_m)},
                       Vec2(low.x(), -low.y()) / repeat_m, Vec2(high.x(), -high.y()) / repeat_m,
                       wall_texture, faces.triangles);
    }
    faces.pillars.push_back({corners, 0, settings.height_m});
  }
  std::vector<Object> parts;
  parts.push_back(std::move(faces));
  parts.push_back(
      sheet("floor-plan-floor", walls, 0, true, kFloorPicture_m,
            picture(settings.floor, settings.floor_mention, "data:office/carpet_sand.png"),
            T_scene_walls));
  if (settings.has_ceiling) {
    parts.push_back(
        sheet("floor-plan-ceiling", walls, settings.height_m, false, kCeilingPicture_m,
              picture(settings.ceiling, settings.ceiling_mention, "data:office/ceiling.png"),
              T_scene_walls));
  }
  return parts;
}

}  // namespace panoptes::sim
