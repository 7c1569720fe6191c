// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/shared_equations.h"

#include "core/graph/normal_equations.h"

namespace panoptes {
namespace {

using ByState = Eigen::Matrix<double, Eigen::Dynamic, 3>;

std::vector<std::pair<int, int>> joined(const SharedGraph& graph, const std::vector<int>& columns) {
  std::vector<std::pair<int, int>> pairs;
  const auto add = [&](int a, int b) {
    if (columns[a] >= 0 && columns[b] >= 0) {
      pairs.emplace_back(columns[a], columns[b]);
    }
  };
  for (const JointEdge& joint : graph.joints) {
    const int end = joint.first + 1 + static_cast<int>(joint.T_first_node.size());
    for (int a = joint.first; a < end; ++a) {
      for (int b = a + 1; b < end; ++b) {
        add(a, b);
      }
    }
  }
  for (const SharedEdge& shared : graph.edges) {
    add(shared.edge.from, shared.edge.to);
  }
  return pairs;
}

}  // namespace

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

SharedEquations::SharedEquations(const SharedGraph& graph)
    : columns_(pose_columns(static_cast<int>(graph.T_map_node.size()), 0)),
      H_(3 * (static_cast<int>(columns_.size()) - 1), joined(graph, columns_)) {
  linearise(graph);
}

void SharedEquations::linearise(const SharedGraph& graph) {
  H_.clear();
  const Eigen::Index states = graph.state.size();
  border_ = Eigen::MatrixXd::Zero(poses(), states);
  state_information_ = graph.prior_information;
  gradient_ = {Eigen::VectorXd::Zero(poses()), graph.prior_information * graph.state};
  for (const JointEdge& joint : graph.joints) {
    add(joint, graph);
  }
  for (const SharedEdge& shared : graph.edges) {
    add(shared, graph);
  }
}

bool SharedEquations::factorise(double damping) {
  if (!H_.factorise(damping)) {
    return false;
  }
  by_border_ = H_.solve(border_);
  Eigen::MatrixXd schur = state_information_ - border_.transpose() * by_border_;
  schur.diagonal() += damping * state_information_.diagonal();
  schur_.compute(0.5 * (schur + schur.transpose()));
  return schur_.info() == Eigen::Success;
}

SharedEquations::Unknowns SharedEquations::solve(const Unknowns& right) const {
  const Eigen::MatrixXd states = schur_.solve(right.states - by_border_.transpose() * right.poses);
  return {H_.solve(right.poses) - by_border_ * states, states};
}

SharedEquations::Unknowns SharedEquations::step() const {
  return solve({-gradient_.poses, -gradient_.states});
}

double SharedEquations::promised_gain(const Unknowns& step) const {
  return -gradient_.poses.col(0).dot(step.poses.col(0)) -
         gradient_.states.col(0).dot(step.states.col(0));
}

void SharedEquations::move(const Unknowns& step, SharedGraph& graph) const {
  move_poses(columns_, step.poses.col(0), graph.T_map_node);
  graph.state += step.states.col(0);
}

Eigen::MatrixXd SharedEquations::state_covariance() const {
  return schur_.solve(Eigen::MatrixXd::Identity(border_.cols(), border_.cols()));
}

// A block of two poses, either of which may be held.
void SharedEquations::add_pair(int row, int column, const Mat3& block) {
  if (row >= 0 && column >= 0) {
    H_.add(H_.place(row, column), row > column ? block : Mat3(block.transpose()));
  }
}

// Each residual but the states' depends on the first node and on one other.
void SharedEquations::add(const JointEdge& joint, const SharedGraph& graph) {
  const int count = static_cast<int>(joint.T_first_node.size());
  const Eigen::Index states = graph.state.size();
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
  ByState states_first = ByState::Zero(states, 3);
  for (int i = 0; i < count; ++i) {
    const int here = column(joint.first + 1 + i);
    Mat3 with_first = Mat3::Zero();
    for (int j = 0; j < count; ++j) {
      const Mat3 W_ji = W.block<3, 3>(3 * j, 3 * i);
      with_first += J[j].from.transpose() * W_ji;
      if (j < i) {
        add_pair(column(joint.first + 1 + j), here, J[j].to.transpose() * W_ji * J[i].to);
      }
    }
    const auto W_si = W.block(3 * count, 3 * i, states, 3);
    const auto weighted_i = weighted.segment<3>(3 * i);
    of_first += with_first * J[i].from;
    states_first += W_si * J[i].from;
    gradient_first += J[i].from.transpose() * weighted_i;
    // the held node is the first of all, so of a joint it is the first as well
    H_.add(here, J[i].to.transpose() * W.block<3, 3>(3 * i, 3 * i) * J[i].to);
    gradient_.poses.middleRows<3>(here) += J[i].to.transpose() * weighted_i;
    border_.middleRows<3>(here) += J[i].to.transpose() * W_si.transpose();
    add_pair(first, here, with_first * J[i].to);
  }
  if (first >= 0) {
    H_.add(first, of_first);
    gradient_.poses.middleRows<3>(first) += gradient_first;
    border_.middleRows<3>(first) += states_first.transpose();
  }
  state_information_ += W.bottomRightCorner(states, states);
  gradient_.states += weighted.tail(states);
}

void SharedEquations::add(const SharedEdge& shared, const SharedGraph& graph) {
  const GraphEdge edge = at_state(shared, graph.state);
  const Pose2& from = graph.T_map_node[edge.from];
  const Pose2& to = graph.T_map_node[edge.to];
  const RelativeJacobian J = relative_jacobian(from, to);
  const Vec3 weighted = edge.information * panoptes::residual_of(edge, from, to);
  const bool depends = shared.by_state.size() > 0;
  const auto add_end = [&](int here, const Mat3& by_pose) {
    if (here < 0) {
      return;
    }
    H_.add(here, by_pose.transpose() * edge.information * by_pose);
    gradient_.poses.middleRows<3>(here) += by_pose.transpose() * weighted;
    if (depends) {
      border_.middleRows<3>(here) -= by_pose.transpose() * edge.information * shared.by_state;
    }
  };
  add_end(column(edge.from), J.from);
  add_end(column(edge.to), J.to);
  add_pair(column(edge.from), column(edge.to), J.from.transpose() * edge.information * J.to);
  if (depends) {
    state_information_ += shared.by_state.transpose() * edge.information * shared.by_state;
    gradient_.states -= shared.by_state.transpose() * weighted;
  }
}

}  // namespace panoptes
