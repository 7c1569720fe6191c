// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/plan/path_search.h"

namespace panoptes {

struct RevisitOptions {
  double run_m = 2.5;  ///< of the earlier way to be driven again: seven keyframes and both ends
  double least_age_s = 60;  ///< younger places are held by odometry well enough
  double blacklist_m = 0.3;
  double pace_mps = 0.4;
  double turn_pace_radps = 1.0;
  double settle_s = 5.0;
};
void bind(Fields& f, RevisitOptions& o);

/// An earlier place on the robot's way.
struct Place {
  Pose2 T_map_body;
  Time visited;              ///< when it was last seen or closed with
  double uncertainty_m = 0;  ///< of its position relative to the robot's own now
};

struct Revisit {
  std::vector<int> places;   ///< to be driven over in this order
  bool same_heading = true;  ///< as on the first pass, else against it
  double cost_s = 0;         ///< to the first of them
};

/// Which earlier stretch of the way to drive again for a loop closure: the one with the largest
/// uncertainty and age for the time it takes to get to it, in whichever direction is nearer at
/// hand. `places` are in the order of the way; empty when none is old enough and reachable. `avoid`
/// are places not to start from (given up, or tried of late).
std::optional<Revisit> choose_revisit(const RevisitOptions& options, const SearchOptions& search,
                                      const Body& body, const OccupancyMap& map,
                                      const Pose2& T_map_body, Time now,
                                      const std::vector<Place>& places,
                                      const std::vector<Vec2>& avoid);

}  // namespace panoptes
