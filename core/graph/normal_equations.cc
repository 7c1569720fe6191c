// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/normal_equations.h"

#include <cstddef>
#include <utility>

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

std::vector<int> pose_columns(int nodes, int held) {
  std::vector<int> columns(nodes);
  int next = 0;
  for (int node = 0; node < nodes; ++node) {
    columns[node] = node == held ? -1 : 3 * next++;
  }
  return columns;
}

void move_poses(const std::vector<int>& columns, const Eigen::VectorXd& step,
                std::vector<Pose2>& poses) {
  for (std::size_t node = 0; node < poses.size(); ++node) {
    if (columns[node] >= 0) {
      const auto d = step.segment<3>(columns[node]);
      Pose2& pose = poses[node];
      pose = {pose.x_m + d.x(), pose.y_m + d.y(), wrap_angle(pose.theta_rad + d.z())};
    }
  }
}

namespace {

std::vector<std::pair<int, int>> joined(const PoseGraph& graph, const std::vector<int>& columns) {
  std::vector<std::pair<int, int>> pairs;
  for (const GraphEdge& edge : graph.edges) {
    if (columns[edge.from] >= 0 && columns[edge.to] >= 0) {
      pairs.emplace_back(columns[edge.from], columns[edge.to]);
    }
  }
  return pairs;
}

}  // namespace

NormalEquations::NormalEquations(const PoseGraph& graph, int held)
    : columns_(pose_columns(static_cast<int>(graph.T_map_node.size()), held)),
      H_(3 * (static_cast<int>(columns_.size()) - 1), joined(graph, columns_)),
      gradient_(H_.size()) {
  places_.reserve(graph.edges.size());
  for (const GraphEdge& edge : graph.edges) {
    places_.push_back(H_.place(columns_[edge.from], columns_[edge.to]));
  }
}

void NormalEquations::linearise(const PoseGraph& graph) {
  H_.clear();
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
      H_.add(a, from_weighted * J.from);
      gradient_.segment<3>(a) += J.from.transpose() * weighted;
    }
    if (b >= 0) {
      H_.add(b, to_weighted * J.to);
      gradient_.segment<3>(b) += J.to.transpose() * weighted;
    }
    if (a >= 0 && b >= 0) {
      H_.add(places_[e], b > a ? Mat3(to_weighted * J.from) : Mat3(from_weighted * J.to));
    }
  }
}

double NormalEquations::promised_gain() const { return -gradient_.dot(step()); }

}  // namespace panoptes
