// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/clearance.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace panoptes {
int ClearanceMap::column(const Vec2& p) const {
  return static_cast<int>(std::floor((p.x() - map.origin.x()) / map.cell_m));
}

int ClearanceMap::row(const Vec2& p) const {
  return static_cast<int>(std::floor((p.y() - map.origin.y()) / map.cell_m));
}

std::vector<float> distance_m(const std::vector<std::uint8_t>& blocks, int columns, int rows,
                              double cell_m, double cap_m) {
  PANOPTES_CHECK(blocks.size() == static_cast<std::size_t>(columns) * rows,
                 "a value for every cell");
  cv::Mat1b free(rows, columns);
  std::transform(blocks.begin(), blocks.end(), free.begin(),
                 [](std::uint8_t block) { return static_cast<std::uint8_t>(block == 0); });
  std::vector<float> d(blocks.size());
  cv::Mat1f distance(rows, columns, d.data());
  if (!d.empty()) {
    cv::distanceTransform(free, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  }
  const auto cell = static_cast<float>(cell_m);
  const auto cap = static_cast<float>(cap_m);
  for (float& v : d) {
    v = std::min(cap, cell * v);
  }
  return d;
}

ClearanceMap clearance_map(OccupancyMap map, double cap_m) {
  const auto size = static_cast<std::size_t>(map.columns) * map.rows;
  PANOPTES_CHECK(map.cells.size() == size, "a map has a value for every cell");
  std::vector<std::uint8_t> occupied(size);
  // A frame of one cell stands for the unknown outside.
  const int wide = map.columns + 2;
  std::vector<std::uint8_t> unknown(static_cast<std::size_t>(wide) * (map.rows + 2), 1);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const std::size_t i = static_cast<std::size_t>(row) * map.columns + column;
      occupied[i] = map.cells[i] == Cell::kOccupied ? 1 : 0;
      unknown[static_cast<std::size_t>(row + 1) * wide + column + 1] =
          map.cells[i] == Cell::kUnknown ? 1 : 0;
    }
  }
  ClearanceMap out;
  out.cap_m = cap_m;
  out.to_occupied_m = distance_m(occupied, map.columns, map.rows, map.cell_m, cap_m);
  const std::vector<float> framed = distance_m(unknown, wide, map.rows + 2, map.cell_m, cap_m);
  out.to_unknown_m.resize(size);
  for (int row = 0; row < map.rows; ++row) {
    const auto from = framed.begin() + static_cast<std::ptrdiff_t>(row + 1) * wide + 1;
    std::copy(from, from + map.columns,
              out.to_unknown_m.begin() + static_cast<std::ptrdiff_t>(row) * map.columns);
  }
  out.map = std::move(map);
  return out;
}

OccupancyMap coarsen(const OccupancyMap& map, double cell_m, double border_m) {
  const int factor = std::max(1, static_cast<int>(std::lround(cell_m / map.cell_m)));
  const int blocks_wide = (map.columns + factor - 1) / factor;
  const int blocks_high = (map.rows + factor - 1) / factor;
  OccupancyMap all;
  all.cell_m = map.cell_m * factor;
  all.columns = blocks_wide;
  all.rows = blocks_high;
  all.cells.assign(static_cast<std::size_t>(blocks_wide) * blocks_high, Cell::kUnknown);

  // The rectangle of blocks in which anything is known.
  int left = blocks_wide;
  int right = 0;
  int low = blocks_high;
  int high = 0;
  // Column sums over a row of blocks first: plain loops over bytes.
  std::vector<std::uint16_t> free(static_cast<std::size_t>(map.columns));
  std::vector<std::uint8_t> occupied(static_cast<std::size_t>(map.columns));
  for (int block_row = 0; block_row < blocks_high; ++block_row) {
    std::fill(free.begin(), free.end(), std::uint16_t{0});
    std::fill(occupied.begin(), occupied.end(), std::uint8_t{0});
    const int row_end = std::min(map.rows, (block_row + 1) * factor);
    for (int row = block_row * factor; row < row_end; ++row) {
      const Cell* cells = map.cells.data() + static_cast<std::size_t>(row) * map.columns;
      for (int column = 0; column < map.columns; ++column) {
        free[column] = static_cast<std::uint16_t>(free[column] + (cells[column] == Cell::kFree));
        occupied[column] =
            static_cast<std::uint8_t>(occupied[column] | (cells[column] == Cell::kOccupied));
      }
    }
    Cell* to = all.cells.data() + static_cast<std::size_t>(block_row) * blocks_wide;
    for (int block = 0; block < blocks_wide; ++block) {
      int free_parts = 0;
      bool any_occupied = false;
      const int end = std::min(map.columns, (block + 1) * factor);
      for (int column = block * factor; column < end; ++column) {
        free_parts += free[column];
        any_occupied = any_occupied || occupied[column] != 0;
      }
      if (any_occupied) {
        to[block] = Cell::kOccupied;
      } else if (2 * free_parts >= factor * factor) {
        to[block] = Cell::kFree;
      } else {
        continue;
      }
      left = std::min(left, block);
      right = std::max(right, block + 1);
      low = std::min(low, block_row);
      high = std::max(high, block_row + 1);
    }
  }
  OccupancyMap out;
  out.cell_m = all.cell_m;
  if (right <= left) {
    out.origin = map.origin;
    return out;
  }
  const int border = std::max(0, static_cast<int>(std::ceil(border_m / out.cell_m)));
  out.origin = map.origin + out.cell_m * Vec2(left - border, low - border);
  out.columns = right - left + 2 * border;
  out.rows = high - low + 2 * border;
  out.cells.assign(static_cast<std::size_t>(out.columns) * out.rows, Cell::kUnknown);
  for (int row = low; row < high; ++row) {
    const auto from = all.cells.begin() + static_cast<std::ptrdiff_t>(row) * blocks_wide;
    std::copy(
        from + left, from + right,
        out.cells.begin() + static_cast<std::ptrdiff_t>(row - low + border) * out.columns + border);
  }
  return out;
}

}  // namespace panoptes
