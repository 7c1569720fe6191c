// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/graph/descent.h"
#include "core/graph/pose_graph.h"

namespace panoptes {

struct TreeDescentOptions {
  int iterations = 100;  ///< at most: sweeps over all edges
};

/// Relaxes a graph as TORO does, the thesis's choice in 6.3.3: stochastic gradient descent on a
/// spanning tree whose nodes say how their pose differs from their parent's (Grisetti et al. 2007).
/// Edge after edge is satisfied in part, along the tree's path between its ends; how far falls as
/// one over the sweep. Starts from the poses as they are, however bad, and comes near the least
/// squares of relax(), never to it; from a start better than that it leads away. The first pose
/// stays. Throws nothing but for edges that lead nowhere; nodes that no edge joins to the first
/// stay where they are.
RelaxReport relax_by_tree(PoseGraph& graph, const TreeDescentOptions& options = {},
                          const RelaxProgress& progress = {}, const RelaxStop& stop = {});

}  // namespace panoptes
