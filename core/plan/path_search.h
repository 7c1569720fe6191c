// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/plan/clearance.h"

namespace panoptes {

struct SearchOptions {
  double cell_m = 0.05;
  double margin_m =
      0.05;  ///< kept from what is occupied; with 0.25 m of disc a gap of 0.7 m is open
  double inflation_distance_m = 0.25;  ///< a cell with more clearance costs nothing extra
  double clearance_weight =
      3.0;  ///< how many times its length a step without any clearance costs extra
  double goal_tolerance_m = 0.3;  ///< a goal that cannot be stood on is moved by at most this
  bool through_unknown = false;   ///< unknown cells may be crossed
};
void bind(Fields& f, SearchOptions& o);

/// What is known about the robot on finer cells, in another frame: the window that it is driven by.
/// It counts in a disc about the robot.
struct NearMap {
  ClearanceMap window;
  Pose2 T_window_map;
  Vec2 robot_map = Vec2::Zero();
  double within_m = 0;  ///< the disc's radius; the window reaches farther by a body and more
};

/// Where the middle of a disc may be, on coarse cells: the clearance left beyond radius and margin,
/// in metres; negative where it must not be. Cells of unknown floor must not be under the disc.
struct DrivableGrid {
  ClearanceMap clearance;
  std::vector<float> clearance_m;  ///< as the map's cells
  double radius_m = 0;             ///< of the disc
  double margin_m = 0;
  bool through_unknown = false;
  std::optional<NearMap> near;

  bool drivable(int column, int row) const {
    return clearance.map.contains(column, row) && clearance_m[clearance.index(column, row)] >= 0;
  }

  /// The place in a cell with most room: its centre, or by the finer map where there is one.
  Vec2 place(int column, int row) const;
};

/// For what is known on coarse cells alone, by which a gap is half a cell narrower than it may be:
/// whether the robot passes is seen near by.
SearchOptions from_afar(SearchOptions options);

DrivableGrid drivable_grid(const SearchOptions& options, const Body& body, const OccupancyMap& map);
/// As above, from a map that is on cells of `cell_m` already.
DrivableGrid drivable_grid_of_coarse(const SearchOptions& options, const Body& body,
                                     OccupancyMap coarse);

/// As above; in the disc that `near` counts in, both cells and room are the finer map's. A cell
/// there has the room of its best place: within it the disc passes wherever the dynamic window,
/// which works on that map, lets it pass.
DrivableGrid drivable_grid_with(const SearchOptions& options, const Body& body, OccupancyMap coarse,
                                NearMap near);

/// What it costs to get from a start to every cell: metres, more where it is narrow.
struct CostField {
  std::vector<float> cost_m;  ///< infinite where there is no path
  std::vector<int>
      came_from;  ///< index of the cell before; -1 at the start and where there is no path
};

/// Dijkstra over the whole grid. A start inside the margin may leave it, always towards more
/// clearance.
CostField flood(const SearchOptions& options, const DrivableGrid& grid, const Vec2& start);

/// The path to a cell of the field, start first.
std::vector<Vec2> path_to(const DrivableGrid& grid, const CostField& field, int cell);

struct Path {
  std::vector<Vec2> points;  ///< from start to goal, a cell apart
  double length_m = 0;
  double min_clearance_m = 0;  ///< beyond radius and margin
};

struct PathSearch {
  std::optional<Path> path;
  std::string reason;  ///< why there is no path
};

/// The drivable cell nearest to `p` among those whose centre is not farther than this and half a
/// cell's diagonal; its index.
std::optional<int> nearest_drivable(const DrivableGrid& grid, const Vec2& p, double tolerance_m);

/// The cheapest path for a disc over known free cells (A*, eight neighbours, steps cost more where
/// it is narrow, so that paths keep to the middle). Start, goal and map share a frame.
PathSearch search_path(const SearchOptions& options, const DrivableGrid& grid, const Vec2& start,
                       const Vec2& goal);

/// True where the disc can be moved straight from `a` to `b` with at least `clearance_m` to spare.
bool straight_line_clear(const DrivableGrid& grid, const Vec2& a, const Vec2& b,
                         double clearance_m);

struct Lookahead {
  Vec2 point = Vec2::Zero();
  double to_go_m = 0;     ///< along the path, from the point of it nearest to the robot to its end
  double off_path_m = 0;  ///< from the robot to that point
  bool last = false;      ///< it is the end of the path
};

/// The point of a path to steer for: `ahead_m` along it from the robot, nearer where the straight
/// line there would cut a corner. `from_point` remembers how far along the path the robot is.
Lookahead lookahead_point(const DrivableGrid& grid, const Path& path, const Vec2& robot,
                          double ahead_m, std::size_t& from_point);

}  // namespace panoptes
