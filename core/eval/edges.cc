// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/edges.h"

#include <cmath>

#include <Eigen/LU>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kSpinTurn_rad = deg_to_rad(5);
constexpr double kSpinDistance_m = 0.05;

// Sums over the edges of one kind.
struct Sums {
  int count = 0;
  Mat2 regressors = Mat2::Zero();  // of distance and turn
  Vec2 explained = Vec2::Zero();   // and of each with the heading's error
  double heading_squares = 0;
  double position_squares = 0;
  double nees = 0;

  void add(const GraphEdge& edge, const Pose2& true_T_from_to) {
    const Vec3 e(edge.T_from_to.x_m - true_T_from_to.x_m, edge.T_from_to.y_m - true_T_from_to.y_m,
                 wrap_angle(edge.T_from_to.theta_rad - true_T_from_to.theta_rad));
    const Vec2 regressor(true_T_from_to.position().norm(), true_T_from_to.theta_rad);
    ++count;
    regressors += regressor * regressor.transpose();
    explained += e.z() * regressor;
    heading_squares += e.z() * e.z();
    position_squares += e.head<2>().squaredNorm();
    constexpr int kFreedoms = 3;
    nees += e.dot(edge.information * e) / kFreedoms;
  }
};

EdgeErrors errors_of(const Sums& sums) {
  EdgeErrors errors;
  errors.count = sums.count;
  if (sums.count == 0) {
    return errors;
  }
  // of each as much as makes a figure of it
  constexpr double kEnough_m2 = 1;
  constexpr double kEnough_rad2 = 0.1;
  const bool drives = sums.regressors(0, 0) > kEnough_m2;
  const bool turns = sums.regressors(1, 1) > kEnough_rad2;
  if (drives && turns) {
    const Vec2 bias = sums.regressors.inverse() * sums.explained;
    errors.heading_bias_rad_per_m = bias.x();
    errors.heading_bias_share_of_turn = bias.y();
  } else if (drives) {
    errors.heading_bias_rad_per_m = sums.explained.x() / sums.regressors(0, 0);
  } else if (turns) {
    errors.heading_bias_share_of_turn = sums.explained.y() / sums.regressors(1, 1);
  }
  errors.heading_rms_rad = std::sqrt(sums.heading_squares / sums.count);
  errors.position_rms_m = std::sqrt(sums.position_squares / sums.count);
  errors.nees = sums.nees / sums.count;
  return errors;
}

}  // namespace

EdgeFigures edge_figures(const PoseGraph& graph, const std::vector<Pose2>& true_T_scene_body) {
  PANOPTES_CHECK(graph.T_map_node.size() == true_T_scene_body.size(), "a truth for every node");
  Sums spins;
  Sums driving;
  for (const GraphEdge& edge : graph.edges) {
    if (edge.closure || edge.to != edge.from + 1) {
      continue;
    }
    const Pose2 true_T_from_to =
        true_T_scene_body[edge.from].inverse() * true_T_scene_body[edge.to];
    const bool spin = std::abs(true_T_from_to.theta_rad) > kSpinTurn_rad &&
                      true_T_from_to.position().norm() < kSpinDistance_m;
    (spin ? spins : driving).add(edge, true_T_from_to);
  }
  return {errors_of(spins), errors_of(driving)};
}

}  // namespace panoptes
