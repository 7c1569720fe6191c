// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/graph/pose_graph.h"
#include "core/graph/pose_matrix.h"

namespace panoptes {

/// What an edge says is wrong with two poses: the translation in the frame of `from`, and the turn.
Vec3 residual_of(const GraphEdge& edge, const Pose2& from, const Pose2& to);

/// How the pose of `to` seen from `from` changes with each of the two, as they lie in `map`.
struct RelativeJacobian {
  Mat3 from;
  Mat3 to;
};
RelativeJacobian relative_jacobian(const Pose2& from, const Pose2& to);

/// The column of each node's x among those of all nodes but `held`; -1 for that one.
std::vector<int> pose_columns(int nodes, int held);

/// Moves each pose by its three elements of `step`.
void move_poses(const std::vector<int>& columns, const Eigen::VectorXd& step,
                std::vector<Pose2>& poses);

/// The normal equations of a graph with one node held, their pattern analysed once for any number
/// of linearisations.
class NormalEquations {
 public:
  NormalEquations(const PoseGraph& graph, int held);

  int size() const { return H_.size(); }
  int column(int node) const { return columns_[node]; }  ///< of its x; -1 for the held one
  const std::vector<int>& columns() const { return columns_; }

  void linearise(const PoseGraph& graph);
  /// False when the equations cannot be solved.
  bool factorise(double damping) { return H_.factorise(damping); }
  double promised_gain() const;              ///< of chi2, by a whole step, were the graph linear
  double work() const { return H_.work(); }  ///< multiplications of a factorisation

  Eigen::VectorXd step() const { return H_.solve(-gradient_); }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const { return H_.solve(right); }
  /// Vectors of the covariance that the equations are the inverse of, from ones of independent unit
  /// normals.
  Eigen::MatrixXd coloured(const Eigen::MatrixXd& white) const { return H_.coloured(white); }

  void move(const Eigen::VectorXd& step, std::vector<Pose2>& poses) const {
    move_poses(columns_, step, poses);
  }

 private:
  std::vector<int> columns_;
  PoseMatrix H_;
  std::vector<PoseMatrix::Place> places_;  ///< of each edge
  Eigen::VectorXd gradient_;
};

}  // namespace panoptes
