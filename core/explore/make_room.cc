// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/make_room.h"

#include <algorithm>
#include <limits>

namespace panoptes {

std::optional<Vec2> place_to_make_room(const SearchOptions& search, const DrivableGrid& grid,
                                       const Vec2& here_map, std::span<const Vec2> blocked_map) {
  constexpr float kFar_m = 3;  // to drive
  constexpr double kWorth_m = 0.3;
  if (blocked_map.empty()) {
    return std::nullopt;
  }
  const auto away_m = [&](const Vec2& p) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Vec2& place : blocked_map) {
      nearest_m = std::min(nearest_m, (place - p).norm());
    }
    return nearest_m;
  };
  const OccupancyMap& map = grid.clearance.map;
  const CostField field = flood(search, grid, here_map);
  double best_m = away_m(here_map) + kWorth_m;
  std::optional<Vec2> best;
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      const Vec2 p = map.centre(column, row);
      if (grid.drivable(column, row) && field.cost_m[map.index(column, row)] < kFar_m &&
          away_m(p) > best_m) {
        best_m = away_m(p);
        best = p;
      }
    }
  }
  return best;
}

}  // namespace panoptes
