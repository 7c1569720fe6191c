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

/// The room that a disc about `p` has: from its outline to the nearest lethal cell, with half a
/// cell taken off because distances run between the centres of cells. Unknown floor is kept from by
/// `unknown_nearer_m` less than what is occupied. Minus the radius outside the map.
double outline_clearance_m(const ClearanceMap& map, double radius_m, double unknown_nearer_m,
                           const Vec2& p);

/// Floor that nobody has seen is mostly free: what hides there begins somewhere behind its edge. So
/// it is kept from by so much less than what is occupied, but never driven over.
inline constexpr double kUnknownNearer_m = 0.04;

/// Distance from each cell's centre to the nearest blocking cell's centre, capped (exactly:
/// Felzenszwalb and Huttenlocher 2012, by OpenCV). `blocks` is row-major.
std::vector<float> distance_m(const std::vector<std::uint8_t>& blocks, int columns, int rows,
                              double cell_m, double cap_m);

/// The known part of a map on larger cells, with a border of unknown ones around it: a cell is
/// occupied where any of its parts is, else free where at least half of its parts are, else
/// unknown. `cell_m` is rounded to a multiple of the map's. Without cells where nothing is known.
OccupancyMap coarsen(const OccupancyMap& map, double cell_m, double border_m);

}  // namespace panoptes
