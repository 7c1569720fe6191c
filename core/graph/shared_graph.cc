// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/shared_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/base/check.h"
#include "core/geometry/covariance.h"
#include "core/graph/normal_equations.h"
#include "core/graph/shared_equations.h"

namespace panoptes {
namespace {

constexpr int kMaxIterations = 50;
constexpr double kConverged = 1e-9;  // change of chi2, in shares, at which rounding decides
constexpr double kSettled = 1e-4;    // gain of chi2 that no measurement could tell
constexpr double kMostDamping = 1e6;

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
  SharedEquations equations(graph);
  double damping = 0;
  while (report.iterations < kMaxIterations && !report.converged && damping <= kMostDamping) {
    ++report.iterations;
    const std::vector<Pose2> T_map_node = graph.T_map_node;
    const Eigen::VectorXd state = graph.state;
    double then = std::numeric_limits<double>::infinity();
    double promised = then;
    if (equations.factorise(damping)) {
      const SharedEquations::Unknowns step = equations.step();
      if (step.poses.allFinite() && step.states.allFinite()) {
        promised = equations.promised_gain(step);
        equations.move(step, graph);
        then = chi2(graph);
      }
    }
    const double tolerance = kConverged * (1 + std::abs(now));
    if (then <= now + tolerance) {
      report.converged = now - then <= tolerance || (damping == 0 && promised <= kSettled);
      now = then;
      damping = damping > 1e-6 ? damping / 10 : 0;
      if (!report.converged) {
        equations.linearise(graph);
      }
    } else {
      graph.T_map_node = T_map_node;
      graph.state = state;
      damping = damping > 0 ? 10 * damping : 1e-6;
    }
  }
  report.chi2_end = now;
  return report;
}

struct SharedUncertainty::Solved {
  explicit Solved(const SharedGraph& graph) : equations(graph), T_map_node(graph.T_map_node) {}

  SharedEquations equations;
  std::vector<Pose2> T_map_node;
};

SharedUncertainty::SharedUncertainty(const SharedGraph& graph)
    : states_(graph.prior_information.inverse()) {
  if (graph.T_map_node.size() < 2) {
    return;
  }
  auto solved = std::make_shared<Solved>(graph);
  if (solved->equations.factorise(0)) {
    states_ = solved->equations.state_covariance();
    solved_ = std::move(solved);
  }
}

Mat3 SharedUncertainty::relative(int from, int to, const Eigen::MatrixXd& by_state) const {
  PANOPTES_CHECK(from != to, "two nodes");
  if (solved_ == nullptr) {
    return unknown_covariance();
  }
  const SharedEquations& equations = solved_->equations;
  const RelativeJacobian J = relative_jacobian(solved_->T_map_node[from], solved_->T_map_node[to]);
  SharedEquations::Unknowns of{Eigen::MatrixXd::Zero(equations.poses(), 3),
                               Eigen::MatrixXd::Zero(states_.rows(), 3)};
  for (const auto& [node, by_pose] : {std::pair{from, J.from}, std::pair{to, J.to}}) {
    if (equations.column(node) >= 0) {
      of.poses.middleRows<3>(equations.column(node)) = by_pose.transpose();
    }
  }
  if (by_state.size() > 0) {
    of.states = -by_state.transpose();
  }
  const SharedEquations::Unknowns solved = equations.solve(of);
  const Mat3 covariance =
      of.poses.transpose() * solved.poses + of.states.transpose() * solved.states;
  return 0.5 * (covariance + covariance.transpose());
}

Eigen::MatrixXd state_covariance(const SharedGraph& graph) {
  return SharedUncertainty(graph).states();
}

StateSystem of_states(const JointEdge& joint, const Eigen::VectorXd& state) {
  const auto poses = static_cast<Eigen::Index>(3 * joint.T_first_node.size());
  const Eigen::Index states = state.size();
  const Eigen::MatrixXd K = joint.information.topLeftCorner(poses, poses)
                                .ldlt()
                                .solve(joint.information.topRightCorner(poses, states));
  StateSystem of;
  of.information = joint.information.bottomRightCorner(states, states) -
                   joint.information.bottomLeftCorner(states, poses) * K;
  of.gradient = of.information * (state - joint.state) + joint.gradient.tail(states) -
                K.transpose() * joint.gradient.head(poses);
  return of;
}

namespace {

void forget(JointEdge& joint, Eigen::Index first, Eigen::Index count) {
  joint.information.middleRows(first, count).setZero();
  joint.information.middleCols(first, count).setZero();
  joint.gradient.segment(first, count).setZero();
}

}  // namespace

void hold(JointEdge& joint, int first, int count, const Eigen::VectorXd& state) {
  const Eigen::Index at = joint.information.rows() - joint.state.size() + first;
  const Eigen::VectorXd off = (state - joint.state).segment(first, count);
  joint.gradient += joint.information.middleCols(at, count) * off;
  forget(joint, at, count);
}

void hold(SharedEdge& shared, int first, int count, const Eigen::VectorXd& state) {
  if (shared.by_state.size() == 0) {
    return;
  }
  Eigen::VectorXd held = shared.state;
  held.segment(first, count) = state.segment(first, count);
  shared.edge = at_state(shared, held);
  shared.state = held;
  shared.by_state.middleCols(first, count).setZero();
}

double variance_factor(const SharedGraph& graph) {
  const Eigen::Index states = graph.state.size();
  Eigen::MatrixXd claimed = Eigen::MatrixXd::Zero(states, states);
  Eigen::MatrixXd scatter = claimed;
  for (const JointEdge& joint : graph.joints) {
    const StateSystem of = of_states(joint, graph.state);
    claimed += of.information;
    scatter += of.gradient * of.gradient.transpose();
  }
  const Eigen::LDLT<Eigen::MatrixXd> all(claimed + graph.prior_information);
  const double shown = all.solve(claimed).trace();  // how many states, as it were
  // the states are where the edges agree best, which takes as much from their scatter as one does
  const auto count = static_cast<double>(graph.joints.size());
  if (count < 2 || !(shown > 0)) {
    return 1;
  }
  return std::max(1.0, all.solve(scatter).trace() / shown * count / (count - 1));
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

std::vector<Mat3> path_covariances(const SharedGraph& graph, int from,
                                   const Eigen::MatrixXd& state_covariance) {
  PoseGraph plain{graph.T_map_node, {}};
  SharedStates states{{}, state_covariance};
  for (const SharedEdge& shared : all_pairwise(graph)) {
    plain.edges.push_back(shared.edge);
    states.by_state.push_back(shared.by_state);
  }
  return path_covariances(plain, from, &states);
}

}  // namespace panoptes
