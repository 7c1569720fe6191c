// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes {

/// Square cells over a rectangle of some frame, row-major from the lower-left corner: cell (column,
/// row) covers origin + cell_m * [column, column + 1) x [row, row + 1).
template <class T>
struct Grid2 {
  double cell_m = 0.01;
  Vec2 origin = Vec2::Zero();
  int columns = 0;
  int rows = 0;
  std::vector<T> cells;

  /// So many cells, all of one value.
  void assign(int new_columns, int new_rows, const T& value = T{}) {
    columns = new_columns;
    rows = new_rows;
    cells.assign(size(), value);
  }
  std::size_t size() const {  ///< how many cells there ought to be
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  bool contains(int column, int row) const {
    return column >= 0 && row >= 0 && column < columns && row < rows;
  }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  T& operator()(int column, int row) { return cells[index(column, row)]; }
  const T& operator()(int column, int row) const { return cells[index(column, row)]; }
  T at(int column, int row) const {  ///< T{} outside
    return contains(column, row) ? cells[index(column, row)] : T{};
  }
  T at(const Vec2& p) const {
    const double column = std::floor((p.x() - origin.x()) / cell_m);
    const double row = std::floor((p.y() - origin.y()) / cell_m);
    if (!(column >= 0 && row >= 0 && column < columns && row < rows)) {
      return T{};
    }
    return cells[index(static_cast<int>(column), static_cast<int>(row))];
  }

  /// Of the cell that holds `p`; may lie outside.
  int column(const Vec2& p) const {
    return static_cast<int>(std::floor((p.x() - origin.x()) / cell_m));
  }
  int row(const Vec2& p) const {
    return static_cast<int>(std::floor((p.y() - origin.y()) / cell_m));
  }

  /// So many cells from the lower-left corner.
  Vec2 point(double column, double row) const { return origin + cell_m * Vec2(column, row); }
  Vec2 centre(int column, int row) const { return point(column + 0.5, row + 0.5); }

  /// Of the cells of one value.
  double area_m2(const T& value) const {
    return static_cast<double>(std::count(cells.begin(), cells.end(), value)) * cell_m * cell_m;
  }
};

/// The same cells, each with what `value_of` makes of it.
template <class T, class ValueOf>
auto transformed(const Grid2<T>& grid, const ValueOf& value_of) {
  Grid2<decltype(value_of(grid.cells.front()))> out{
      grid.cell_m, grid.origin, grid.columns, grid.rows, {}};
  out.cells.resize(grid.cells.size());
  std::transform(grid.cells.begin(), grid.cells.end(), out.cells.begin(), value_of);
  return out;
}

}  // namespace panoptes
