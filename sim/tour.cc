// SPDX-License-Identifier: BSD-3-Clause
#include "sim/tour.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "core/base/error.h"
#include "core/plan/path_search.h"

namespace panoptes::sim {
namespace {

constexpr double kCell_m = 0.05;

SearchOptions search_options() {
  SearchOptions options;
  options.cell_m = kCell_m;
  options.margin_m = 0.07;             // the follower arrives within 5 cm
  options.inflation_distance_m = 0.4;  // the middle of any aisle narrower than 1.4 m
  return options;
}

DrivableGrid drivable(const SearchOptions& options, const TruthLayer& layer, const Body& body) {
  return drivable_grid(options, body, transformed(layer, [](std::uint8_t set) {
                         return set != 0 ? Cell::kOccupied : Cell::kFree;
                       }));
}

// The places of a tour and the paths between them.
class Places {
 public:
  Places(const TourOptions& options, const TruthLayer& layer, const Body& body, const Vec2& start)
      : grid_(drivable(search_, layer, body)) {
    SearchOptions shortest = search_;
    shortest.clearance_weight = 0;
    add(start);
    std::vector<float> apart_m = flood(shortest, grid_, start).cost_m;
    const auto most = static_cast<std::size_t>(options.length_m / options.apart_m);
    while (fields_.size() <= most) {
      int farthest = -1;
      for (int cell = 0; cell < static_cast<int>(apart_m.size()); ++cell) {
        if (std::isfinite(apart_m[cell]) && in_the_middle(cell) &&
            (farthest < 0 || apart_m[cell] > apart_m[farthest])) {
          farthest = cell;
        }
      }
      if (farthest < 0 || apart_m[farthest] < options.apart_m) {
        break;
      }
      const Vec2 at = centre(farthest);
      add(at);
      const std::vector<float> from_here_m = flood(shortest, grid_, at).cost_m;
      for (std::size_t cell = 0; cell < apart_m.size(); ++cell) {
        apart_m[cell] = std::min(apart_m[cell], from_here_m[cell]);
      }
    }
  }

  int count() const { return static_cast<int>(fields_.size()); }

  // The first place's own paths come first, so that to and fro are the same.
  double cost_m(int a, int b) const {
    return fields_[std::min(a, b)].cost_m[cells_[std::max(a, b)]];
  }

  // The corners of the path, from the one after `a` to `b`.
  std::vector<Vec2> path(int a, int b) const {
    std::vector<Vec2> corners =
        straightened(path_to(grid_, fields_[std::min(a, b)], cells_[std::max(a, b)]));
    if (b < a) {
      std::reverse(corners.begin(), corners.end());
    }
    corners.erase(corners.begin());
    return corners;
  }

 private:
  Vec2 centre(int cell) const {
    const OccupancyMap& map = grid_.clearance.map;
    return map.centre(cell % map.columns, cell / map.columns);
  }

  double clearance_m(const Vec2& p) const {
    return grid_
        .clearance_m[grid_.clearance.index(grid_.clearance.column(p), grid_.clearance.row(p))];
  }

  bool in_the_middle(int cell) const {
    const OccupancyMap& map = grid_.clearance.map;
    for (const int step : {-map.columns - 1, -map.columns, -map.columns + 1, -1}) {
      for (const int other : {cell + step, cell - step}) {
        if (other >= 0 && other < static_cast<int>(grid_.clearance_m.size()) &&
            grid_.clearance_m[other] > grid_.clearance_m[cell]) {
          return false;
        }
      }
    }
    return true;
  }

  void add(const Vec2& at) {
    fields_.push_back(flood(search_, grid_, at));
    cells_.push_back(static_cast<int>(
        grid_.clearance.index(grid_.clearance.column(at), grid_.clearance.row(at))));
  }

  // Only its corners, cut no nearer to obstacles than the path itself comes.
  std::vector<Vec2> straightened(const std::vector<Vec2>& points) const {
    std::vector<Vec2> corners{points.front()};
    for (std::size_t from = 0; from + 1 < points.size();) {
      std::size_t to = from + 1;
      double clearance = std::min(
          {search_.inflation_distance_m, clearance_m(points[from]), clearance_m(points[to])});
      while (to + 1 < points.size()) {
        clearance = std::min(clearance, clearance_m(points[to + 1]));
        if (!straight_line_clear(grid_, points[from], points[to + 1],
                                 std::max(0.0, clearance - kCell_m))) {
          break;
        }
        ++to;
      }
      corners.push_back(points[to]);
      from = to;
    }
    return corners;
  }

  SearchOptions search_ = search_options();
  DrivableGrid grid_;
  std::vector<int> cells_;
  std::vector<CostField> fields_;
};

int nearest_new(const Places& places, const std::vector<int>& visited, int here) {
  int nearest = -1;
  for (int place = 0; place < places.count(); ++place) {
    const bool is_new = std::find(visited.begin(), visited.end(), place) == visited.end();
    if (is_new && (nearest < 0 || places.cost_m(here, place) < places.cost_m(here, nearest))) {
      nearest = place;
    }
  }
  return nearest;
}

// The one of the places visited whose path from here is nearest to the length asked for.
int place_back(const Places& places, const std::vector<int>& visited, double return_m) {
  const int here = visited.back();
  return *std::min_element(visited.begin(), visited.end() - 1, [&](int a, int b) {
    return std::abs(places.cost_m(here, a) - return_m) <
           std::abs(places.cost_m(here, b) - return_m);
  });
}

}  // namespace

std::vector<Waypoint> tour(const TourOptions& options, const TruthLayer& body_layer,
                           const Body& body, const Vec2& start_scene) {
  const Places places(options, body_layer, body, start_scene);
  if (places.count() < 2) {
    throw ConfigError(
        "drive.route.tour: there is nowhere to go from the start; give platform.start another "
        "pose, or tour.apart_m a smaller value");
  }
  std::vector<Waypoint> waypoints;
  double length_m = 0;
  Vec2 at = start_scene;
  int here = 0;
  const auto go = [&](int place) {
    for (const Vec2& corner : places.path(here, place)) {
      length_m += (corner - at).norm();
      at = corner;
      waypoints.push_back({corner.x(), corner.y()});
    }
    here = place;
  };
  const int between_returns =
      options.returns > 0 ? 1 + (places.count() - 2) / options.returns : places.count();
  std::vector<int> visited{0};
  while (static_cast<int>(visited.size()) < places.count()) {
    const int next = nearest_new(places, visited, visited.back());
    go(next);
    visited.push_back(next);
    if ((static_cast<int>(visited.size()) - 1) % between_returns == 0) {
      go(place_back(places, visited, options.return_m));
    }
  }
  go(visited.back());
  while (length_m < options.length_m) {
    std::reverse(visited.begin(), visited.end());
    for (const int place : visited) {
      if (place != here) {
        go(place);
      }
    }
  }
  return waypoints;
}

}  // namespace panoptes::sim
