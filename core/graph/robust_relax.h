// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/graph/descent.h"
#include "core/graph/pose_graph.h"

namespace panoptes {

struct RobustReport {
  RelaxReport relax;       ///< chi2_start of all edges, chi2_end of those kept
  std::vector<bool> kept;  ///< an edge each
  int rejected = 0;        ///< edges that are not kept
  double noise_scale = 1;  ///< errors are about so many times what the information says
  bool stopped = false;    ///< before it was done: the best so far
};

/// Whether what is left of a relaxed graph's errors can be noise.
struct Plausibility {
  int degrees_of_freedom = 0;  ///< 3 (edges - nodes + 1)
  double chi2_most = 0;        ///< that errors twice those stated exceed once in a thousand graphs
  bool plausible = true;       ///< chi2 does not; so where nothing is free
  std::vector<int> disagreeing;  ///< closures that are off by more than such errors, an edge each
};
Plausibility plausibility(const PoseGraph& relaxed);

/// The first node that no edge joins to the one before it, if there is one: such a graph has no
/// odometry that closures could be judged by.
std::optional<int> odometry_gap(const PoseGraph& graph);

/// Told what share of the cycles has been tried, from 0 to 1, now and then.
using CycleProgress = std::function<void(double)>;

/// relax() for graphs some of whose closures are false, even most of them. Trusts the first edge
/// between each two neighbours; there must be one (odometry_gap). Any other edge is a closure, to
/// be kept or not:
/// 1. two closures that close a cycle with the odometry between them, closer than chance would in
///    any cycle of the graph, support each other (after Mangelson et al. 2018). Cycles are tried at
///    several scales of the noise; that counts which supports most closures;
/// 2. odometry and the closures in cycles beyond all doubt are relaxed, from a linear start; other
///    supported ones come in where they agree with that;
/// 3. a closure comes in where the error it shows, against its own covariance and the relaxed
///    graph's, makes it true beyond doubt; one leaves where its chi2 is beyond what errors explain;
///    all is relaxed again, until nothing changes.
/// A false closure that happens to agree with the graph within its uncertainty cannot be told from
/// a true one, and is kept; so are false ones that agree closely with each other.
/// The poses given are not looked at but for the first, which stays. The cost grows with the square
/// of the number of closures, and with its cube where they join everything with everything. Where
/// `stop` ends it, what was kept last stays, relaxed as far as it went; odometry alone at the
/// least. One thread, same bits every time.
RobustReport relax_robustly(PoseGraph& graph, const CycleProgress& cycles = {},
                            const RelaxProgress& steps = {}, const RelaxStop& stop = {});

}  // namespace panoptes
