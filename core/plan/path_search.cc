// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/path_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDiagonal = 1.4142135623730951;

struct Neighbour {
  int column;
  int row;
  double length;
};
constexpr std::array<Neighbour, 8> kNeighbours = {{{1, 0, 1.0},
                                                   {-1, 0, 1.0},
                                                   {0, 1, 1.0},
                                                   {0, -1, 1.0},
                                                   {1, 1, kDiagonal},
                                                   {-1, 1, kDiagonal},
                                                   {1, -1, kDiagonal},
                                                   {-1, -1, kDiagonal}}};

/// The border of unknown cells that a search needs around a map: none is ever entered.
constexpr double kNoBorder_m = 0;

struct Open {
  double estimate;
  int cell;
  // Equal estimates in order of cell, so that the search never depends on the heap's inside.
  bool operator>(const Open& o) const {
    return estimate != o.estimate ? estimate > o.estimate : cell > o.cell;
  }
};

/// Dijkstra from `start`, or A* when there is a goal cell (it then stops there).
CostField search(const SearchOptions& options, const DrivableGrid& grid, const Vec2& start,
                 std::optional<int> goal) {
  const OccupancyMap& map = grid.clearance.map;
  CostField field;
  field.cost_m.assign(grid.clearance_m.size(), kInfinity);
  field.came_from.assign(grid.clearance_m.size(), -1);
  const int start_column = grid.clearance.column(start);
  const int start_row = grid.clearance.row(start);
  if (!map.contains(start_column, start_row)) {
    return field;
  }
  const int goal_column = goal ? *goal % map.columns : 0;
  const int goal_row = goal ? *goal / map.columns : 0;
  const auto estimate = [&](int column, int row) {
    if (!goal) {
      return 0.0;
    }
    const int dx = std::abs(column - goal_column);
    const int dy = std::abs(row - goal_row);
    return map.cell_m * (std::max(dx, dy) + (kDiagonal - 1) * std::min(dx, dy));
  };
  const auto start_cell = static_cast<int>(grid.clearance.index(start_column, start_row));
  std::vector<std::uint8_t> closed(grid.clearance_m.size(), 0);
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  field.cost_m[start_cell] = 0;
  open.push({estimate(start_column, start_row), start_cell});
  while (!open.empty()) {
    const int cell = open.top().cell;
    open.pop();
    if (closed[cell] != 0) {
      continue;
    }
    closed[cell] = 1;
    if (goal && cell == *goal) {
      break;
    }
    const int column = cell % map.columns;
    const int row = cell / map.columns;
    for (const Neighbour& n : kNeighbours) {
      const int to_column = column + n.column;
      const int to_row = row + n.row;
      if (!map.contains(to_column, to_row)) {
        continue;
      }
      const auto to = static_cast<int>(grid.clearance.index(to_column, to_row));
      if (closed[to] != 0) {
        continue;
      }
      const double clearance = grid.clearance_m[to];
      // Where there is too little room one may only climb out of it, never through an obstacle.
      if (clearance < 0 && (grid.clearance_m[cell] >= 0 || clearance < grid.clearance_m[cell] ||
                            map.cells[to] == Cell::kOccupied)) {
        continue;
      }
      const double lack = std::clamp(1.0 - clearance / options.inflation_distance_m, 0.0, 2.0);
      const double cost = field.cost_m[cell] +
                          map.cell_m * n.length * (1.0 + options.clearance_weight * lack * lack);
      if (cost < field.cost_m[to]) {
        field.cost_m[to] = cost;
        field.came_from[to] = cell;
        open.push({cost + estimate(to_column, to_row), to});
      }
    }
  }
  return field;
}

// About the cells that a finer map counts in.
struct Box {
  int low_column;
  int end_column;
  int low_row;
  int end_row;
};

Box box_of(const NearMap& near, const OccupancyMap& map) {
  const Vec2 low = near.robot_map - Vec2::Constant(near.within_m);
  const Vec2 high = near.robot_map + Vec2::Constant(near.within_m);
  return {std::clamp(map.column(low), 0, map.columns), std::clamp(map.column(high), 0, map.columns),
          std::clamp(map.row(low), 0, map.rows), std::clamp(map.row(high), 0, map.rows)};
}

bool counts(const NearMap& near, const OccupancyMap& map, int column, int row) {
  return (map.centre(column, row) - near.robot_map).squaredNorm() <= near.within_m * near.within_m;
}

struct Place {
  Vec2 p_map = Vec2::Zero();
  double clearance_m = -kInfinity;
};

// Of places spread evenly over a cell, about as far apart as the finer cells; among equals the one
// nearest to the cell's centre.
Place roomiest(const DrivableGrid& grid, int column, int row) {
  const NearMap& near = *grid.near;
  const OccupancyMap& map = grid.clearance.map;
  const Vec2 centre = map.centre(column, row);
  const double unknown_nearer_m =
      grid.through_unknown ? kInfinity : std::min(kUnknownNearer_m, grid.margin_m);
  const int side = parts_a_side(map.cell_m, near.window.map.cell_m);
  Place best;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const Vec2 p = map.point(column + (i + 0.5) / side, row + (j + 0.5) / side);
      const double clearance_m =
          outline_clearance_m(near.window, grid.radius_m, unknown_nearer_m, near.T_window_map * p) -
          grid.margin_m;
      if (clearance_m > best.clearance_m ||
          (clearance_m == best.clearance_m &&
           (p - centre).squaredNorm() < (best.p_map - centre).squaredNorm())) {
        best = {p, clearance_m};
      }
    }
  }
  return best;
}

// Lays what the finer map knows over the coarse one.
void lay_over(const NearMap& near, OccupancyMap& coarse) {
  const OccupancyMap& window = near.window.map;
  const int samples = parts_a_side(coarse.cell_m, window.cell_m);
  const double step_m = coarse.cell_m / samples;
  const Vec2 along_x = near.T_window_map.rotation() * Vec2(step_m, 0);
  const Vec2 along_y = near.T_window_map.rotation() * Vec2(0, step_m);
  const Box box = box_of(near, coarse);
  for (int row = box.low_row; row < box.end_row; ++row) {
    for (int column = box.low_column; column < box.end_column; ++column) {
      if (!counts(near, coarse, column, row)) {
        continue;
      }
      const Vec2 corner = near.T_window_map * coarse.point(column, row);
      const Cell cell = resampled(samples, [&](int i, int j) {
        return window.at(corner + (i + 0.5) * along_x + (j + 0.5) * along_y);
      });
      if (cell != Cell::kUnknown) {
        coarse(column, row) = cell;
      }
    }
  }
}

}  // namespace

Vec2 DrivableGrid::place(int column, int row) const {
  if (near && counts(*near, clearance.map, column, row)) {
    return roomiest(*this, column, row).p_map;
  }
  return clearance.map.centre(column, row);
}

void bind(Fields& f, SearchOptions& o) {
  f("cell_m", o.cell_m, between(0.01, 0.5));
  f("margin_m", o.margin_m, not_negative);
  f("inflation_distance_m", o.inflation_distance_m, positive);
  f("clearance_weight", o.clearance_weight, not_negative);
  f("goal_tolerance_m", o.goal_tolerance_m, not_negative);
  f("through_unknown", o.through_unknown);
  f.renamed("comfort_m", "inflation_distance_m");
  f.renamed("crowding", "clearance_weight");
}

SearchOptions from_afar(SearchOptions options) {
  options.margin_m -= 0.5 * options.cell_m;
  return options;
}

DrivableGrid drivable_grid_of_coarse(const SearchOptions& options, const Body& body,
                                     OccupancyMap coarse) {
  const double cap_m =
      body.radius_m + options.margin_m + options.inflation_distance_m + coarse.cell_m;
  DrivableGrid grid;
  grid.radius_m = body.radius_m;
  grid.margin_m = options.margin_m;
  grid.through_unknown = options.through_unknown;
  grid.clearance = clearance_map(std::move(coarse), cap_m);
  grid.clearance_m.resize(grid.clearance.map.cells.size());
  const auto occupied_m = static_cast<float>(body.radius_m + options.margin_m);
  const auto unknown_m = static_cast<float>(body.radius_m);
  for (std::size_t i = 0; i < grid.clearance_m.size(); ++i) {
    const float to_occupied = grid.clearance.to_occupied_m[i] - occupied_m;
    const float to_unknown = grid.clearance.to_unknown_m[i] - unknown_m;
    grid.clearance_m[i] = options.through_unknown ? to_occupied : std::min(to_occupied, to_unknown);
  }
  return grid;
}

DrivableGrid drivable_grid_with(const SearchOptions& options, const Body& body, OccupancyMap coarse,
                                NearMap near) {
  lay_over(near, coarse);
  const Box box = box_of(near, coarse);
  DrivableGrid grid = drivable_grid_of_coarse(from_afar(options), body, std::move(coarse));
  grid.margin_m = options.margin_m;
  grid.near = std::move(near);
  for (int row = box.low_row; row < box.end_row; ++row) {
    for (int column = box.low_column; column < box.end_column; ++column) {
      if (!counts(*grid.near, grid.clearance.map, column, row)) {
        continue;
      }
      grid.clearance_m[grid.clearance.index(column, row)] =
          static_cast<float>(roomiest(grid, column, row).clearance_m);
    }
  }
  return grid;
}

DrivableGrid drivable_grid(const SearchOptions& options, const Body& body,
                           const OccupancyMap& map) {
  return drivable_grid_of_coarse(options, body, coarsen(map, options.cell_m, kNoBorder_m));
}

CostField flood(const SearchOptions& options, const DrivableGrid& grid, const Vec2& start) {
  return search(options, grid, start, std::nullopt);
}

std::vector<Vec2> path_to(const DrivableGrid& grid, const CostField& field, int cell) {
  const OccupancyMap& map = grid.clearance.map;
  std::vector<Vec2> path;
  if (!std::isfinite(field.cost_m[cell])) {
    return path;
  }
  for (int at = cell; at >= 0; at = field.came_from[at]) {
    path.push_back(grid.place(at % map.columns, at / map.columns));
  }
  std::reverse(path.begin(), path.end());
  return path;
}

std::optional<int> nearest_drivable(const DrivableGrid& grid, const Vec2& p, double tolerance_m) {
  const OccupancyMap& map = grid.clearance.map;
  const int middle_column = grid.clearance.column(p);
  const int middle_row = grid.clearance.row(p);
  const int range = static_cast<int>(std::ceil(tolerance_m / map.cell_m));
  std::optional<int> best;
  double best_m = tolerance_m + 0.5 * kDiagonal * map.cell_m;
  for (int row = middle_row - range; row <= middle_row + range; ++row) {
    for (int column = middle_column - range; column <= middle_column + range; ++column) {
      if (!grid.drivable(column, row)) {
        continue;
      }
      const double d = (map.centre(column, row) - p).norm();
      if (d < best_m) {
        best_m = d;
        best = static_cast<int>(grid.clearance.index(column, row));
      }
    }
  }
  return best;
}

PathSearch search_path(const SearchOptions& options, const DrivableGrid& grid, const Vec2& start,
                       const Vec2& goal) {
  PathSearch out;
  const OccupancyMap& map = grid.clearance.map;
  if (!map.contains(grid.clearance.column(start), grid.clearance.row(start))) {
    out.reason = "the robot is outside the map";
    return out;
  }
  const std::optional<int> goal_cell = nearest_drivable(grid, goal, options.goal_tolerance_m);
  if (!goal_cell) {
    out.reason = fmt::format("no known free floor for the robot within {:.2f} m of the goal",
                             options.goal_tolerance_m);
    return out;
  }
  const CostField field = search(options, grid, start, goal_cell);
  if (!std::isfinite(field.cost_m[*goal_cell])) {
    out.reason = "no way to the goal over known free floor";
    return out;
  }
  Path path;
  path.points = path_to(grid, field, *goal_cell);
  path.min_clearance_m = kInfinity;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const std::size_t cell = grid.clearance.index(grid.clearance.column(path.points[i]),
                                                  grid.clearance.row(path.points[i]));
    path.min_clearance_m = std::min<double>(path.min_clearance_m, grid.clearance_m[cell]);
    if (i > 0) {
      path.length_m += (path.points[i] - path.points[i - 1]).norm();
    }
  }
  // The goal itself, where it can be stood on, instead of its cell's centre.
  if (static_cast<int>(grid.clearance.index(
          std::clamp(grid.clearance.column(goal), 0, map.columns - 1),
          std::clamp(grid.clearance.row(goal), 0, map.rows - 1))) == *goal_cell) {
    path.points.push_back(goal);
  }
  out.path = std::move(path);
  return out;
}

bool straight_line_clear(const DrivableGrid& grid, const Vec2& a, const Vec2& b,
                         double clearance_m) {
  const Vec2 step = b - a;
  const int count =
      std::max(1, static_cast<int>(std::ceil(2 * step.norm() / grid.clearance.map.cell_m)));
  for (int i = 1; i <= count; ++i) {
    const Vec2 p = a + step * (static_cast<double>(i) / count);
    const int column = grid.clearance.column(p);
    const int row = grid.clearance.row(p);
    if (!grid.clearance.map.contains(column, row) ||
        grid.clearance_m[grid.clearance.index(column, row)] < clearance_m) {
      return false;
    }
  }
  return true;
}

Lookahead lookahead_point(const DrivableGrid& grid, const Path& path, const Vec2& robot,
                          double ahead_m, std::size_t& from_point) {
  PANOPTES_CHECK(!path.points.empty(), "a path has points");
  const std::vector<Vec2>& points = path.points;
  from_point = std::min(from_point, points.size() - 1);
  // Nearest point of the stretch ahead: no jump to another branch that happens to pass close by.
  double best = kInfinity;
  double passed_m = 0;
  std::size_t nearest = from_point;
  for (std::size_t i = from_point; i < points.size() && passed_m < 2 * ahead_m; ++i) {
    const double d = (points[i] - robot).norm();
    if (d < best) {
      best = d;
      nearest = i;
    }
    if (i + 1 < points.size()) {
      passed_m += (points[i + 1] - points[i]).norm();
    }
  }
  from_point = nearest;
  Lookahead lookahead;
  lookahead.off_path_m = best;
  for (std::size_t i = nearest; i + 1 < points.size(); ++i) {
    lookahead.to_go_m += (points[i + 1] - points[i]).norm();
  }
  std::size_t at = nearest;
  double ahead = 0;
  while (at + 1 < points.size() && ahead < ahead_m) {
    ahead += (points[at + 1] - points[at]).norm();
    ++at;
  }
  // A straight line may be as narrow as the path itself is there, not narrower.
  double clearance = kInfinity;
  for (std::size_t i = nearest; i <= at; ++i) {
    const std::size_t cell =
        grid.clearance.index(grid.clearance.column(points[i]), grid.clearance.row(points[i]));
    clearance = std::min<double>(clearance, grid.clearance_m[cell]);
  }
  const double narrower_m =
      std::min(clearance, 2 * grid.clearance.map.cell_m) - 0.5 * grid.clearance.map.cell_m;
  const double wanted_m = clearance < 0 ? narrower_m : std::max(0.0, narrower_m);
  constexpr double kNearest_m = 0.25;  // nearer, and its direction is noise
  while (at > nearest && ahead > kNearest_m &&
         !straight_line_clear(grid, robot, points[at], wanted_m)) {
    ahead -= (points[at] - points[at - 1]).norm();
    --at;
  }
  lookahead.point = points[at];
  lookahead.last = at + 1 == points.size();
  return lookahead;
}

}  // namespace panoptes
