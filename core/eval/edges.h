// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/graph/pose_graph.h"

namespace panoptes {

/// Errors of the edges between consecutive keyframes against the truth. `e` of an edge is
/// T_from_to minus the true one: x, y, theta in the frame of `from`.
struct EdgeErrors {
  int count = 0;
  /// e_theta = per metre driven * distance + share of the turn * turn, by least squares over the
  /// edges; empty where they drive or turn too little for the two to be told apart.
  std::optional<double> heading_bias_rad_per_m;
  std::optional<double> heading_bias_share_of_turn;
  double heading_rms_rad = 0;
  double position_rms_m = 0;
  double nees = 0;  ///< mean of e^T Omega e / 3 (Bar-Shalom, Li and Kirubarajan 2001, 5.4.2): 1
                    ///< where the covariances are right, more where they promise too much
};

struct EdgeFigures {
  EdgeErrors spins;  ///< edges that truly turn by more than 5 degrees and move less than 5 cm
  EdgeErrors driving;
};

/// Node i of the graph is where `true_T_scene_body[i]` says; all other edges are left out.
EdgeFigures edge_figures(const PoseGraph& graph, const std::vector<Pose2>& true_T_scene_body);

}  // namespace panoptes
