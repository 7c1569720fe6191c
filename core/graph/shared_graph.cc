// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/shared_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "core/base/check.h"
#include "core/geometry/covariance.h"
#include "core/graph/normal_equations.h"

namespace panoptes {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr int kMaxIterations = 50;
constexpr double kConverged = 1e-9;  // change of chi2 at which nothing more is gained
constexpr double kMostDamping = 1e6;

// What a joint edge says is wrong: of each node but its first, then of the states.
Eigen::VectorXd residual_of(const JointEdge& joint, const SharedGraph& graph) {
  const int nodes = static_cast<int>(joint.T_first_node.size());
  Eigen::VectorXd r(3 * nodes + graph.state.size());
  for (int i = 0; i < nodes; ++i) {
    const GraphEdge edge{joint.first, joint.first + 1 + i, joint.T_first_node[i], {}, false};
    r.segment<3>(3 * i) = residual_of(edge, graph.T_map_node[edge.from], graph.T_map_node[edge.to]);
  }
  r.tail(graph.state.size()) = graph.state - joint.state;
  return r;
}

GraphEdge at_state(const SharedEdge& shared, const Eigen::VectorXd& state) {
  GraphEdge edge = shared.edge;
  if (shared.by_state.size() > 0) {
    const Vec3 moved = shared.by_state * (state - shared.state);
    edge.T_from_to = {edge.T_from_to.x_m + moved.x(), edge.T_from_to.y_m + moved.y(),
                      wrap_angle(edge.T_from_to.theta_rad + moved.z())};
  }
  return edge;
}

// The normal equations of a graph: columns of nodes, one held, and of the states last.
class SharedEquations {
 public:
  SharedEquations(const SharedGraph& graph, int held) : held_(held) {
    nodes_ = static_cast<int>(graph.T_map_node.size());
    states_ = static_cast<int>(graph.state.size());
    linearise(graph);
  }

  int column(int node) const { return node == held_ ? -1 : 3 * (node - (node > held_ ? 1 : 0)); }
  int state_column() const { return 3 * (nodes_ - 1); }
  int size() const { return state_column() + states_; }

  void linearise(const SharedGraph& graph) {
    gradient_ = Eigen::VectorXd::Zero(size());
    state_information_ = graph.prior_information;
    gradient_.tail(states_) = graph.prior_information * graph.state;
    triplets_.clear();
    for (const JointEdge& joint : graph.joints) {
      add(joint, graph);
    }
    for (const SharedEdge& shared : graph.edges) {
      add(shared, graph);
    }
    for (int row = 0; row < states_; ++row) {
      for (int column = 0; column <= row; ++column) {
        triplets_.emplace_back(state_column() + row, state_column() + column,
                               state_information_(row, column));
      }
    }
    H_.resize(size(), size());
    H_.setFromTriplets(triplets_.begin(), triplets_.end());
  }

  bool factorise(double damping) {
    Sparse damped = H_;
    if (damping > 0) {
      for (int k = 0; k < size(); ++k) {
        damped.coeffRef(k, k) *= 1 + damping;
      }
    }
    solver_.compute(damped);
    return solver_.info() == Eigen::Success;
  }

  Eigen::VectorXd step() const { return solver_.solve(-gradient_); }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const { return solver_.solve(right); }

  void move(const Eigen::VectorXd& step, SharedGraph& graph) const {
    for (int node = 0; node < nodes_; ++node) {
      if (node != held_) {
        const auto d = step.segment<3>(column(node));
        Pose2& pose = graph.T_map_node[node];
        pose = {pose.x_m + d.x(), pose.y_m + d.y(), wrap_angle(pose.theta_rad + d.z())};
      }
    }
    graph.state += step.tail(states_);
  }

 private:
  void add_block(int row, int column, const Mat3& block) {
    if (row < 0 || column < 0 || row < column) {
      return;  // held, or of the other half
    }
    for (int j = 0; j < 3; ++j) {
      for (int i = row == column ? j : 0; i < 3; ++i) {
        triplets_.emplace_back(row + i, column + j, block(i, j));
      }
    }
  }

  // `J` has a row a residual, three columns a node of `at` and then the states'.
  void add(const Eigen::MatrixXd& J, const std::vector<int>& at, const Eigen::MatrixXd& W,
           const Eigen::VectorXd& weighted) {
    const Eigen::MatrixXd H = J.transpose() * W * J;
    const Eigen::VectorXd g = J.transpose() * weighted;
    const int count = static_cast<int>(at.size());
    for (int a = 0; a < count; ++a) {
      const int row = at[a];
      if (row < 0) {
        continue;
      }
      gradient_.segment<3>(row) += g.segment<3>(3 * a);
      for (int b = 0; b < count; ++b) {
        add_block(row, at[b], H.block<3, 3>(3 * a, 3 * b));
      }
      if (J.cols() > 3 * count) {
        for (int s = 0; s < states_; ++s) {
          for (int k = 0; k < 3; ++k) {
            triplets_.emplace_back(state_column() + s, row + k, H(3 * count + s, 3 * a + k));
          }
        }
      }
    }
    if (J.cols() > 3 * count) {
      state_information_ += H.bottomRightCorner(states_, states_);
      gradient_.tail(states_) += g.tail(states_);
    }
  }

  // Of two different columns, whichever half it is of.
  void add_pair(int row, int column, const Mat3& block) {
    add_block(row, column, block);
    add_block(column, row, block.transpose());
  }

  void add_states(int column, const Eigen::Matrix<double, Eigen::Dynamic, 3>& block) {
    for (int s = 0; column >= 0 && s < states_; ++s) {
      for (int k = 0; k < 3; ++k) {
        triplets_.emplace_back(state_column() + s, column + k, block(s, k));
      }
    }
  }

  // Each residual but the states' depends on the first node and on one other.
  void add(const JointEdge& joint, const SharedGraph& graph) {
    const int count = static_cast<int>(joint.T_first_node.size());
    const Eigen::MatrixXd& W = joint.information;
    const Eigen::VectorXd weighted = W * residual_of(joint, graph) + joint.gradient;
    std::vector<RelativeJacobian> J;
    for (int i = 0; i < count; ++i) {
      J.push_back(
          relative_jacobian(graph.T_map_node[joint.first], graph.T_map_node[joint.first + 1 + i]));
    }
    const int first = column(joint.first);
    Mat3 of_first = Mat3::Zero();
    Vec3 gradient_first = Vec3::Zero();
    Eigen::Matrix<double, Eigen::Dynamic, 3> states_first =
        Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(states_, 3);
    for (int i = 0; i < count; ++i) {
      const int here = column(joint.first + 1 + i);
      Mat3 with_first = Mat3::Zero();
      for (int j = 0; j < count; ++j) {
        const Mat3 W_ji = W.block<3, 3>(3 * j, 3 * i);
        with_first += J[j].from.transpose() * W_ji;
        if (j < i && here >= 0) {
          add_pair(column(joint.first + 1 + j), here, J[j].to.transpose() * W_ji * J[i].to);
        }
      }
      of_first += with_first * J[i].from;
      const Eigen::Matrix<double, Eigen::Dynamic, 3> W_si = W.block(3 * count, 3 * i, states_, 3);
      states_first += W_si * J[i].from;
      const auto weighted_i = weighted.segment<3>(3 * i);
      gradient_first += J[i].from.transpose() * weighted_i;
      if (here >= 0) {
        add_block(here, here, J[i].to.transpose() * W.block<3, 3>(3 * i, 3 * i) * J[i].to);
        gradient_.segment<3>(here) += J[i].to.transpose() * weighted_i;
        if (first >= 0) {
          add_pair(first, here, with_first * J[i].to);
        }
      }
      add_states(here, W_si * J[i].to);
    }
    if (first >= 0) {
      add_block(first, first, of_first);
      gradient_.segment<3>(first) += gradient_first;
    }
    add_states(first, states_first);
    state_information_ += W.bottomRightCorner(states_, states_);
    gradient_.tail(states_) += weighted.tail(states_);
  }

  void add(const SharedEdge& shared, const SharedGraph& graph) {
    const GraphEdge edge = at_state(shared, graph.state);
    const Pose2& from = graph.T_map_node[edge.from];
    const Pose2& to = graph.T_map_node[edge.to];
    const RelativeJacobian jacobian = relative_jacobian(from, to);
    const bool depends = shared.by_state.size() > 0;
    Eigen::MatrixXd J(3, 6 + (depends ? states_ : 0));
    J.leftCols<3>() = jacobian.from;
    J.middleCols<3>(3) = jacobian.to;
    if (depends) {
      J.rightCols(states_) = -shared.by_state;
    }
    add(J, {column(edge.from), column(edge.to)}, edge.information,
        edge.information * panoptes::residual_of(edge, from, to));
  }

  int held_;
  int nodes_ = 0;
  int states_ = 0;
  std::vector<Eigen::Triplet<double>> triplets_;
  Eigen::MatrixXd state_information_;
  Eigen::VectorXd gradient_;
  Sparse H_;  // the lower half
  Eigen::SimplicialLDLT<Sparse> solver_;
};

}  // namespace

double chi2(const SharedGraph& graph) {
  double sum = graph.state.dot(graph.prior_information * graph.state);
  for (const JointEdge& joint : graph.joints) {
    const Eigen::VectorXd r = residual_of(joint, graph);
    sum += r.dot(joint.information * r) + 2 * joint.gradient.dot(r);
  }
  for (const SharedEdge& shared : graph.edges) {
    const GraphEdge edge = at_state(shared, graph.state);
    const Vec3 r =
        panoptes::residual_of(edge, graph.T_map_node[edge.from], graph.T_map_node[edge.to]);
    sum += r.dot(edge.information * r);
  }
  return sum;
}

RelaxReport relax(SharedGraph& graph) {
  RelaxReport report;
  double now = chi2(graph);
  report.chi2_start = now;
  if (graph.T_map_node.size() < 2) {
    report.chi2_end = now;
    report.converged = true;
    return report;
  }
  SharedEquations equations(graph, 0);
  double damping = 0;
  while (report.iterations < kMaxIterations && !report.converged && damping <= kMostDamping) {
    ++report.iterations;
    SharedGraph tried = graph;
    double then = std::numeric_limits<double>::infinity();
    if (equations.factorise(damping)) {
      const Eigen::VectorXd step = equations.step();
      if (step.allFinite()) {
        equations.move(step, tried);
        then = chi2(tried);
      }
    }
    const double tolerance = kConverged * (1 + std::abs(now));
    if (then <= now + tolerance) {
      report.converged = now - then <= tolerance;
      now = then;
      graph = std::move(tried);
      damping = damping > 1e-6 ? damping / 10 : 0;
      if (!report.converged) {
        equations.linearise(graph);
      }
    } else {
      damping = damping > 0 ? 10 * damping : 1e-6;
    }
  }
  report.chi2_end = now;
  return report;
}

Eigen::MatrixXd state_covariance(const SharedGraph& graph) {
  const Eigen::Index states = graph.state.size();
  if (graph.T_map_node.size() < 2) {
    return graph.prior_information.inverse();
  }
  SharedEquations equations(graph, 0);
  if (!equations.factorise(0)) {
    return graph.prior_information.inverse();
  }
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(equations.size(), states);
  right.bottomRows(states).setIdentity();
  const Eigen::MatrixXd covariance = equations.solve(right).bottomRows(states);
  return 0.5 * (covariance + covariance.transpose());
}

Mat3 relative_covariance(const SharedGraph& graph, int from, int to,
                         const Eigen::MatrixXd& by_state) {
  PANOPTES_CHECK(from != to, "two nodes");
  SharedEquations equations(graph, from);
  if (!equations.factorise(0)) {
    return unknown_covariance();
  }
  Mat3 R_from_map = Mat3::Identity();
  R_from_map.topLeftCorner<2, 2>() = graph.T_map_node[from].rotation().transpose();
  Eigen::MatrixXd of = Eigen::MatrixXd::Zero(equations.size(), 3);
  of.block<3, 3>(equations.column(to), 0) = R_from_map.transpose();
  if (by_state.size() > 0) {
    of.bottomRows(graph.state.size()) = -by_state.transpose();
  }
  const Mat3 covariance = of.transpose() * equations.solve(of);
  return 0.5 * (covariance + covariance.transpose());
}

std::vector<SharedEdge> pairwise_edges(const JointEdge& joint, const Eigen::VectorXd& state) {
  const int count = static_cast<int>(joint.T_first_node.size());
  const Eigen::Index poses = 3 * count;
  const Eigen::Index states = joint.state.size();
  const Eigen::LDLT<Eigen::MatrixXd> solver(joint.information.topLeftCorner(poses, poses));
  const Eigen::MatrixXd by_state = -solver.solve(joint.information.topRightCorner(poses, states));
  const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(poses, poses));
  const Eigen::VectorXd moved =
      by_state * (state - joint.state) - solver.solve(joint.gradient.head(poses));
  std::vector<SharedEdge> edges;
  Pose2 before;
  for (int i = 0; i < count; ++i) {
    const auto d = moved.segment<3>(3 * i);
    const Pose2& told = joint.T_first_node[i];
    const Pose2 here{told.x_m + d.x(), told.y_m + d.y(), wrap_angle(told.theta_rad + d.z())};
    const RelativeJacobian jacobian = relative_jacobian(before, here);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, poses);
    if (i > 0) {
      J.middleCols<3>(3 * (i - 1)) = jacobian.from;
    }
    J.middleCols<3>(3 * i) = jacobian.to;
    const Mat3 information = (J * covariance * J.transpose()).inverse();
    edges.push_back({{joint.first + i, joint.first + i + 1, before.inverse() * here,
                      0.5 * (information + information.transpose()), false},
                     state,
                     J * by_state});
    before = here;
  }
  return edges;
}

namespace {

// All edges between two nodes each, as the states are now.
std::vector<SharedEdge> all_pairwise(const SharedGraph& graph) {
  std::vector<SharedEdge> edges;
  for (const JointEdge& joint : graph.joints) {
    const std::vector<SharedEdge> steps = pairwise_edges(joint, graph.state);
    edges.insert(edges.end(), steps.begin(), steps.end());
  }
  for (const SharedEdge& shared : graph.edges) {
    edges.push_back({at_state(shared, graph.state), graph.state, shared.by_state});
  }
  return edges;
}

}  // namespace

PoseGraph pairwise(const SharedGraph& graph) {
  PoseGraph out{graph.T_map_node, {}};
  const Eigen::MatrixXd covariance = state_covariance(graph);
  for (const SharedEdge& shared : all_pairwise(graph)) {
    GraphEdge edge = shared.edge;
    if (shared.by_state.size() > 0) {
      const Mat3 total = edge.information.inverse() +
                         Mat3(shared.by_state * covariance * shared.by_state.transpose());
      edge.information = inverse_of(0.5 * (total + total.transpose())).value_or(edge.information);
    }
    out.edges.push_back(edge);
  }
  return out;
}

std::vector<Mat3> path_covariances(const SharedGraph& graph, int from) {
  PoseGraph plain{graph.T_map_node, {}};
  SharedStates states{{}, state_covariance(graph)};
  for (const SharedEdge& shared : all_pairwise(graph)) {
    plain.edges.push_back(shared.edge);
    states.by_state.push_back(shared.by_state);
  }
  return path_covariances(plain, from, &states);
}

}  // namespace panoptes
