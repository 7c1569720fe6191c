// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/graph/pose_graph.h"

namespace panoptes {

/// What a pose-graph file holds.
struct GraphFile {
  PoseGraph graph;                    ///< nodes in the order of their ids
  std::vector<int> ids;               ///< of each node, as the file calls it
  bool poses_given = false;           ///< else they are dead reckoned along the edges
  std::vector<std::string> warnings;  ///< `file:line: ...` what is odd, but no fault
};

/// A pose graph in g2o's text form (VERTEX_SE2, EDGE_SE2, FIX) or TORO's (VERTEX2, EDGE2, EQUIV);
/// the words tell which. The information is turned to GraphEdge's frame, that of `from`: TORO
/// measures an edge's error there, g2o in the frame of the measured `to`. The first edge between
/// neighbours is odometry, every other one a closure.
///
/// Throws ConfigError with `file:line: what is wrong` for every fault: lines that are not whole,
/// numbers that are not finite, a file that ends within a line, vertices given twice, edges to
/// vertices that are not there or back to their own start, information that is not positive
/// definite, odometry repeated word for word, parts that no edge joins. A closure repeated word for
/// word counts twice, as it does in graphs that are in use, and is a remark. So are FIX and EQUIV
/// lines, which are left out.
GraphFile read_graph(const std::filesystem::path& path);

/// The same from text; `name` stands for the file in what is said.
GraphFile parse_graph(const std::string& name, std::string_view text);

}  // namespace panoptes
