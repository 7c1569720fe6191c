// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "core/plan/clearance.h"

namespace panoptes {

struct DwaOptions {
  double cell_m = 0.02;   ///< of the window's map
  double window_m = 2.8;  ///< side of the square around the robot that is looked at
  int speed_samples = 7;
  int turn_samples = 21;        ///< odd, so that keeping straight on is always tried
  double distance_cap_m = 1.0;  ///< free path beyond this is worth no more
  double margin_m = 0.04;       ///< kept from things when creeping, less from unknown floor
  double margin_s = 0.15;       ///< and this much more per m/s: 13 cm in all at 0.6 m/s
  double heading_weight = 10;
  double distance_weight = 2;
  double speed_weight = 2;
};
void bind(Fields& f, DwaOptions& o);

/// One candidate of the dynamic window (thesis Fig. 6.7).
struct WindowScore {
  Twist2 twist_body;
  double score = 0;  ///< in [0, 1]; 0 when not admissible
  double clearance_m = 0;
};

struct DwaRequest {
  Pose2 T_odom_body;           ///< when the command begins to act
  Twist2 twist_body;           ///< then
  double cycle_s = 0;          ///< between two decisions
  double longest_cycle_s = 0;  ///< of late: so long may it be before it can brake
  Vec2 lookahead_odom = Vec2::Zero();
  double speed_limit_mps = 1e9;  ///< below the body's own, e.g. close to the goal
  bool keep_window = false;      ///< hand back every candidate
};

struct DwaChoice {
  Twist2 command_body;
  double clearance_m = 0;  ///< closest approach of the outline to an obstacle along the chosen arc
  double free_path_m = 0;  ///< along the chosen arc, capped
  int arcs_rejected = 0;
  bool slowed = false;  ///< faster on the same turn it could not stop in the floor it knows
};

struct DwaResult {
  std::optional<DwaChoice> choice;
  std::vector<WindowScore> window;  ///< empty unless asked for
};

/// Rolls short arcs through the map and takes the one that makes most of heading, free path and
/// speed (Fox, Burgard, Thrun 1997; thesis 2.3.1), among those on which the robot can still stop in
/// time. Turning on the spot is safe for a disc and in the window of a robot that all but stands;
/// reversing never is. No choice where nothing but standing is left. Occupied and unknown cells of
/// `local_odom` are lethal alike. In `odom`, which does not jump when a loop closes.
DwaResult choose_arc(const DwaOptions& options, const Body& body, const ClearanceMap& local_odom,
                     const DwaRequest& request);

}  // namespace panoptes
