// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/rng.h"
#include "core/graph/pose_graph.h"

namespace panoptes {

struct Walk {
  PoseGraph graph;  ///< poses dead reckoned
  std::vector<Pose2> truth;
};

struct WalkNoise {
  double sigma_m = 0.02;
  double sigma_rad = 0.01;
  double stated = 1;  ///< the information is that of errors so many times the true ones
};

/// A walk of 1 m steps over a square of streets as wide, with a turn at random every few steps, and
/// a closure to a place within 1.5 m of each third place that was there at least 20 steps before.
inline Walk random_walk(int nodes, int side_m, const WalkNoise& noise, Rng rng) {
  Walk walk;
  const double m = 1 / (noise.stated * noise.sigma_m);
  const double rad = 1 / (noise.stated * noise.sigma_rad);
  const Mat3 information = Vec3(m * m, m * m, rad * rad).asDiagonal();
  const auto measured = [&](int from, int to) {
    const Pose2 T = walk.truth[from].inverse() * walk.truth[to];
    return Pose2{T.x_m + rng.normal(0, noise.sigma_m), T.y_m + rng.normal(0, noise.sigma_m),
                 wrap_angle(T.theta_rad + rng.normal(0, noise.sigma_rad))};
  };
  walk.truth.emplace_back();
  walk.graph.T_map_node.emplace_back();
  for (int i = 1; i < nodes; ++i) {
    Pose2 next = walk.truth.back() * Pose2{1, 0, 0};
    const auto inside = [&](double x) { return x > -0.5 && x < side_m - 0.5; };
    for (bool turn = i % 4 == 0; turn || !inside(next.x_m) || !inside(next.y_m); turn = false) {
      const Pose2 quarter{0, 0, rng.index(2) == 0 ? std::numbers::pi / 2 : -std::numbers::pi / 2};
      next = walk.truth.back() * quarter * Pose2{1, 0, 0};
    }
    walk.truth.push_back(next);
    const Pose2 T = measured(i - 1, i);
    walk.graph.edges.push_back({i - 1, i, T, information, false});
    walk.graph.T_map_node.push_back(walk.graph.T_map_node.back() * T);
    for (int j = i % 3 == 0 ? 0 : i; j < i - 20; ++j) {
      if ((walk.truth[j].position() - next.position()).norm() < 1.5) {
        walk.graph.edges.push_back({j, i, measured(j, i), information, true});
        break;
      }
    }
  }
  return walk;
}

/// So many closures between places drawn at random that say something drawn at random.
inline void add_false_closures(PoseGraph& graph, int count, double reach_m, Rng rng) {
  const Mat3 information = graph.edges.front().information;
  const int nodes = static_cast<int>(graph.T_map_node.size());
  for (int i = 0; i < count; ++i) {
    const int from = rng.index(nodes);
    const int to = (from + 1 + rng.index(nodes - 1)) % nodes;
    graph.edges.push_back({from,
                           to,
                           {rng.uniform(-reach_m, reach_m), rng.uniform(-reach_m, reach_m),
                            rng.uniform(-std::numbers::pi, std::numbers::pi)},
                           information,
                           true});
  }
}

/// No alignment but the first pose, which both have.
inline double rms_m(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += (a[i].position() - b[i].position()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace panoptes
