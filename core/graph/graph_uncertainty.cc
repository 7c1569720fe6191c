// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/graph_uncertainty.h"

#include "core/base/check.h"
#include "core/base/rng.h"
#include "core/geometry/covariance.h"
#include "core/graph/normal_equations.h"

namespace panoptes {
namespace {

constexpr int kDraws = 64;
constexpr double kSmallestDamping = 1e-9;  // of the diagonal: keeps loose nodes solvable

}  // namespace

struct GraphUncertainty::Equations {
  explicit Equations(const PoseGraph& graph) : normals(graph, 0), T_map_node(graph.T_map_node) {
    normals.linearise(graph);
    solved = normals.factorise(0) || normals.factorise(kSmallestDamping);
    if (!solved) {
      return;
    }
    Rng rng = Rng(1).fork("graph-uncertainty");
    Eigen::MatrixXd white(normals.size(), kDraws);
    for (Eigen::Index k = 0; k < white.size(); ++k) {
      white.data()[k] = rng.normal();
    }
    // a node's three numbers of a draw beside those of the next draw
    const Eigen::MatrixXd drawn = normals.coloured(white);
    draws.assign(T_map_node.size(), Eigen::Matrix<double, 3, kDraws>::Zero());
    for (std::size_t node = 0; node < draws.size(); ++node) {
      const int column = normals.column(static_cast<int>(node));
      if (column >= 0) {
        draws[node] = drawn.middleRows<3>(column);
      }
    }
  }

  NormalEquations normals;
  std::vector<Pose2> T_map_node;
  std::vector<Eigen::Matrix<double, 3, kDraws>> draws;
  bool solved = false;
};

GraphUncertainty::GraphUncertainty(const PoseGraph& graph)
    : equations_(std::make_unique<const Equations>(graph)) {}
GraphUncertainty::~GraphUncertainty() = default;

Mat3 GraphUncertainty::relative(int from, int to) const {
  PANOPTES_CHECK(from != to, "two nodes");
  if (!equations_->solved) {
    return unknown_covariance();
  }
  const NormalEquations& normals = equations_->normals;
  const RelativeJacobian J =
      relative_jacobian(equations_->T_map_node[from], equations_->T_map_node[to]);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(normals.size(), 3);
  const int a = normals.column(from);
  const int b = normals.column(to);
  if (a >= 0) {
    right.block<3, 3>(a, 0) = J.from.transpose();
  }
  if (b >= 0) {
    right.block<3, 3>(b, 0) = J.to.transpose();
  }
  const Eigen::MatrixXd solved = normals.solve(right);
  Mat3 covariance = Mat3::Zero();
  if (a >= 0) {
    covariance += J.from * solved.block<3, 3>(a, 0);
  }
  if (b >= 0) {
    covariance += J.to * solved.block<3, 3>(b, 0);
  }
  return 0.5 * (covariance + covariance.transpose());
}

Mat3 GraphUncertainty::relative_roughly(int from, int to) const {
  PANOPTES_CHECK(from != to, "two nodes");
  if (!equations_->solved) {
    return unknown_covariance();
  }
  const RelativeJacobian J =
      relative_jacobian(equations_->T_map_node[from], equations_->T_map_node[to]);
  const Eigen::Matrix<double, 3, kDraws> off =
      J.from * equations_->draws[from] + J.to * equations_->draws[to];
  return off * off.transpose() / kDraws;
}

}  // namespace panoptes
