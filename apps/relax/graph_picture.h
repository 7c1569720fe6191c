// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/graph/pose_graph.h"

namespace panoptes {

struct GraphPicture {
  PoseGraph before;
  std::vector<Pose2> T_map_node_after;
  std::vector<bool> kept;  ///< an edge of `before` each
  std::string title;
};

/// A pose graph before and after its relaxation, side by side, each as large as it fits: odometry
/// and closures, before it also those that were rejected, in red over the others. 8-bit BGR.
cv::Mat draw_graph(const GraphPicture& picture);

}  // namespace panoptes
