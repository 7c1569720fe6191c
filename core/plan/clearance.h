// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/map/occupancy.h"

namespace panoptes {

/// A map with the room around each of its cells: the distance from the cell's centre to the centre
/// of the nearest cell that blocks, capped; 0 in a blocking cell.
struct ClearanceMap {
  OccupancyMap map;
  double cap_m = 0;
  std::vector<float> to_occupied_m;  ///< as `map.cells`
  std::vector<float> to_unknown_m;   ///< as `map.cells`; outside the map all is unknown

  std::size_t index(int column, int row) const { return map.index(column, row); }
  int column(const Vec2& p) const { return map.column(p); }
  int row(const Vec2& p) const { return map.row(p); }
};

ClearanceMap clearance_map(OccupancyMap map, double cap_m);

/// Distance from each cell's centre to the nearest blocking cell's centre, capped (exactly:
/// Felzenszwalb and Huttenlocher 2012, by OpenCV). `blocks` is row-major.
std::vector<float> distance_m(const std::vector<std::uint8_t>& blocks, int columns, int rows,
                              double cell_m, double cap_m);

/// The known part of a map on larger cells, with a border of unknown ones around it: a cell is
/// occupied where any of its parts is, else free where at least half of its parts are, else
/// unknown. `cell_m` is rounded to a multiple of the map's. Without cells where nothing is known.
OccupancyMap coarsen(const OccupancyMap& map, double cell_m, double border_m);

}  // namespace panoptes
