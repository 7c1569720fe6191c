// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace panoptes {
namespace {

TruthLayer empty_like(const TruthLayer& layer) {
  TruthLayer copy{layer.cell_m, layer.origin, layer.columns, layer.rows, {}};
  copy.cells.assign(copy.size(), 0);
  return copy;
}

/// From each cell's centre to the centre of the nearest set one, in cells; far when none is set.
cv::Mat distance_to_set(const TruthLayer& layer) {
  if (std::find(layer.cells.begin(), layer.cells.end(), 1) == layer.cells.end()) {
    return {layer.rows, layer.columns, CV_32F, cv::Scalar(std::numeric_limits<float>::max())};
  }
  cv::Mat clear(layer.rows, layer.columns, CV_8U);
  for (int row = 0; row < layer.rows; ++row) {
    for (int column = 0; column < layer.columns; ++column) {
      clear.at<unsigned char>(row, column) = layer(column, row) != 0 ? 0 : 1;
    }
  }
  cv::Mat distance;
  cv::distanceTransform(clear, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance;
}

void check_layer(const TruthLayer& layer) {
  PANOPTES_CHECK(layer.cells.size() == layer.size(), "a layer has a value for every cell");
}

/// Where the layer has floor, with a border of so many cells where there is none. Its outermost
/// cells lie around the world.
TruthLayer floor_within(const TruthLayer& layer, int border) {
  constexpr int kAround = 2;
  TruthLayer grown;
  grown.cell_m = layer.cell_m;
  grown.origin = layer.origin - Vec2::Constant(border * layer.cell_m);
  grown.assign(layer.columns + 2 * border, layer.rows + 2 * border);
  for (int row = kAround; row < layer.rows - kAround; ++row) {
    for (int column = kAround; column < layer.columns - kAround; ++column) {
      grown(column + border, row + border) = layer(column, row) == 0 ? 1 : 0;
    }
  }
  return grown;
}

/// The centres of the map's free cells of so many squares a side.
std::vector<Vec2> free_centres(const OccupancyMap& map, int side) {
  std::vector<Vec2> centres;
  for (int row = 0; row < map.rows; row += side) {
    for (int column = 0; column < map.columns; column += side) {
      int free = 0;
      for (int i = 0; i < side * side; ++i) {
        free += map.at(column + i % side, row + i / side) == Cell::kFree ? 1 : 0;
      }
      if (2 * free > side * side) {
        centres.push_back(map.point(column + side / 2.0, row + side / 2.0));
      }
    }
  }
  return centres;
}

constexpr std::array<std::pair<int, int>, 4> kBeside = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

}  // namespace

TruthLayer reachable_floor(const TruthLayer& body, const Vec2& start_scene, double radius_m) {
  check_layer(body);
  TruthLayer reachable = empty_like(body);
  const cv::Mat distance = distance_to_set(body);
  // a set cell begins half a cell before its centre
  const auto fits = [&](int column, int row) {
    return body.contains(column, row) &&
           (static_cast<double>(distance.at<float>(row, column)) - 0.5) * body.cell_m >= radius_m;
  };
  const int reach = static_cast<int>(std::ceil(radius_m / body.cell_m));
  const int column0 = body.column(start_scene);
  const int row0 = body.row(start_scene);
  double nearest_m = std::numeric_limits<double>::max();
  std::pair<int, int> seed{-1, -1};
  for (int row = row0 - reach; row <= row0 + reach; ++row) {
    for (int column = column0 - reach; column <= column0 + reach; ++column) {
      const double away_m = std::hypot(column - column0, row - row0) * body.cell_m;
      if (away_m < nearest_m && away_m <= radius_m && fits(column, row)) {
        nearest_m = away_m;
        seed = {column, row};
      }
    }
  }
  if (seed.first < 0) {
    return reachable;
  }
  cv::Mat1b open(body.rows, body.columns);
  for (int row = 0; row < body.rows; ++row) {
    for (int column = 0; column < body.columns; ++column) {
      open(row, column) = fits(column, row) ? 1 : 0;
    }
  }
  constexpr int kReached = 2;
  cv::floodFill(open, cv::Point(seed.first, seed.second), kReached);
  std::transform(open.begin(), open.end(), reachable.cells.begin(),
                 [](std::uint8_t cell) { return static_cast<std::uint8_t>(cell == kReached); });
  return reachable;
}

double area_m2(const TruthLayer& layer) { return layer.area_m2(1); }

std::optional<double> coverage(const TruthLayer& reachable, const OccupancyMap& map,
                               const Pose2& T_scene_map) {
  check_layer(reachable);
  const Pose2 T_map_scene = T_scene_map.inverse();
  long long cells = 0;
  long long free = 0;
  for (int row = 0; row < reachable.rows; ++row) {
    for (int column = 0; column < reachable.columns; ++column) {
      if (reachable(column, row) != 0) {
        ++cells;
        free += map.at(T_map_scene * reachable.centre(column, row)) == Cell::kFree ? 1 : 0;
      }
    }
  }
  if (cells == 0) {
    return std::nullopt;
  }
  return static_cast<double>(free) / static_cast<double>(cells);
}

MapQuality map_quality(const Truth& truth, const OccupancyMap& map, const Pose2& T_scene_map) {
  const TruthLayer& floor = truth.floor;
  const TruthLayer& seen = truth.seen;
  check_layer(floor);
  check_layer(seen);
  MapQuality quality;
  if (floor.cells.empty() || seen.cells.empty()) {
    return quality;
  }
  // the map's occupied squares on the grid of the floor layer, to measure distances there
  const Pose2 T_map_scene = T_scene_map.inverse();
  TruthLayer occupied = empty_like(floor);
  TruthLayer free = empty_like(floor);
  for (int row = 0; row < floor.rows; ++row) {
    for (int column = 0; column < floor.columns; ++column) {
      const Cell cell = map.at(T_map_scene * floor.centre(column, row));
      occupied(column, row) = cell == Cell::kOccupied ? 1 : 0;
      free(column, row) = cell == Cell::kFree ? 1 : 0;
    }
  }
  const cv::Mat to_occupied = distance_to_set(occupied);
  constexpr double kFound_m = 0.05;
  const double found_cells = kFound_m / floor.cell_m + 1e-6;  // of centres on one grid: roundoff

  long long both = 0;
  long long either = 0;
  long long mapped_free = 0;
  long long boundary = 0;
  long long found = 0;
  const int side = static_cast<int>(std::lround(seen.cell_m / floor.cell_m));
  for (int row = 0; row < seen.rows; ++row) {
    for (int column = 0; column < seen.columns; ++column) {
      if (seen(column, row) == 0) {
        continue;
      }
      ++quality.cells;
      const Vec2 corner_scene = seen.point(column, row);
      const int column0 =
          static_cast<int>(std::lround((corner_scene.x() - floor.origin.x()) / floor.cell_m));
      const int row0 =
          static_cast<int>(std::lround((corner_scene.y() - floor.origin.y()) / floor.cell_m));
      int squares_clear = 0;
      int squares_free = 0;
      bool on_boundary = false;
      bool is_found = false;
      for (int y = row0; y < row0 + side; ++y) {
        for (int x = column0; x < column0 + side; ++x) {
          if (!floor.contains(x, y)) {
            continue;
          }
          squares_free += free(x, y);
          if (floor(x, y) == 0) {
            ++squares_clear;
            continue;
          }
          const bool edge = std::any_of(kBeside.begin(), kBeside.end(), [&](const auto& beside) {
            const int nx = x + beside.first;
            const int ny = y + beside.second;
            return floor.contains(nx, ny) && floor(nx, ny) == 0;
          });
          on_boundary = on_boundary || edge;
          is_found = is_found || (edge && to_occupied.at<float>(y, x) <= found_cells);
        }
      }
      const bool truly_free = 2 * squares_clear > side * side;
      const bool called_free = 2 * squares_free > side * side;
      both += truly_free && called_free ? 1 : 0;
      either += truly_free || called_free ? 1 : 0;
      mapped_free += called_free ? 1 : 0;
      boundary += on_boundary ? 1 : 0;
      found += is_found ? 1 : 0;
    }
  }
  const auto share = [](long long part, long long whole) -> std::optional<double> {
    if (whole == 0) {
      return std::nullopt;
    }
    return static_cast<double>(part) / static_cast<double>(whole);
  };
  quality.free_iou = share(both, either);
  quality.free_precision = share(both, mapped_free);
  quality.obstacle_recall = share(found, boundary);
  return quality;
}

std::optional<Leak> leak(const TruthLayer& floor, const OccupancyMap& map,
                         const Pose2& T_scene_map) {
  check_layer(floor);
  if (floor.cells.empty()) {
    return std::nullopt;
  }
  constexpr double kNear_m = 0.10;
  const double near_cells = kNear_m / floor.cell_m + 1e-6;  // of centres on one grid: roundoff
  const TruthLayer grown = floor_within(floor, static_cast<int>(std::ceil(near_cells)));
  const cv::Mat to_floor = distance_to_set(grown);
  const auto is_leaked = [&](const Vec2& p_map) {
    const Vec2 p_scene = T_scene_map * p_map;
    const int column = grown.column(p_scene);
    const int row = grown.row(p_scene);
    return !grown.contains(column, row) ||
           static_cast<double>(to_floor.at<float>(row, column)) > near_cells;
  };
  constexpr double kCell_m = 0.05;
  const int side = std::max(1, static_cast<int>(std::lround(kCell_m / map.cell_m)));
  const double side_m = side * map.cell_m;
  const std::vector<Vec2> free = free_centres(map, side);
  Leak found;
  found.area_m2 =
      static_cast<double>(std::count_if(free.begin(), free.end(), is_leaked)) * side_m * side_m;
  if (const double free_m2 = map.area_m2(Cell::kFree); free_m2 > 0) {
    found.share = found.area_m2 / free_m2;
  }
  return found;
}

std::optional<double> time_of_coverage_s(const std::vector<CoverageSample>& samples, double share) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].coverage || *samples[i].coverage < share) {
      continue;
    }
    const double t_s = to_seconds(samples[i].stamp);
    if (i == 0 || !samples[i - 1].coverage) {
      return t_s;
    }
    const double t0_s = to_seconds(samples[i - 1].stamp);
    const double c0 = *samples[i - 1].coverage;
    return t0_s + (t_s - t0_s) * (share - c0) / (*samples[i].coverage - c0);
  }
  return std::nullopt;
}

}  // namespace panoptes
