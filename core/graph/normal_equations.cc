// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/normal_equations.h"

#include <algorithm>
#include <limits>

namespace panoptes {

Vec3 residual_of(const GraphEdge& edge, const Pose2& from, const Pose2& to) {
  const Vec2 t =
      from.rotation().transpose() * (to.position() - from.position()) - edge.T_from_to.position();
  return {t.x(), t.y(), wrap_angle(to.theta_rad - from.theta_rad - edge.T_from_to.theta_rad)};
}

RelativeJacobian relative_jacobian(const Pose2& from, const Pose2& to) {
  const Mat2 Rt = from.rotation().transpose();
  const Vec2 t = Rt * (to.position() - from.position());
  RelativeJacobian J;
  J.from << -Rt(0, 0), -Rt(0, 1), t.y(), -Rt(1, 0), -Rt(1, 1), -t.x(), 0, 0, -1;
  J.to << Rt(0, 0), Rt(0, 1), 0, Rt(1, 0), Rt(1, 1), 0, 0, 0, 1;
  return J;
}

NormalEquations::NormalEquations(const PoseGraph& graph, int held) {
  const int nodes = static_cast<int>(graph.T_map_node.size());
  columns_.resize(nodes);
  int next = 0;
  for (int node = 0; node < nodes; ++node) {
    columns_[node] = node == held ? -1 : 3 * next++;
  }
  size_ = 3 * next;
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
  for (const int column : columns_) {
    if (column >= 0) {
      add_block(column, column);
    }
  }
  for (const GraphEdge& edge : graph.edges) {
    const int a = columns_[edge.from];
    const int b = columns_[edge.to];
    if (a >= 0 && b >= 0) {
      add_block(std::max(a, b), std::min(a, b));
    }
  }
  H_.resize(size_, size_);
  H_.setFromTriplets(triplets.begin(), triplets.end());
  H_.makeCompressed();
  diagonal_.resize(size_);
  for (int k = 0; k < size_; ++k) {
    diagonal_[k] = place(k, k);
  }
  slots_.reserve(graph.edges.size());
  for (const GraphEdge& edge : graph.edges) {
    const int a = columns_[edge.from];
    const int b = columns_[edge.to];
    std::array<int, 3> slots{-1, -1, -1};
    if (a >= 0 && b >= 0) {
      for (int c = 0; c < 3; ++c) {
        slots[c] = place(std::max(a, b), std::min(a, b) + c);
      }
    }
    slots_.push_back(slots);
  }
  solver_.analyzePattern(H_);
  gradient_.resize(size_);
}

void NormalEquations::linearise(const PoseGraph& graph) {
  double* values = H_.valuePtr();
  std::fill(values, values + H_.nonZeros(), 0.0);
  gradient_.setZero();
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const GraphEdge& edge = graph.edges[e];
    const Pose2& from = graph.T_map_node[edge.from];
    const Pose2& to = graph.T_map_node[edge.to];
    const RelativeJacobian J = relative_jacobian(from, to);
    const Vec3 weighted = edge.information * residual_of(edge, from, to);
    const Mat3 from_weighted = J.from.transpose() * edge.information;
    const Mat3 to_weighted = J.to.transpose() * edge.information;
    const int a = columns_[edge.from];
    const int b = columns_[edge.to];
    if (a >= 0) {
      add_diagonal(values, a, from_weighted * J.from);
      gradient_.segment<3>(a) += J.from.transpose() * weighted;
    }
    if (b >= 0) {
      add_diagonal(values, b, to_weighted * J.to);
      gradient_.segment<3>(b) += J.to.transpose() * weighted;
    }
    if (a >= 0 && b >= 0) {
      const Mat3 block = b > a ? Mat3(to_weighted * J.from) : Mat3(from_weighted * J.to);
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) {
          values[slots_[e][c] + r] += block(r, c);
        }
      }
    }
  }
}

bool NormalEquations::factorise(double damping) {
  if (damping > 0) {
    damped_ = H_;
    for (int k = 0; k < size_; ++k) {
      double& value = damped_.valuePtr()[diagonal_[k]];
      value += damping * value + std::numeric_limits<double>::min();
    }
    solver_.factorize(damped_);
  } else {
    solver_.factorize(H_);
  }
  // a pivot that is not a number is no error to the solver
  return solver_.info() == Eigen::Success && solver_.vectorD().allFinite();
}

double NormalEquations::promised_gain() const { return -gradient_.dot(step()); }

Eigen::MatrixXd NormalEquations::coloured(const Eigen::MatrixXd& white) const {
  // P H P^T = L D L^T, so P^T L^-T D^-1/2 white has the covariance H^-1
  Eigen::MatrixXd drawn =
      solver_.vectorD().cwiseMax(0).cwiseSqrt().cwiseInverse().asDiagonal() * white;
  solver_.matrixU().solveInPlace(drawn);
  return solver_.permutationPinv() * drawn;
}

void NormalEquations::move(const Eigen::VectorXd& step, std::vector<Pose2>& poses) const {
  for (std::size_t node = 0; node < poses.size(); ++node) {
    const int k = columns_[node];
    if (k >= 0) {
      poses[node] = {poses[node].x_m + step[k], poses[node].y_m + step[k + 1],
                     wrap_angle(poses[node].theta_rad + step[k + 2])};
    }
  }
}

// Where the element lies among the values; a block's rows follow one another in its column.
int NormalEquations::place(int row, int column) const {
  const int* begin = H_.innerIndexPtr() + H_.outerIndexPtr()[column];
  const int* end = H_.innerIndexPtr() + H_.outerIndexPtr()[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - H_.innerIndexPtr());
}

void NormalEquations::add_diagonal(double* values, int k, const Mat3& block) {
  for (int c = 0; c < 3; ++c) {
    for (int r = c; r < 3; ++r) {
      values[diagonal_[k + c] + r - c] += block(r, c);
    }
  }
}

}  // namespace panoptes
