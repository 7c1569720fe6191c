// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/map/occupancy.h"

namespace panoptes::test {

/// A map drawn in text, the uppermost line first: '#' occupied, '.' free, anything else unknown.
/// Every character is a square of `square_m`; its lower-left corner is the map's origin.
inline OccupancyMap floor_plan(const std::vector<std::string>& lines, double square_m,
                               double cell_m) {
  const int factor = static_cast<int>(square_m / cell_m + 0.5);
  OccupancyMap map;
  map.cell_m = cell_m;
  map.assign(static_cast<int>(lines.front().size()) * factor,
             static_cast<int>(lines.size()) * factor);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const char c = lines[lines.size() - 1 - static_cast<std::size_t>(row / factor)]
                          [static_cast<std::size_t>(column / factor)];
      map(column, row) = c == '#' ? Cell::kOccupied : (c == '.' ? Cell::kFree : Cell::kUnknown);
    }
  }
  return map;
}

/// A free rectangle from (0, 0) with walls of one cell around it.
inline OccupancyMap empty_room(double width_m, double height_m, double cell_m) {
  OccupancyMap map;
  map.cell_m = cell_m;
  map.assign(static_cast<int>(width_m / cell_m + 0.5), static_cast<int>(height_m / cell_m + 0.5),
             Cell::kFree);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      if (row == 0 || column == 0 || row + 1 == map.rows || column + 1 == map.columns) {
        map(column, row) = Cell::kOccupied;
      }
    }
  }
  return map;
}

/// Sets the cells whose centres lie in [x0, x1) x [y0, y1).
inline void fill(OccupancyMap& map, double x0, double y0, double x1, double y1, Cell cell) {
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Vec2 p = map.centre(column, row);
      if (p.x() >= x0 && p.x() < x1 && p.y() >= y0 && p.y() < y1) {
        map(column, row) = cell;
      }
    }
  }
}

}  // namespace panoptes::test
