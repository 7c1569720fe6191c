// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/g2o.h"

#include <string>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/io/digits.h"
#include "core/io/file.h"

namespace panoptes {

Mat3 turned_information(const Mat3& information, double angle_rad) {
  const bool round = information(0, 0) == information(1, 1) && information(0, 1) == 0 &&
                     information(0, 2) == 0 && information(1, 2) == 0;
  if (round) {
    return information;  // exactly, so that a file read and written again is the same file
  }
  Mat3 R = Mat3::Identity();
  R.topLeftCorner<2, 2>() = Pose2{0, 0, angle_rad}.rotation();
  const Mat3 result = R.transpose() * information * R;
  return (result + result.transpose()) / 2;
}

void write_g2o(const std::filesystem::path& path, const PoseGraph& graph,
               const std::vector<int>& ids) {
  PANOPTES_CHECK(ids.empty() || ids.size() == graph.T_map_node.size(), "every node has an id");
  const auto name = [&ids](int node) { return std::to_string(ids.empty() ? node : ids[node]); };
  AtomicFile file(path);
  for (int i = 0; i < static_cast<int>(graph.T_map_node.size()); ++i) {
    const Pose2& T = graph.T_map_node[i];
    file.append("VERTEX_SE2 " + name(i) + " " + shortest(T.x_m) + " " + shortest(T.y_m) + " " +
                shortest(T.theta_rad) + "\n");
  }
  for (const GraphEdge& edge : graph.edges) {
    const Mat3 I = turned_information(edge.information, edge.T_from_to.theta_rad);
    std::string line = fmt::format("EDGE_SE2 {} {}", name(edge.from), name(edge.to));
    for (const double value : {edge.T_from_to.x_m, edge.T_from_to.y_m, edge.T_from_to.theta_rad,
                               I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)}) {
      line += fmt::format(" {}", shortest(value));
    }
    file.append(line + "\n");
  }
  file.commit();
}

}  // namespace panoptes
