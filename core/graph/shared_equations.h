// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "core/graph/pose_matrix.h"
#include "core/graph/shared_graph.h"

namespace panoptes {

/// What a joint edge says is wrong: of each node but its first, then of the states.
Eigen::VectorXd residual_of(const JointEdge& joint, const SharedGraph& graph);

/// The edge as it reads with the states at `state`.
GraphEdge at_state(const SharedEdge& shared, const Eigen::VectorXd& state);

/// The normal equations of a graph with the first node held. The poses' part is sparse; the states
/// are a border of it, eliminated last (Schur complement), which no pose's elimination fills.
class SharedEquations {
 public:
  explicit SharedEquations(const SharedGraph& graph);

  void linearise(const SharedGraph& graph);
  bool factorise(double damping);  ///< false when the equations cannot be solved

  /// Rows of all poses' elements, and of the states.
  struct Unknowns {
    Eigen::MatrixXd poses;
    Eigen::MatrixXd states;
  };
  Unknowns step() const;
  Unknowns solve(const Unknowns& right) const;
  double promised_gain(const Unknowns& step) const;  ///< of chi2, were the graph linear
  void move(const Unknowns& step, SharedGraph& graph) const;

  int column(int node) const { return columns_[node]; }  ///< -1 for the held one
  int poses() const { return H_.size(); }
  /// The marginal of the states.
  Eigen::MatrixXd state_covariance() const;

 private:
  void add_pair(int row, int column, const Mat3& block);
  void add(const JointEdge& joint, const SharedGraph& graph);
  void add(const SharedEdge& shared, const SharedGraph& graph);

  std::vector<int> columns_;
  PoseMatrix H_;
  Eigen::MatrixXd border_;  ///< a row a pose's element, a column a state
  Eigen::MatrixXd state_information_;
  Unknowns gradient_;
  Eigen::MatrixXd by_border_;  ///< H^-1 border
  Eigen::LLT<Eigen::MatrixXd> schur_;
};

}  // namespace panoptes
