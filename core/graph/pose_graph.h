// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes {

/// What was measured between two keyframes: the pose of `to` seen from `from`, and its information
/// (inverse covariance of x, y, theta in the frame of `from`; 1/m^2, 1/(m rad), 1/rad^2).
struct GraphEdge {
  int from = 0;
  int to = 0;
  Pose2 T_from_to;
  Mat3 information = Mat3::Identity();
  bool closure = false;
};

struct RelaxReport {
  double chi2_start = 0;  ///< sum r^T Omega r, without a half
  double chi2_end = 0;
  int iterations = 0;
  bool converged = false;
};

/// Keyframe poses and what was measured between them.
struct PoseGraph {
  std::vector<Pose2> T_map_node;
  std::vector<GraphEdge> edges;
};

double chi2(const PoseGraph& graph);
double chi2(const PoseGraph& graph, const GraphEdge& edge);

/// Places every node by dead reckoning from where the first one is: along the edges between
/// neighbours, and over closures only to what those do not reach. Returns a node that no edges join
/// to the first, if there is one; such nodes stay where they are.
std::optional<int> dead_reckon(PoseGraph& graph);

/// Told before each iteration how far it is: chi2_end is where it stands.
using RelaxProgress = std::function<void(const RelaxReport&)>;

enum class RelaxStart {
  kLinear,   ///< orientations first, then positions, each a linear problem: needs no good start
  kCurrent,  ///< the poses as they are; a linear start only when that ends badly
};

/// Moves every pose but the first to where all edges agree best: a linear start for the
/// orientations and then the translations, then Levenberg-Marquardt on sparse Cholesky
/// (thesis 6.3.3 uses TORO). One thread, same bits every time. The better of linear and current
/// start is kept.
RelaxReport relax(PoseGraph& graph, RelaxStart start = RelaxStart::kLinear,
                  const RelaxProgress& progress = {});

/// How uncertain the pose of `to` is seen from `from`: the marginal of the whole graph, linearised
/// at its poses; x, y, theta in the frame of `from`. Costs a factorisation.
Mat3 relative_covariance(const PoseGraph& graph, int from, int to);

/// States that the edges of a graph have in common: how each edge changes with them (x, y, theta a
/// row; none where it does not), and how uncertain they are.
struct SharedStates {
  std::vector<Eigen::MatrixXd> by_state;
  Eigen::MatrixXd covariance;
};

/// The same from `from` to every node, dead reckoned along the most certain path: never smaller
/// than the marginal, and cheap. What the edges of a path get wrong together by the states adds up
/// as it is, not as its square.
std::vector<Mat3> path_covariances(const PoseGraph& graph, int from,
                                   const SharedStates* states = nullptr);

}  // namespace panoptes
