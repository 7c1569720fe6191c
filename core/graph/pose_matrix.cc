// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/pose_matrix.h"

#include <algorithm>
#include <limits>

namespace panoptes {

PoseMatrix::PoseMatrix(int size, const std::vector<std::pair<int, int>>& joined)
    : diagonal_(size), values_(size, size) {
  std::vector<Eigen::Triplet<double>> triplets;
  const auto add_block = [&](int row, int column) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        if (row + r >= column + c) {
          triplets.emplace_back(row + r, column + c, 0.0);
        }
      }
    }
  };
  for (int column = 0; column < size; column += 3) {
    add_block(column, column);
  }
  for (const auto& [a, b] : joined) {
    add_block(std::max(a, b), std::min(a, b));
  }
  values_.setFromTriplets(triplets.begin(), triplets.end());
  values_.makeCompressed();
  for (int k = 0; k < size; ++k) {
    diagonal_[k] = find(k, k);
  }
  solver_.analyzePattern(values_);
}

// Where the element lies among the values; a block's rows follow one another in its column.
int PoseMatrix::find(int row, int column) const {
  const int* begin = values_.innerIndexPtr() + values_.outerIndexPtr()[column];
  const int* end = values_.innerIndexPtr() + values_.outerIndexPtr()[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - values_.innerIndexPtr());
}

PoseMatrix::Place PoseMatrix::place(int column, int other) const {
  Place place;
  if (column >= 0 && other >= 0) {
    for (int c = 0; c < 3; ++c) {
      place.of_column[c] = find(std::max(column, other), std::min(column, other) + c);
    }
  }
  return place;
}

void PoseMatrix::clear() {
  std::fill(values_.valuePtr(), values_.valuePtr() + values_.nonZeros(), 0.0);
}

void PoseMatrix::add(int column, const Mat3& block) {
  for (int c = 0; c < 3; ++c) {
    for (int r = c; r < 3; ++r) {
      values_.valuePtr()[diagonal_[column + c] + r - c] += block(r, c);
    }
  }
}

void PoseMatrix::add(const Place& place, const Mat3& block) {
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) {
      values_.valuePtr()[place.of_column[c] + r] += block(r, c);
    }
  }
}

bool PoseMatrix::factorise(double damping) {
  if (damping > 0) {
    damped_ = values_;
    for (const int k : diagonal_) {
      double& value = damped_.valuePtr()[k];
      value += damping * value + std::numeric_limits<double>::min();
    }
    solver_.factorize(damped_);
  } else {
    solver_.factorize(values_);
  }
  // a pivot that is not a number is no error to the solver
  return solver_.info() == Eigen::Success && solver_.vectorD().allFinite();
}

Eigen::MatrixXd PoseMatrix::coloured(const Eigen::MatrixXd& white) const {
  // P H P^T = L D L^T, so P^T L^-T D^-1/2 white has the covariance H^-1
  Eigen::MatrixXd drawn =
      solver_.vectorD().cwiseMax(0).cwiseSqrt().cwiseInverse().asDiagonal() * white;
  solver_.matrixU().solveInPlace(drawn);
  return solver_.permutationPinv() * drawn;
}

}  // namespace panoptes
