// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/obstacles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

constexpr double kIndexCell_m = 0.5;    // about the size of furniture
constexpr double kRegionCell_m = 0.05;  // the narrowest aisle is ten times as wide
constexpr double kMostRegionCells = 16e6;

int cells_over(double length, double cell) {
  return std::max(1, static_cast<int>(std::ceil(length / cell)));
}

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

Vec2 nearest_on_segment(const Vec2& a, const Vec2& b, const Vec2& p) {
  const Vec2 along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return a + t * along;
}

}  // namespace

Nearest nearest_on(const Outline& outline, const Vec2& p_scene) {
  const std::vector<Vec2>& corners = outline.corners_scene;
  Nearest best{&outline, std::numeric_limits<double>::infinity(), p_scene};
  bool left = false;
  bool right = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2& a = corners[i];
    const Vec2& b = corners[(i + 1) % corners.size()];
    const double side = cross(b - a, p_scene - a);
    left = left || side > 0;
    right = right || side < 0;
    const Vec2 q = nearest_on_segment(a, b, p_scene);
    const double distance_m = (p_scene - q).norm();
    if (distance_m < best.distance_m) {
      best.distance_m = distance_m;
      best.p_scene = q;
    }
  }
  if (left != right && corners.size() > 2) {
    best.distance_m = 0;
    best.p_scene = p_scene;
  }
  return best;
}

Obstacles::Obstacles(std::vector<Outline> outlines) : outlines_(std::move(outlines)) {
  if (outlines_.empty()) {
    return;
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  low_ = Vec2::Constant(kInfinity);
  high_ = Vec2::Constant(-kInfinity);
  for (const Outline& outline : outlines_) {
    PANOPTES_CHECK(!outline.corners_scene.empty(), "an outline has corners");
    for (const Vec2& corner : outline.corners_scene) {
      low_ = low_.cwiseMin(corner);
      high_ = high_.cwiseMax(corner);
    }
  }
  by_cell_.cell_m = kIndexCell_m;
  by_cell_.origin = low_;
  by_cell_.assign(cells_over(high_.x() - low_.x(), kIndexCell_m),
                  cells_over(high_.y() - low_.y(), kIndexCell_m));
  const auto column_of = [this](const Vec2& p) {
    return std::clamp(by_cell_.column(p), 0, by_cell_.columns - 1);
  };
  const auto row_of = [this](const Vec2& p) {
    return std::clamp(by_cell_.row(p), 0, by_cell_.rows - 1);
  };
  for (std::size_t i = 0; i < outlines_.size(); ++i) {
    Vec2 low = Vec2::Constant(kInfinity);
    Vec2 high = Vec2::Constant(-kInfinity);
    for (const Vec2& corner : outlines_[i].corners_scene) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    const int last_row = row_of(high);
    const int last_column = column_of(high);
    for (int row = row_of(low); row <= last_row; ++row) {
      for (int column = column_of(low); column <= last_column; ++column) {
        by_cell_(column, row).push_back(static_cast<int>(i));
      }
    }
  }
}

std::optional<Nearest> Obstacles::nearest(const Vec2& p_scene, double within_m) const {
  std::optional<Nearest> best;
  if (outlines_.empty()) {
    return best;
  }
  // Rings of cells around the point's own; whatever lies beyond ring k is at least k cells away.
  const int column = by_cell_.column(p_scene);
  const int row = by_cell_.row(p_scene);
  const int rings = std::max({std::abs(column), std::abs(by_cell_.columns - 1 - column),
                              std::abs(row), std::abs(by_cell_.rows - 1 - row)});
  for (int ring = 0; ring <= rings; ++ring) {
    const double beyond_m = (ring - 1) * kIndexCell_m;
    if (beyond_m > within_m || (best && best->distance_m <= beyond_m)) {
      break;
    }
    for (int r = std::max(0, row - ring); r <= std::min(by_cell_.rows - 1, row + ring); ++r) {
      const bool whole_row = std::abs(r - row) == ring;
      for (int c = column - ring; c <= column + ring; c += whole_row || ring == 0 ? 1 : 2 * ring) {
        if (c < 0 || c >= by_cell_.columns) {
          continue;
        }
        for (const int i : by_cell_(c, r)) {
          const Nearest found = nearest_on(outlines_[static_cast<std::size_t>(i)], p_scene);
          if (found.distance_m <= within_m && (!best || found.distance_m < best->distance_m)) {
            best = found;
          }
        }
      }
    }
  }
  return best;
}

FreeRegion::FreeRegion(const Obstacles& obstacles, double radius_m)
    : FreeRegion(obstacles, radius_m, obstacles.low_scene(), obstacles.high_scene()) {}

FreeRegion::FreeRegion(const Obstacles& obstacles, double radius_m, const Vec2& low_scene,
                       const Vec2& high_scene) {
  inside_.cell_m =
      std::max(kRegionCell_m, std::sqrt((high_scene - low_scene).prod() / kMostRegionCells));
  inside_.origin = low_scene;
  inside_.assign(cells_over(high_scene.x() - low_scene.x(), inside_.cell_m),
                 cells_over(high_scene.y() - low_scene.y(), inside_.cell_m));
  const std::size_t cells = inside_.size();
  std::vector<int> region(cells, -1);  // -1: not free; 0: free; else the region's number
  for (int row = 0; row < inside_.rows; ++row) {
    for (int column = 0; column < inside_.columns; ++column) {
      if (!obstacles.nearest(inside_.centre(column, row), radius_m)) {
        region[inside_.index(column, row)] = 0;
      }
    }
  }
  int regions = 0;
  int largest = 0;
  std::size_t largest_cells = 0;
  std::vector<std::size_t> open;
  const std::size_t width = static_cast<std::size_t>(inside_.columns);
  for (std::size_t seed = 0; seed < cells; ++seed) {
    if (region[seed] != 0) {
      continue;
    }
    ++regions;
    std::size_t size = 0;
    region[seed] = regions;
    open.push_back(seed);
    while (!open.empty()) {
      const std::size_t at = open.back();
      open.pop_back();
      ++size;
      const auto visit = [&](std::size_t next) {
        if (region[next] == 0) {
          region[next] = regions;
          open.push_back(next);
        }
      };
      if (at % width > 0) visit(at - 1);
      if (at % width + 1 < width) visit(at + 1);
      if (at >= width) visit(at - width);
      if (at + width < cells) visit(at + width);
    }
    if (size > largest_cells) {
      largest = regions;
      largest_cells = size;
    }
  }
  for (std::size_t i = 0; i < cells; ++i) {
    inside_.cells[i] = largest > 0 && region[i] == largest ? 1 : 0;
  }
}

double FreeRegion::area_m2() const {
  return inside_.cell_m * inside_.cell_m *
         static_cast<double>(std::count(inside_.cells.begin(), inside_.cells.end(), char{1}));
}

}  // namespace panoptes::sim
