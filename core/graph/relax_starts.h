// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/graph/descent.h"
#include "core/graph/pose_graph.h"

namespace panoptes {

/// Where one start led.
struct StartReport {
  std::string name;
  RelaxReport relax;  ///< chi2_start: of the start's own poses
};

struct StartsReport {
  RelaxReport relax;  ///< chi2_start of the poses given, the rest of the best start
  std::string best;
  std::vector<StartReport> starts;  ///< in the order in which they were tried
};

/// relax() from every start there is, and the least that any leads to:
/// - "linear": orientations first, then positions, where that can be solved;
/// - "given": the poses as they are;
/// - "odometry": dead reckoned, where that is not what was given;
/// - "tree": dead reckoned from the first node along fewest edges, so with fewest errors;
/// - "descent": that, moved on by some sweeps of relax_by_tree().
/// A noisy graph has many bottoms, none of which says of itself that it is not the deepest. Where
/// two lead to the same but for rounding, the given poses' or else the earlier one is kept. Costs a
/// relaxation each; one that stays far above the least is left there, not converged, as all are
/// that `stop` ends.
StartsReport relax_from_every_start(PoseGraph& graph, const RelaxProgress& progress = {},
                                    const RelaxStop& stop = {});

}  // namespace panoptes
