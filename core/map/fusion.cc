// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/fusion.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/error.h"

namespace panoptes {
namespace {

// A cell is called free or occupied once a nat speaks for it (eighths of a nat, per grid cell).
constexpr int kDecided = 8;

constexpr int kBlock = 128;  // the lattice grows by whole blocks

constexpr double kFarthest_cells = 1e9;  // sums of two stay in 32 bits

int to_cell(double p, double cell_m) { return static_cast<int>(std::floor(p / cell_m)); }

ConfigError too_large(const Vec2& size_m, double cell_m) {
  return ConfigError("the map would reach over " + std::to_string(std::llround(size_m.x())) +
                     " x " + std::to_string(std::llround(size_m.y())) +
                     " m, too far for its cells of " + std::to_string(std::llround(cell_m * 1000)) +
                     " mm; is the robot's odometry right?");
}

struct Bounds {
  Vec2 low = Vec2::Zero();
  Vec2 high = Vec2::Zero();
};

// Of a crop's cells in its own frame, and of the same when placed.
Bounds own_bounds(const GridCrop& grid) {
  int begin = 0;
  int end = 0;
  bool any = false;
  for (const GridCrop::Row& row : grid.rows) {
    if (row.begin < row.end) {
      begin = any ? std::min(begin, row.begin) : row.begin;
      end = any ? std::max(end, row.end) : row.end;
      any = true;
    }
  }
  Bounds bounds{grid.cell_m * Vec2(begin, grid.first_row),
                grid.cell_m * Vec2(end, grid.first_row + static_cast<int>(grid.rows.size()))};
  for (const Vec2& p : grid.traversed) {
    bounds.low = bounds.low.cwiseMin(p - Vec2::Constant(grid.body_radius_m));
    bounds.high = bounds.high.cwiseMax(p + Vec2::Constant(grid.body_radius_m));
  }
  return bounds;
}

Bounds placed_bounds(const Bounds& own, const Pose2& T_map_keyframe) {
  Bounds out{T_map_keyframe * own.low, T_map_keyframe * own.low};
  for (const Vec2& corner :
       {own.high, Vec2(own.low.x(), own.high.y()), Vec2(own.high.x(), own.low.y())}) {
    const Vec2 p = T_map_keyframe * corner;
    out.low = out.low.cwiseMin(p);
    out.high = out.high.cwiseMax(p);
  }
  return out;
}

constexpr int kShift = 16;
constexpr double kOne = 1 << kShift;

// Calls each(column, row, evidence) with map cells and what the grid says there. The sums that
// add() and subtract() make of it cancel exactly, for it depends on the grid and its pose alone.
template <class Each>
void for_each_contribution(const PlacedGrid& placed, double cell_m, const Each& each) {
  const GridCrop& grid = *placed.grid;
  const Pose2& T = placed.T_map_keyframe;
  const double c = std::cos(T.theta_rad);
  const double s = std::sin(T.theta_rad);
  if (cell_m >= 1.5 * grid.cell_m) {
    // every grid cell goes to the coarser map cell its centre falls into
    const double scale = grid.cell_m / cell_m;
    const auto step_x = static_cast<std::int64_t>(std::llround(c * scale * kOne));
    const auto step_y = static_cast<std::int64_t>(std::llround(s * scale * kOne));
    for (std::size_t r = 0; r < grid.rows.size(); ++r) {
      const GridCrop::Row& row = grid.rows[r];
      const Vec2 start =
          T * (grid.cell_m * Vec2(row.begin + 0.5, grid.first_row + static_cast<int>(r) + 0.5));
      auto x = static_cast<std::int64_t>(std::floor(start.x() / cell_m * kOne));
      auto y = static_cast<std::int64_t>(std::floor(start.y() / cell_m * kOne));
      const std::int8_t* cell = grid.cells.data() + row.offset;
      for (int k = row.begin; k < row.end; ++k, ++cell, x += step_x, y += step_y) {
        if (*cell != 0) {
          each(static_cast<int>(x >> kShift), static_cast<int>(y >> kShift), *cell);
        }
      }
    }
    return;
  }
  // every map cell takes what the grid says under its centre, so that none is left out
  const Bounds own = own_bounds(grid);
  const Bounds bounds = placed_bounds(own, T);
  const double scale = cell_m / grid.cell_m;
  const auto step_x = static_cast<std::int64_t>(std::llround(c * scale * kOne));
  const auto step_y = static_cast<std::int64_t>(std::llround(-s * scale * kOne));
  const Pose2 T_keyframe_map = T.inverse();
  const int grid_rows = static_cast<int>(grid.rows.size());
  // the part of a map row that lies within the grid's rectangle
  const auto narrow = [](double at, double step, double low, double high, int& begin, int& end) {
    if (std::abs(step) < 1e-9) {
      if (at < low - 1 || at > high + 1) {
        end = begin;
      }
      return;
    }
    const double first = (low - at) / step;
    const double second = (high - at) / step;
    const double count = end - begin;
    end = begin + static_cast<int>(std::clamp(std::ceil(std::max(first, second)) + 2, 0.0, count));
    begin += static_cast<int>(std::clamp(std::floor(std::min(first, second)) - 1, 0.0, count));
  };
  const int low_column = to_cell(bounds.low.x(), cell_m);
  const int high_column = to_cell(bounds.high.x(), cell_m) + 1;
  for (int row = to_cell(bounds.low.y(), cell_m); row <= to_cell(bounds.high.y(), cell_m); ++row) {
    const Vec2 start = T_keyframe_map * (cell_m * Vec2(low_column + 0.5, row + 0.5)) / grid.cell_m;
    int begin = low_column;
    int end = high_column;
    narrow(start.x(), c * scale, own.low.x() / grid.cell_m, own.high.x() / grid.cell_m, begin, end);
    int begin_y = low_column;
    int end_y = high_column;
    narrow(start.y(), -s * scale, own.low.y() / grid.cell_m, own.high.y() / grid.cell_m, begin_y,
           end_y);
    begin = std::max(begin, begin_y);
    end = std::min(end, end_y);
    std::int64_t x =
        static_cast<std::int64_t>(std::floor(start.x() * kOne)) + step_x * (begin - low_column);
    std::int64_t y =
        static_cast<std::int64_t>(std::floor(start.y() * kOne)) + step_y * (begin - low_column);
    for (int column = begin; column < end; ++column, x += step_x, y += step_y) {
      const int r = static_cast<int>(y >> kShift) - grid.first_row;
      if (static_cast<unsigned>(r) >= static_cast<unsigned>(grid_rows)) {
        continue;
      }
      const GridCrop::Row& grid_row = grid.rows[static_cast<std::size_t>(r)];
      const int k = static_cast<int>(x >> kShift);
      if (k < grid_row.begin || k >= grid_row.end) {
        continue;
      }
      const std::int8_t v =
          grid.cells[grid_row.offset + static_cast<std::size_t>(k - grid_row.begin)];
      if (v != 0) {
        each(column, row, v);
      }
    }
  }
}

}  // namespace

EvidenceSum::EvidenceSum(double cell_m, Traversed traversed)
    : traversed_(traversed), sums_(cell_m, kBlock) {
  PANOPTES_CHECK(cell_m > 0, "a map has cells of some size");
}

void EvidenceSum::reserve(const CellBox& asked) {
  const CellBox to = sums_.grown(asked);
  if (static_cast<double>(to.columns()) * to.rows() > kMostCells) {
    throw too_large(cell_m() * Vec2(to.columns(), to.rows()), cell_m());
  }
  sums_.reserve(asked);
}

template <int kSign>
void EvidenceSum::apply(const PlacedGrid& placed) {
  PANOPTES_CHECK(placed.grid != nullptr, "a placed grid is there");
  if (placed.grid->rows.empty() && placed.grid->traversed.empty()) {
    return;
  }
  finer_m_ = placed.grid->cell_m;
  const Bounds bounds = placed_bounds(own_bounds(*placed.grid), placed.T_map_keyframe);
  const Vec2 farthest = bounds.low.cwiseAbs().cwiseMax(bounds.high.cwiseAbs());
  const double cell_m = this->cell_m();
  if (!farthest.allFinite() || farthest.maxCoeff() >= kFarthest_cells * cell_m) {
    throw too_large(farthest, cell_m);
  }
  reserve({to_cell(bounds.low.x(), cell_m) - 1, to_cell(bounds.low.y(), cell_m) - 1,
           to_cell(bounds.high.x(), cell_m) + 2, to_cell(bounds.high.y(), cell_m) + 2});
  Sum* sums = sums_.data();
  const CellBox box = sums_.box();
  for_each_contribution(placed, cell_m, [=](int column, int row, int evidence) {
    Sum& sum = sums[box.index(column, row)];
    if (evidence > 0) {
      sum.free += kSign * evidence;
    } else {
      sum.occupied -= kSign * evidence;
    }
  });
  if (traversed_ == Traversed::kFree) {
    drive_over(placed, kSign);
  }
}

// Cells that lie wholly under the body, so that nothing beside it is taken for floor.
void EvidenceSum::drive_over(const PlacedGrid& placed, int sign) {
  const double radius = placed.grid->body_radius_m / cell_m();
  for (const Vec2& p_keyframe : placed.grid->traversed) {
    const Vec2 p = placed.T_map_keyframe * p_keyframe / cell_m();
    for (int row = static_cast<int>(std::floor(p.y() - radius)); row < p.y() + radius; ++row) {
      const double dy = std::max(p.y() - row, row + 1 - p.y());
      if (dy >= radius) {
        continue;
      }
      const double half = std::sqrt(radius * radius - dy * dy);
      const int begin = static_cast<int>(std::ceil(p.x() - half));
      const int end = static_cast<int>(std::floor(p.x() + half));
      for (int column = begin; column < end; ++column) {
        sums_(column, row).traversed += sign;
      }
    }
  }
}

void EvidenceSum::add(const PlacedGrid& placed) { apply<1>(placed); }
void EvidenceSum::subtract(const PlacedGrid& placed) { apply<-1>(placed); }

Cell EvidenceSum::verdict(const Sum& sum, int parts) {
  if (sum.traversed > 0) {
    return Cell::kFree;
  }
  // A wall one grid cell thick fills one of `parts` grid cells of a coarser cell, so its
  // evidence counts that much more; half of the cell's floor must have been seen to call it free.
  const std::int64_t occupied = static_cast<std::int64_t>(sum.occupied) * parts;
  const std::int64_t decided = static_cast<std::int64_t>(kDecided) * parts * parts;
  if (occupied > sum.free) {
    return occupied - sum.free >= decided ? Cell::kOccupied : Cell::kUnknown;
  }
  return 2 * (sum.free - occupied) >= decided * (parts > 1 ? 1 : 2) ? Cell::kFree : Cell::kUnknown;
}

Cell EvidenceSum::at(int column, int row) const {
  return verdict(sums_.at(column, row), parts_a_side(cell_m(), finer_m_));
}

OccupancyMap EvidenceSum::map() const {
  const CellBox& box = sums_.box();
  CellBox used{box.end_column, box.end_row, box.low_column, box.low_row};
  for (int row = box.low_row; row < box.end_row; ++row) {
    const Sum* sum = sums_.row(row);
    for (int column = box.low_column; column < box.end_column; ++column, ++sum) {
      if (sum->free != 0 || sum->occupied != 0 || sum->traversed != 0) {
        used.low_column = std::min(used.low_column, column);
        used.low_row = std::min(used.low_row, row);
        used.end_column = std::max(used.end_column, column + 1);
        used.end_row = row + 1;
      }
    }
  }
  if (used.rows() <= 0) {
    OccupancyMap none;
    none.cell_m = cell_m();
    return none;
  }
  return map(cell_m() * Vec2(used.low_column, used.low_row),
             cell_m() * Vec2(used.end_column, used.end_row));
}

OccupancyMap EvidenceSum::map(const Vec2& low, const Vec2& high) const {
  // corners that lie on the lattice stay there, whichever way their product was rounded
  const auto down = [this](double p) { return static_cast<int>(std::floor(p / cell_m() + 1e-6)); };
  const auto up = [this](double p) { return static_cast<int>(std::ceil(p / cell_m() - 1e-6)); };
  const CellBox window{down(low.x()), down(low.y()), up(high.x()), up(high.y())};
  OccupancyMap out;
  out.cell_m = cell_m();
  out.origin = cell_m() * Vec2(window.low_column, window.low_row);
  out.assign(std::max(0, window.columns()), std::max(0, window.rows()));
  const CellBox& box = sums_.box();
  const int begin = std::max(window.low_column, box.low_column);
  const int end = std::min(window.end_column, box.end_column);
  if (begin >= end) {
    return out;
  }
  const int parts = parts_a_side(cell_m(), finer_m_);
  for (int row = std::max(window.low_row, box.low_row); row < std::min(window.end_row, box.end_row);
       ++row) {
    const Sum* sum = sums_.row(row) + (begin - box.low_column);
    Cell* cell = &out.cells[out.index(begin - window.low_column, row - window.low_row)];
    for (int column = begin; column < end; ++column, ++sum, ++cell) {
      *cell = verdict(*sum, parts);
    }
  }
  return out;
}

GlobalMap::GlobalMap(double cell_m) : sum_(cell_m) {}

int GlobalMap::add(std::shared_ptr<const GridCrop> grid, const Pose2& T_map_keyframe) {
  fused_.push_back({std::move(grid), T_map_keyframe});
  wanted_.push_back(T_map_keyframe);
  sum_.add(fused_.back());
  return static_cast<int>(fused_.size()) - 1;
}

void GlobalMap::replace(int keyframe, std::shared_ptr<const GridCrop> grid) {
  PlacedGrid& placed = fused_[static_cast<std::size_t>(keyframe)];
  sum_.subtract(placed);
  placed.grid = std::move(grid);
  sum_.add(placed);
}

OccupancyMap GlobalMap::map_with(const PlacedGrid& open) {
  sum_.add(open);
  OccupancyMap with = sum_.map();
  sum_.subtract(open);
  return with;
}

void GlobalMap::move(std::span<const Pose2> T_map_keyframes) {
  PANOPTES_CHECK(T_map_keyframes.size() >= fused_.size(), "every keyframe has a pose");
  waiting_.clear();
  for (std::size_t i = 0; i < fused_.size(); ++i) {
    wanted_[i] = T_map_keyframes[i];
    const Pose2 T_was_is = fused_[i].T_map_keyframe.inverse() * wanted_[i];
    const Bounds own = own_bounds(*fused_[i].grid);
    const double reach = own.low.cwiseAbs().cwiseMax(own.high.cwiseAbs()).norm();
    const double half_cell = sum_.cell_m() / 2;
    if (T_was_is.position().norm() > half_cell ||
        std::abs(T_was_is.theta_rad) * reach > half_cell) {
      waiting_.push_back(static_cast<int>(i));
    }
  }
}

int GlobalMap::refuse(int keyframes_max) {
  const auto count =
      std::min(waiting_.size(), static_cast<std::size_t>(std::max(0, keyframes_max)));
  for (std::size_t k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(waiting_[k]);
    sum_.subtract(fused_[i]);
    fused_[i].T_map_keyframe = wanted_[i];
    sum_.add(fused_[i]);
  }
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
  return waiting();
}

OccupancyMap fuse(std::span<const PlacedGrid> grids, double cell_m) {
  Bounds all;
  bool any = false;
  for (const PlacedGrid& grid : grids) {
    if (!grid.grid->rows.empty() || !grid.grid->traversed.empty()) {
      const Bounds one = placed_bounds(own_bounds(*grid.grid), grid.T_map_keyframe);
      all = any ? Bounds{all.low.cwiseMin(one.low), all.high.cwiseMax(one.high)} : one;
      any = true;
    }
  }
  const auto cells = [&all](double size_m) {  // whole blocks, and what reserve() leaves around
    const Vec2 sides = ((all.high - all.low) / size_m).array() + 2 * kBlock + 4;
    return sides.x() * sides.y();
  };
  while (cells(cell_m) > kMostCells) {
    cell_m *= 2;
  }
  EvidenceSum sum(cell_m);
  for (const PlacedGrid& grid : grids) {
    sum.add(grid);
  }
  return sum.map();
}

LocalMap::LocalMap(double cell_m, double half_width_m, int keyframes)
    : half_width_m_(half_width_m), keep_(keyframes), sum_(cell_m, Traversed::kAsSeen) {
  PANOPTES_CHECK(half_width_m > 0 && keyframes >= 0, "a window has a size");
}

void LocalMap::close(std::shared_ptr<const GridCrop> grid, const Pose2& T_odom_keyframe) {
  closed_.push_back({std::move(grid), T_odom_keyframe});
  if (static_cast<int>(closed_.size()) > keep_) {
    closed_.erase(closed_.begin());
  }
  // made anew, so that it stays as large as the window and not as the path driven
  sum_ = EvidenceSum(sum_.cell_m(), Traversed::kAsSeen);
  for (const PlacedGrid& placed : closed_) {
    sum_.add(placed);
  }
}

void LocalMap::replace(const std::shared_ptr<const GridCrop>& grid,
                       std::shared_ptr<const GridCrop> by) {
  for (PlacedGrid& placed : closed_) {
    if (placed.grid == grid) {
      sum_.subtract(placed);
      placed.grid = by;
      sum_.add(placed);
    }
  }
}

OccupancyMap LocalMap::map(const KeyframeGrid& open, const Pose2& T_odom_open,
                           const Vec2& robot_odom) {
  const PlacedGrid placed{std::make_shared<GridCrop>(open.crop()), T_odom_open};
  sum_.add(placed);
  const Vec2 half = Vec2::Constant(half_width_m_);
  OccupancyMap out = sum_.map(robot_odom - half, robot_odom + half);
  sum_.subtract(placed);
  return out;
}

}  // namespace panoptes
