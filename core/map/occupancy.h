// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes {

enum class Cell : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

/// A finished or local map of the floor in some frame: row-major from the lower-left corner; cell
/// (column, row) covers origin + cell_m * [column, column + 1) x [row, row + 1).
struct OccupancyMap {
  double cell_m = 0.01;
  Vec2 origin = Vec2::Zero();
  int columns = 0;
  int rows = 0;
  std::vector<Cell> cells;

  bool contains(int column, int row) const {
    return column >= 0 && row >= 0 && column < columns && row < rows;
  }
  Cell at(int column, int row) const {  ///< unknown outside
    return contains(column, row) ? cells[static_cast<std::size_t>(row) * columns + column]
                                 : Cell::kUnknown;
  }
  Cell at(const Vec2& p) const;
  Vec2 centre(int column, int row) const { return origin + cell_m * Vec2(column + 0.5, row + 0.5); }
  double free_m2() const;
};

}  // namespace panoptes
