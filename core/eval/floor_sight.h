// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/eval/rig_sight.h"

namespace panoptes {

struct FloorSightOptions {
  double reach_m = 4.5;  ///< from the body's middle; floor farther out does not count
  double cell_m = 0.05;
};

/// Which cameras see what of the floor around a robot: square cells, the body in their middle, in
/// `body`, x ahead. The floor under the body is none.
struct FloorSight {
  double cell_m = 0;
  int side = 0;                   ///< cells each way
  std::vector<CameraSet> seen;    ///< [row * side + column], column along x, row along y
  std::vector<CameraSet> mapped;  ///< by cameras with the role floor
  std::vector<float> sampling_m;  ///< of the camera that sees it finest; 0 where none does
  std::vector<char> floor;        ///< 1 where there is floor within reach

  Vec2 centre(int column, int row) const;
};
FloorSight floor_sight(const FloorSightOptions& options, const RigSight& sight);

/// Of the cells that hold a bit of `cameras`, all together.
double area_m2(const FloorSight& floor, const std::vector<CameraSet>& sets, CameraSet cameras);

/// Of the floor between two distances from the body's edge, the share that `cameras` have in
/// `sets`.
double ring_share(const FloorSight& floor, const std::vector<CameraSet>& sets, CameraSet cameras,
                  double body_radius_m, double from_m, double to_m);

/// The ground sampling distance at one distance from the body's edge, all around where it is seen.
struct SamplingAt {
  double distance_m = 0;
  double seen_share = 0;  ///< of the ring
  std::optional<double> median_m;
  std::optional<double> worst_m;
};
/// Of the finest of `cameras` at each place, where they see it or, with `mapped`, where they map
/// it.
SamplingAt sampling_at(const RigSight& sight, CameraSet cameras, bool mapped, double distance_m);

/// How far from the body's edge the first floor is that is seen in a direction from the body's
/// middle, to a millimetre; empty where none is within reach.
std::optional<double> first_seen_m(const RigSight& sight, CameraSet cameras, bool mapped,
                                   double heading_rad, double reach_m);
/// The same straight ahead of each point of the body's front, along x: the longest of them. Empty
/// where the robot would drive over floor that is nowhere seen.
std::optional<double> first_seen_over_width_m(const RigSight& sight, CameraSet cameras, bool mapped,
                                              double reach_m);
/// How far the floor straight ahead is seen from there on without a gap, from the body's edge.
std::optional<double> last_seen_m(const RigSight& sight, CameraSet cameras, bool mapped,
                                  double reach_m);

/// The smallest upright thing, as wide as it is high, that covers so many pixels each way in the
/// mapped part of a floor camera's picture, on the floor straight ahead. Empty where its foot is
/// not mapped.
std::optional<double> smallest_obstacle_m(const RigSight& sight, double distance_m,
                                          double least_px);

/// What no camera sees at a height.
struct BlindSpot {
  double height_m = 0;
  double share = 0;               ///< of the area up to `around_m` from the body's edge
  std::optional<double> ahead_m;  ///< from the body's edge to what is first seen straight ahead
};
BlindSpot blind_spot(const RigSight& sight, double height_m, double around_m, double reach_m);

}  // namespace panoptes
