// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "core/geometry/pose2.h"

namespace panoptes {

/// A symmetric positive definite matrix of 3x3 blocks, one row and column of blocks a pose: the
/// information of poses of which each is measured against few others. Its pattern is analysed once
/// for any number of values.
class PoseMatrix {
 public:
  /// Where a block off the diagonal lies; nowhere when one of its poses is held.
  struct Place {
    std::array<int, 3> of_column{-1, -1, -1};
  };

  /// Columns are of a pose's x; `joined` are pairs of columns whose block may differ from zero.
  PoseMatrix(int size, const std::vector<std::pair<int, int>>& joined);

  int size() const { return static_cast<int>(values_.rows()); }
  /// Of the block in the lower half.
  Place place(int column, int other) const;

  void clear();
  void add(int column, const Mat3& block);
  /// `block` as it lies below the diagonal: its rows those of the pose with the higher column.
  void add(const Place& place, const Mat3& block);

  bool factorise(double damping);                 ///< false when it is not positive definite
  double work() const { return solver_.work(); }  ///< multiplications of a factorisation
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const { return solver_.solve(right); }
  /// Vectors of the covariance that the matrix is the inverse of, from ones of independent unit
  /// normals.
  Eigen::MatrixXd coloured(const Eigen::MatrixXd& white) const;

 private:
  // Its pattern known, half the squares of the columns' lengths.
  struct Solver : Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> {
    double work() const { return 0.5 * m_nonZerosPerCol.cast<double>().squaredNorm(); }
  };

  int find(int row, int column) const;

  std::vector<int> diagonal_;
  Eigen::SparseMatrix<double> values_;  ///< the lower half
  Eigen::SparseMatrix<double> damped_;
  Solver solver_;
};

}  // namespace panoptes
