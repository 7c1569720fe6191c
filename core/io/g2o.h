// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "core/graph/pose_graph.h"

namespace panoptes {

/// A pose graph in g2o's text form (VERTEX_SE2, EDGE_SE2). g2o measures an edge's error in the
/// frame of the measured `to`, GraphEdge in the frame of `from`: the information is turned from one
/// to the other, so that chi2 is the same on both sides.
void write_g2o(const std::filesystem::path& path, const PoseGraph& graph);

/// Vertices are renumbered from 0 in the order of their ids. A file without vertices gives a graph
/// whose poses are chained along its edges. An edge not between neighbours is a closure.
/// Lines of other kinds than VERTEX_SE2, EDGE_SE2 and FIX are faults.
PoseGraph read_g2o(const std::filesystem::path& path);

}  // namespace panoptes
