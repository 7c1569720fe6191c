// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/grid2.h"
#include "core/geometry/pose2.h"
#include "core/map/occupancy.h"

namespace panoptes::sim {

/// A building as a scanned map shows it, made fit to be walked in. Lengths are the map's.
struct MapWalls {
  /// A straight stretch of wall; the floor lies to the left of the way from `from` to `to`.
  struct Face {
    Vec2 from = Vec2::Zero();
    Vec2 to = Vec2::Zero();
    int room = 0;
  };

  Grid2<std::uint8_t>
      floor;                 ///< 1: the building's floor, one piece of it; a cell of wall around it
  Grid2<float> clearance_m;  ///< how far each cell of floor is from what is none, at most 1.5 m
  Grid2<std::uint16_t> room;              ///< of each cell of floor, from 1
  std::vector<Face> faces;                ///< closed loops, one after the other
  std::vector<std::array<int, 4>> solid;  ///< column, row, end column, end row of what is filled
};

/// Makes walls of all that is not the map's largest piece of free floor: what is occupied, and what
/// nobody has seen. Scanned maps have specks, rays through windows and stairs where a straight wall
/// lies aslant, so
/// - what is not free and smaller than 0.02 m2 is no wall (legs of tables, people, noise); of that
///   size and above it stands as a pillar from floor to ceiling;
/// - unknown cells that free ones surround are free;
/// - floor narrower than 0.3 m is wall;
/// - the outline is simplified to straight faces, none of which is off the map's by more than a
///   cell or 6 cm.
/// Rooms are what is left apart where doorways and all else narrower than 1 m are shut.
/// Empty faces when the map has no floor.
MapWalls walls_of_map(const OccupancyMap& map);

}  // namespace panoptes::sim
