// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/passability_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

constexpr double kCell_m = 0.05;
constexpr double kFar_m = 0.6;     // clearances are not told apart beyond
constexpr double kRobot_m = 0.25;  // its radius
// A passage of 0.9 m for the middle of the robot, which the grid may miss by half a cell.
constexpr double kWide_m = 0.45 - kCell_m / 2;
// Ways of 0.58 m are open on every grid of 5 cm, however it lies.
constexpr double kSurelyOpen_m = kRobot_m + 0.04;
constexpr double kPerhapsOpen_m = kRobot_m - 0.03;
constexpr int kNearCells = 3;  // in a corner a robot stands no farther from the open floor

}  // namespace

PassabilityGrid::PassabilityGrid(const Vec2& low, const Vec2& high) {
  const int columns = static_cast<int>(std::ceil((high.x() - low.x()) / kCell_m));
  const int rows = static_cast<int>(std::ceil((high.y() - low.y()) / kCell_m));
  PANOPTES_CHECK(columns > 0 && rows > 0, "a place has room");
  clearance_m_.cell_m = kCell_m;
  clearance_m_.origin = low;
  clearance_m_.assign(columns, rows, static_cast<float>(kFar_m));
  lower_clearance({low - Vec2(1, 1), {low.x(), high.y() + 1}});
  lower_clearance({{high.x(), low.y() - 1}, high + Vec2(1, 1)});
  lower_clearance({low - Vec2(1, 1), {high.x() + 1, low.y()}});
  lower_clearance({{low.x() - 1, high.y()}, high + Vec2(1, 1)});
}

void PassabilityGrid::lower_clearance(const Rectangle& what) {
  const Vec2 from = (what.low - clearance_m_.origin) / kCell_m;
  const Vec2 to = (what.high - clearance_m_.origin) / kCell_m;
  const double reach = kFar_m / kCell_m;
  const auto clamped = [](double at, int count) {
    return std::clamp(static_cast<int>(std::floor(at)), 0, count - 1);
  };
  for (int row = clamped(from.y() - reach, clearance_m_.rows);
       row <= clamped(to.y() + reach, clearance_m_.rows); ++row) {
    for (int column = clamped(from.x() - reach, clearance_m_.columns);
         column <= clamped(to.x() + reach, clearance_m_.columns); ++column) {
      const Vec2 middle = clearance_m_.centre(column, row);
      const Vec2 off = (what.low - middle).cwiseMax(middle - what.high).cwiseMax(0);
      float& there = clearance_m_(column, row);
      there = std::min(there, static_cast<float>(off.norm()));
    }
  }
}

void PassabilityGrid::block(const Rectangle& what) { lower_clearance(what); }

void PassabilityGrid::keep_open(const std::vector<Vec2>& places) {
  places_.insert(places_.end(), places.begin(), places.end());
}

std::size_t PassabilityGrid::cell_of(const Vec2& p) const {
  const Vec2 at = (p - clearance_m_.origin) / kCell_m;
  const int column = std::clamp(static_cast<int>(at.x()), 0, clearance_m_.columns - 1);
  const int row = std::clamp(static_cast<int>(at.y()), 0, clearance_m_.rows - 1);
  return clearance_m_.index(column, row);
}

/// The cells with that clearance that hang together with the first of the places.
std::vector<char> PassabilityGrid::region(double clearance_m) const {
  std::vector<char> inside(clearance_m_.cells.size(), 0);
  std::vector<std::size_t> stack;
  const auto visit = [&](std::size_t next) {
    if (inside[next] == 0 && clearance_m_.cells[next] >= clearance_m) {
      inside[next] = 1;
      stack.push_back(next);
    }
  };
  visit(cell_of(places_.front()));
  const auto width = static_cast<std::size_t>(clearance_m_.columns);
  while (!stack.empty()) {
    const std::size_t here = stack.back();
    stack.pop_back();
    if (here % width > 0) {
      visit(here - 1);
    }
    if (here % width + 1 < width) {
      visit(here + 1);
    }
    if (here >= width) {
      visit(here - width);
    }
    if (here + width < clearance_m_.cells.size()) {
      visit(here + width);
    }
  }
  return inside;
}

bool PassabilityGrid::is_passable() const {
  const std::vector<char> wide = region(kWide_m);
  if (!std::all_of(places_.begin(), places_.end(),
                   [&](const Vec2& p) { return wide[cell_of(p)] != 0; })) {
    return false;
  }
  // Whatever the robot may fit into lies beside floor it surely gets to.
  const std::vector<char> open = region(kSurelyOpen_m);
  for (int row = 0; row < clearance_m_.rows; ++row) {
    for (int column = 0; column < clearance_m_.columns; ++column) {
      const std::size_t here = clearance_m_.index(column, row);
      if (clearance_m_.cells[here] < kPerhapsOpen_m || open[here] != 0) {
        continue;
      }
      bool is_near = false;
      for (int y = std::max(0, row - kNearCells);
           y <= std::min(clearance_m_.rows - 1, row + kNearCells); ++y) {
        for (int x = std::max(0, column - kNearCells);
             x <= std::min(clearance_m_.columns - 1, column + kNearCells); ++x) {
          is_near = is_near || open[clearance_m_.index(x, y)] != 0;
        }
      }
      if (!is_near) {
        return false;
      }
    }
  }
  return true;
}

bool PassabilityGrid::block_if_passable(const Rectangle& what) {
  PANOPTES_CHECK(!places_.empty(), "there are places to keep open");
  const std::vector<float> before = clearance_m_.cells;
  lower_clearance(what);
  if (is_passable()) {
    return true;
  }
  clearance_m_.cells = before;
  return false;
}

}  // namespace panoptes::sim
