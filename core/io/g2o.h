// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "core/graph/pose_graph.h"

namespace panoptes {

/// A pose graph in g2o's text form (VERTEX_SE2, EDGE_SE2), its nodes called by `ids`, or by their
/// numbers where there are none. g2o measures an edge's error in the frame of the measured `to`,
/// GraphEdge in the frame of `from`: the information is turned from one to the other, so that chi2
/// is the same on both sides. core/io/graph_file.h reads it back.
void write_g2o(const std::filesystem::path& path, const PoseGraph& graph,
               const std::vector<int>& ids = {});

/// The same information seen from axes turned by `angle_rad`.
Mat3 turned_information(const Mat3& information, double angle_rad);

}  // namespace panoptes
