// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace panoptes {

/// The cells (column, row) of [low_column, end_column) x [low_row, end_row).
struct CellBox {
  int low_column = 0;
  int low_row = 0;
  int end_column = 0;
  int end_row = 0;

  int columns() const { return end_column - low_column; }
  int rows() const { return end_row - low_row; }
  std::size_t size() const {
    return static_cast<std::size_t>(columns()) * static_cast<std::size_t>(rows());
  }
  bool contains(int column, int row) const {
    return column >= low_column && row >= low_row && column < end_column && row < end_row;
  }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row - low_row) * static_cast<std::size_t>(columns()) +
           static_cast<std::size_t>(column - low_column);
  }
  bool operator==(const CellBox&) const = default;
};

/// Cells of the endless lattice through a frame's origin, which grows to hold those asked for: cell
/// (column, row) covers cell_m * [column, column + 1) x [row, row + 1). It grows by whole blocks of
/// `block` cells, so that it seldom does; what is new is T{}.
template <class T>
class Lattice2 {
 public:
  Lattice2(double cell_m, int block) : cell_m_(cell_m), block_(block) {}

  double cell_m() const { return cell_m_; }
  const CellBox& box() const { return box_; }

  /// What box() is after reserve(asked).
  CellBox grown(const CellBox& asked) const {
    CellBox out{block_floor(asked.low_column), block_floor(asked.low_row),
                -block_floor(-asked.end_column), -block_floor(-asked.end_row)};
    if (!cells_.empty()) {
      out = {std::min(out.low_column, box_.low_column), std::min(out.low_row, box_.low_row),
             std::max(out.end_column, box_.end_column), std::max(out.end_row, box_.end_row)};
    }
    return out;
  }

  void reserve(const CellBox& asked) {
    const CellBox to = grown(asked);
    if (to == box_) {
      return;
    }
    std::vector<T> cells(to.size());
    for (int row = box_.low_row; row < box_.end_row; ++row) {
      std::copy_n(this->row(row), box_.columns(), cells.data() + to.index(box_.low_column, row));
    }
    cells_ = std::move(cells);
    box_ = to;
  }

  T* data() { return cells_.data(); }  ///< box().index() tells which is which
  const T* data() const { return cells_.data(); }

  /// Of box().columns() cells, from box().low_column on.
  T* row(int row) { return cells_.data() + box_.index(box_.low_column, row); }
  const T* row(int row) const { return cells_.data() + box_.index(box_.low_column, row); }

  T& operator()(int column, int row) { return cells_[box_.index(column, row)]; }
  T at(int column, int row) const {  ///< T{} outside
    return box_.contains(column, row) ? cells_[box_.index(column, row)] : T{};
  }

 private:
  int block_floor(int cells) const {
    return (cells >= 0 ? cells / block_ : -((block_ - 1 - cells) / block_)) * block_;
  }

  double cell_m_;
  int block_;
  CellBox box_;
  std::vector<T> cells_;
};

}  // namespace panoptes
