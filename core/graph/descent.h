// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "core/graph/pose_graph.h"

namespace panoptes {

/// Asked before each step, which takes about so many multiplications, whether to end with the best
/// so far instead. That has not converged then.
using RelaxStop = std::function<bool(double multiplications)>;

/// relax() from the poses as they are alone: Gauss-Newton, else Levenberg-Marquardt, wherever that
/// ends. It has converged where no step promises more than rounding hides, never because nothing
/// helped or something was not a number.
RelaxReport descend(PoseGraph& graph, const RelaxProgress& progress = {},
                    const RelaxStop& stop = {});

/// relax() that can be stopped.
RelaxReport relax(PoseGraph& graph, RelaxStart start, const RelaxProgress& progress,
                  const RelaxStop& stop);

/// Orientations first, then positions with these held: each a linear problem, and the least of it.
/// False, and the poses as they were, where they cannot be solved.
bool start_linearly(PoseGraph& graph);

}  // namespace panoptes
