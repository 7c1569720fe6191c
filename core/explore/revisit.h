// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/plan/path_search.h"

namespace panoptes {

struct RevisitOptions {
  double run_m = 2.5;  ///< of the earlier path to be driven again: seven keyframes and both ends
  double least_age_s = 60;    ///< younger places are held by odometry well enough
  double uncertain_m = 0.04;  ///< a place known better than this is owed no closure
  double closure_m = 0.016;   ///< what a closure leaves uncertain
  double blacklist_m = 0.3;
  double pace_mps = 0.4;
  double turn_pace_radps = 1.0;
  double fixed_cost_s = 5.0;
};
void bind(Fields& f, RevisitOptions& o);

/// An earlier pose on the robot's path.
struct VisitedPose {
  Pose2 T_map_body;
  Time visited;              ///< when it was last seen or closed with
  double uncertainty_m = 0;  ///< of its position seen from the last of them
};

struct RevisitPlan {
  std::vector<int> places;   ///< to be driven over in this order
  bool same_heading = true;  ///< as on the first pass, else against it
  double cost_s = 0;         ///< to the first of them
};

/// Whether a place is owed a closure: it is old and uncertain, and to go there, `distance_m` away,
/// and close with it would at least halve that. What going there makes uncertain is taken to be
/// what driving as far did last.
bool closure_due(const RevisitOptions& options, Time now, const std::vector<VisitedPose>& places,
                 std::size_t place, double distance_m);

/// Which earlier stretch of the path to drive again for a loop closure: the one with the largest
/// uncertainty and age for the time it takes to get to it, in whichever direction is nearer at
/// hand. `places` are in the order of the path; empty when none is old enough and reachable, or
/// with `only_due` owed a closure. `avoid` are places not to start from (given up, or tried of
/// late).
std::optional<RevisitPlan> choose_revisit(const RevisitOptions& options,
                                          const SearchOptions& search, const DrivableGrid& grid,
                                          const Pose2& T_map_body, Time now,
                                          const std::vector<VisitedPose>& places,
                                          const std::vector<Vec2>& avoid, bool only_due);

}  // namespace panoptes
