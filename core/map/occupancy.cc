// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/occupancy.h"

#include <algorithm>
#include <cmath>

namespace panoptes {

Cell OccupancyMap::at(const Vec2& p) const {
  const double column = std::floor((p.x() - origin.x()) / cell_m);
  const double row = std::floor((p.y() - origin.y()) / cell_m);
  if (!(column >= 0 && row >= 0 && column < columns && row < rows)) {
    return Cell::kUnknown;
  }
  return at(static_cast<int>(column), static_cast<int>(row));
}

double OccupancyMap::free_m2() const {
  return static_cast<double>(std::count(cells.begin(), cells.end(), Cell::kFree)) * cell_m * cell_m;
}

}  // namespace panoptes
