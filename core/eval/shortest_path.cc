// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/shortest_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace panoptes {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

struct SetCell {
  int column = 0;
  int row = 0;
};

std::optional<SetCell> nearest_set(const TruthLayer& layer, const Vec2& p, double within_m) {
  const int range = static_cast<int>(std::ceil(within_m / layer.cell_m));
  std::optional<SetCell> best;
  double best_m = std::max(within_m, layer.cell_m);
  for (int row = layer.row(p) - range; row <= layer.row(p) + range; ++row) {
    for (int column = layer.column(p) - range; column <= layer.column(p) + range; ++column) {
      const double away_m = (layer.centre(column, row) - p).norm();
      if (layer.at(column, row) != 0 && away_m <= best_m) {
        best_m = away_m;
        best = {column, row};
      }
    }
  }
  return best;
}

// How far a cell is, in cells, that the front reaches from a neighbour along each axis.
float arrival(float along_x, float along_y) {
  const float near = std::min(along_x, along_y);
  const float apart = std::abs(along_x - along_y);
  return apart < 1 ? 0.5F * (along_x + along_y + std::sqrt(2 - apart * apart)) : near + 1;
}

}  // namespace

std::optional<double> shortest_path_m(const TruthLayer& reachable, const Vec2& from_scene,
                                      const Vec2& to_scene, double moved_m) {
  const std::optional<SetCell> from = nearest_set(reachable, from_scene, moved_m);
  const std::optional<SetCell> to = nearest_set(reachable, to_scene, moved_m);
  if (!from || !to) {
    return std::nullopt;
  }
  std::vector<float> cells(reachable.cells.size(), kFar);
  std::vector<std::uint8_t> done(reachable.cells.size(), 0);
  const auto cells_at = [&](int column, int row) {
    return reachable.contains(column, row) ? cells[reachable.index(column, row)] : kFar;
  };
  using Front = std::pair<float, std::size_t>;
  std::priority_queue<Front, std::vector<Front>, std::greater<>> front;
  cells[reachable.index(from->column, from->row)] = 0;
  front.emplace(0.0F, reachable.index(from->column, from->row));
  const std::size_t goal = reachable.index(to->column, to->row);
  while (!front.empty() && done[goal] == 0) {
    const std::size_t cell = front.top().second;
    front.pop();
    if (done[cell] != 0) {
      continue;
    }
    done[cell] = 1;
    const int column = static_cast<int>(cell % static_cast<std::size_t>(reachable.columns));
    const int row = static_cast<int>(cell / static_cast<std::size_t>(reachable.columns));
    constexpr std::array<SetCell, 4> kBeside = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    for (const SetCell& step : kBeside) {
      const int to_column = column + step.column;
      const int to_row = row + step.row;
      if (reachable.at(to_column, to_row) == 0) {
        continue;
      }
      const std::size_t beside = reachable.index(to_column, to_row);
      const float found =
          arrival(std::min(cells_at(to_column - 1, to_row), cells_at(to_column + 1, to_row)),
                  std::min(cells_at(to_column, to_row - 1), cells_at(to_column, to_row + 1)));
      if (done[beside] == 0 && found < cells[beside]) {
        cells[beside] = found;
        front.emplace(found, beside);
      }
    }
  }
  if (done[goal] == 0) {
    return std::nullopt;
  }
  return static_cast<double>(cells[goal]) * reachable.cell_m;
}

}  // namespace panoptes
