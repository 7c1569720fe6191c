// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "core/graph/pose_graph.h"

namespace panoptes {

/// What an edge says is wrong with two poses: the translation in the frame of `from`, and the turn.
Vec3 residual_of(const GraphEdge& edge, const Pose2& from, const Pose2& to);

/// How the pose of `to` seen from `from` changes with each of the two, as they lie in `map`.
struct RelativeJacobian {
  Mat3 from;
  Mat3 to;
};
RelativeJacobian relative_jacobian(const Pose2& from, const Pose2& to);

/// The normal equations of a graph with one node held, their pattern analysed once for any number
/// of linearisations.
class NormalEquations {
 public:
  NormalEquations(const PoseGraph& graph, int held);

  int size() const { return size_; }
  int column(int node) const { return columns_[node]; }  ///< of its x; -1 for the held one
  const std::vector<int>& columns() const { return columns_; }

  void linearise(const PoseGraph& graph);
  bool factorise(double damping);  ///< false when the equations cannot be solved
  double promised_gain() const;    ///< of chi2, by a whole step, were the graph linear
  double work() const { return solver_.work(); }  ///< multiplications of a factorisation

  Eigen::VectorXd step() const { return solver_.solve(-gradient_); }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const { return solver_.solve(right); }
  /// Vectors of the covariance that the equations are the inverse of, from ones of independent unit
  /// normals.
  Eigen::MatrixXd coloured(const Eigen::MatrixXd& white) const;

  void move(const Eigen::VectorXd& step, std::vector<Pose2>& poses) const;

 private:
  // Its pattern known, half the squares of the columns' lengths.
  struct Solver : Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> {
    double work() const { return 0.5 * m_nonZerosPerCol.cast<double>().squaredNorm(); }
  };

  int place(int row, int column) const;
  void add_diagonal(double* values, int k, const Mat3& block);

  int size_ = 0;
  std::vector<int> columns_;
  std::vector<int> diagonal_;
  std::vector<std::array<int, 3>> slots_;
  Eigen::SparseMatrix<double> H_;  ///< the lower half
  Eigen::SparseMatrix<double> damped_;
  Eigen::VectorXd gradient_;
  Solver solver_;
};

}  // namespace panoptes
