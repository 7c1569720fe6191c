// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/geometry/grid2.h"

namespace panoptes {

enum class Cell : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

/// A finished or local map of the floor in some frame; unknown outside.
using OccupancyMap = Grid2<Cell>;

/// What a cell is that has parts_a_side squared parts, as `part(column, row)` tells: occupied where
/// any of them is, else free where at least half of them are, else unknown.
template <class Part>
Cell resampled(int parts_a_side, const Part& part) {
  int free = 0;
  for (int row = 0; row < parts_a_side; ++row) {
    for (int column = 0; column < parts_a_side; ++column) {
      const Cell cell = part(column, row);
      if (cell == Cell::kOccupied) {
        return Cell::kOccupied;
      }
      free += cell == Cell::kFree ? 1 : 0;
    }
  }
  return 2 * free >= parts_a_side * parts_a_side ? Cell::kFree : Cell::kUnknown;
}

/// Calls each(cell) for the cells whose centres are within `radius_m` of `p`.
template <class Each>
void for_each_in_disc(OccupancyMap& map, const Vec2& p, double radius_m, const Each& each) {
  const Vec2 low = p - Vec2::Constant(radius_m);
  const int first_column = map.column(low);
  const int first_row = map.row(low);
  const int count = static_cast<int>(std::ceil(2 * radius_m / map.cell_m)) + 1;
  for (int row = first_row; row < first_row + count; ++row) {
    for (int column = first_column; column < first_column + count; ++column) {
      if (map.contains(column, row) && (map.centre(column, row) - p).norm() <= radius_m) {
        each(map(column, row));
      }
    }
  }
}

/// Makes the cells occupied whose centres are within `radius_m` of `p`.
inline void occupy_disc(OccupancyMap& map, const Vec2& p, double radius_m) {
  for_each_in_disc(map, p, radius_m, [](Cell& cell) { cell = Cell::kOccupied; });
}

/// How many parts a side of their own size a cell of `cell_m` has; at least one.
inline int parts_a_side(double cell_m, double part_m) {
  return std::max(1, static_cast<int>(std::lround(cell_m / part_m)));
}

}  // namespace panoptes
