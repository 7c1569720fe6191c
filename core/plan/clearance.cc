// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/clearance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace panoptes {
namespace {

// Where nothing counts that is farther than so many cells, looking at all these for each cell is
// several times as fast as a transform that is exact at any distance.
constexpr int kNearCells = 30;

/// Squared distances in cells to the nearest cell that blocks, exact up to `reach` cells each way;
/// farther is kFar or some other square above that of `reach`. Columns first, then rows.
std::vector<std::uint16_t> near_squares(const std::vector<std::uint8_t>& blocks, int columns,
                                        int rows, int reach) {
  constexpr std::uint16_t kFar = 0x3fff;
  const auto width = static_cast<std::size_t>(columns);
  const auto beyond = static_cast<std::uint16_t>(reach + 1);
  std::vector<std::uint16_t> along(blocks.size());  // its column, in cells
  const auto sweep = [&](std::size_t row, const std::uint16_t* before) {
    std::uint16_t* here = &along[row * width];
    for (std::size_t x = 0; x < width; ++x) {
      const auto next = static_cast<std::uint16_t>(before[x] + 1);
      here[x] = std::min(here[x], next);
    }
  };
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    along[i] = blocks[i] != 0 ? std::uint16_t{0} : beyond;
  }
  const auto count = static_cast<std::size_t>(rows);
  for (std::size_t row = 1; row < count; ++row) {
    sweep(row, &along[(row - 1) * width]);
  }
  for (std::size_t row = count - 1; row > 0; --row) {
    sweep(row - 1, &along[row * width]);
  }
  // A row with what lies beyond its ends.
  std::vector<std::uint16_t> padded(width + 2 * static_cast<std::size_t>(reach), kFar);
  std::vector<std::uint16_t> squares(blocks.size(), kFar);
  for (std::size_t row = 0; row < count; ++row) {
    bool any = false;
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint16_t cells = along[row * width + x];
      const bool is_near = cells < beyond;
      any = any || is_near;
      padded[static_cast<std::size_t>(reach) + x] =
          is_near ? static_cast<std::uint16_t>(cells * cells) : kFar;
    }
    if (!any) {
      continue;
    }
    std::uint16_t* here = &squares[row * width];
    for (int aside = -reach; aside <= reach; ++aside) {
      const std::uint16_t* from = &padded[static_cast<std::size_t>(reach + aside)];
      const auto square = static_cast<std::uint16_t>(aside * aside);
      for (std::size_t x = 0; x < width; ++x) {
        const auto there = static_cast<std::uint16_t>(from[x] + square);
        here[x] = std::min(here[x], there);
      }
    }
  }
  return squares;
}

}  // namespace

std::vector<float> distance_m(const std::vector<std::uint8_t>& blocks, int columns, int rows,
                              double cell_m, double cap_m) {
  PANOPTES_CHECK(blocks.size() == static_cast<std::size_t>(columns) * rows,
                 "a value for every cell");
  const auto cell = static_cast<float>(cell_m);
  const auto cap = static_cast<float>(cap_m);
  if (cap_m < kNearCells * cell_m && !blocks.empty()) {
    const int reach = static_cast<int>(std::ceil(cap_m / cell_m)) + 1;
    const std::vector<std::uint16_t> squares = near_squares(blocks, columns, rows, reach);
    std::vector<float> far_m(squares.size());
    std::transform(squares.begin(), squares.end(), far_m.begin(), [&](std::uint16_t square) {
      return std::min(cap, cell * std::sqrt(static_cast<float>(square)));
    });
    return far_m;
  }
  cv::Mat1b free(rows, columns);
  std::transform(blocks.begin(), blocks.end(), free.begin(),
                 [](std::uint8_t block) { return static_cast<std::uint8_t>(block == 0); });
  std::vector<float> d(blocks.size());
  cv::Mat1f distance(rows, columns, d.data());
  if (!d.empty()) {
    cv::distanceTransform(free, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  }
  for (float& v : d) {
    v = std::min(cap, cell * v);
  }
  return d;
}

ClearanceMap clearance_map(OccupancyMap map, double cap_m) {
  const std::size_t size = map.size();
  PANOPTES_CHECK(map.cells.size() == size, "a map has a value for every cell");
  std::vector<std::uint8_t> occupied(size);
  // A frame of one cell stands for the unknown outside.
  const int wide = map.columns + 2;
  std::vector<std::uint8_t> unknown(static_cast<std::size_t>(wide) * (map.rows + 2), 1);
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const std::size_t i = map.index(column, row);
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

double outline_clearance_m(const ClearanceMap& map, double radius_m, double unknown_nearer_m,
                           const Vec2& p) {
  const int column = map.column(p);
  const int row = map.row(p);
  if (!map.map.contains(column, row)) {
    return -radius_m;
  }
  const std::size_t i = map.index(column, row);
  return std::min<double>(map.to_occupied_m[i], map.to_unknown_m[i] + unknown_nearer_m) -
         0.5 * map.map.cell_m - radius_m;
}

OccupancyMap coarsen(const OccupancyMap& map, double cell_m, double border_m) {
  const int factor = parts_a_side(cell_m, map.cell_m);
  OccupancyMap all;
  all.cell_m = map.cell_m * factor;
  all.origin = map.origin;
  all.assign((map.columns + factor - 1) / factor, (map.rows + factor - 1) / factor);

  // The rectangle in which anything is known.
  int left = all.columns;
  int right = 0;
  int low = all.rows;
  int high = 0;
  for (int row = 0; row < all.rows; ++row) {
    for (int column = 0; column < all.columns; ++column) {
      const Cell cell = resampled(factor, [&](int part_column, int part_row) {
        return map.at(column * factor + part_column, row * factor + part_row);
      });
      if (cell == Cell::kUnknown) {
        continue;
      }
      all(column, row) = cell;
      left = std::min(left, column);
      right = std::max(right, column + 1);
      low = std::min(low, row);
      high = std::max(high, row + 1);
    }
  }
  OccupancyMap out;
  out.cell_m = all.cell_m;
  if (right <= left) {
    out.origin = map.origin;
    return out;
  }
  const int border = std::max(0, static_cast<int>(std::ceil(border_m / out.cell_m)));
  out.origin = all.point(left - border, low - border);
  out.assign(right - left + 2 * border, high - low + 2 * border);
  for (int row = low; row < high; ++row) {
    std::copy_n(&all(left, row), right - left, &out(border, row - low + border));
  }
  return out;
}

}  // namespace panoptes
