// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/tree_descent.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr double kConverged = 1e-5;  // relative change of chi2 in a sweep that is worth no other

// Fewest edges from the first node to every other one; of two paths that through earlier nodes.
struct Tree {
  std::vector<int> parent;  // -1: the root, or not joined to it
  std::vector<int> level;   // -1: not joined to the root
};
Tree spanning_tree(const PoseGraph& graph) {
  const std::size_t nodes = graph.T_map_node.size();
  std::vector<std::vector<int>> neighbours(nodes);
  for (const GraphEdge& edge : graph.edges) {
    neighbours[edge.from].push_back(edge.to);
    neighbours[edge.to].push_back(edge.from);
  }
  Tree tree{std::vector<int>(nodes, -1), std::vector<int>(nodes, -1)};
  std::queue<int> queue;
  tree.level[0] = 0;
  queue.push(0);
  while (!queue.empty()) {
    const int node = queue.front();
    queue.pop();
    std::sort(neighbours[node].begin(), neighbours[node].end());
    for (const int next : neighbours[node]) {
      if (tree.level[next] < 0) {
        tree.level[next] = tree.level[node] + 1;
        tree.parent[next] = node;
        queue.push(next);
      }
    }
  }
  return tree;
}

// An edge and the tree's path between its ends: the nodes on each side below where they meet.
struct Path {
  const GraphEdge* edge = nullptr;
  int top = 0;
  std::vector<int> from_side;
  std::vector<int> to_side;

  double length() const { return static_cast<double>(from_side.size() + to_side.size()); }
};
Path path_of(const Tree& tree, const GraphEdge& edge) {
  Path path;
  path.edge = &edge;
  int a = edge.from;
  int b = edge.to;
  while (a != b) {
    if (tree.level[a] >= tree.level[b]) {
      path.from_side.push_back(a);
      a = tree.parent[a];
    } else {
      path.to_side.push_back(b);
      b = tree.parent[b];
    }
  }
  path.top = a;
  return path;
}

// Poses as differences of x, y and heading from the parent's, all along the axes of `map`.
class Descent {
 public:
  explicit Descent(const PoseGraph& graph) : tree_(spanning_tree(graph)) {
    const std::size_t nodes = graph.T_map_node.size();
    differences_.assign(nodes, Vec3::Zero());
    poses_.assign(nodes, Vec3::Zero());
    weights_.assign(nodes, Vec3::Zero());
    for (std::size_t node = 0; node < nodes; ++node) {
      const Pose2& T = graph.T_map_node[node];
      poses_[node] = {T.x_m, T.y_m, T.theta_rad};
    }
    for (std::size_t node = 0; node < nodes; ++node) {
      if (tree_.parent[node] >= 0) {
        differences_[node] = poses_[node] - poses_[tree_.parent[node]];
        differences_[node].z() = wrap_angle(differences_[node].z());
      }
    }
    for (const GraphEdge& edge : graph.edges) {
      if (tree_.level[edge.from] >= 0) {
        paths_.push_back(path_of(tree_, edge));
      }
    }
    // from the root down, so that what is above an edge's path is settled when its turn comes
    std::stable_sort(paths_.begin(), paths_.end(), [this](const Path& a, const Path& b) {
      return tree_.level[a.top] < tree_.level[b.top];
    });
    for (int node = 0; node < static_cast<int>(nodes); ++node) {
      if (tree_.level[node] > 0) {
        downwards_.push_back(node);
      }
    }
    std::stable_sort(downwards_.begin(), downwards_.end(),
                     [this](int a, int b) { return tree_.level[a] < tree_.level[b]; });
  }

  void sweep(int number) {
    weigh();
    for (const Path& path : paths_) {
      const Vec3 from = pose(path.edge->from);
      const Vec3 to = pose(path.edge->to);
      const Pose2 wanted = Pose2{from.x(), from.y(), from.z()} * path.edge->T_from_to;
      Vec3 error(wanted.x_m - to.x(), wanted.y_m - to.y(),
                 wrap_angle(wanted.theta_rad - wrap_angle(to.z())));
      const Vec3 gradient = 2 * (information_map(*path.edge, from.z()) * error);
      Vec3 whole = Vec3::Zero();
      for (const auto* side : {&path.from_side, &path.to_side}) {
        for (const int node : *side) {
          whole += weights_[node].cwiseInverse();
        }
      }
      for (int k = 0; k < 3; ++k) {
        const double step = path.length() * gradient[k] / (least_information_[k] * number);
        // no farther than to where the edge is content
        const double bounded =
            step * error[k] <= 0
                ? 0
                : std::copysign(std::min(std::abs(step), std::abs(error[k])), error[k]);
        for (const int node : path.from_side) {
          differences_[node][k] -= bounded / (weights_[node][k] * whole[k]);
        }
        for (const int node : path.to_side) {
          differences_[node][k] += bounded / (weights_[node][k] * whole[k]);
        }
      }
    }
    for (const int node : downwards_) {
      poses_[node] = poses_[tree_.parent[node]] + differences_[node];
    }
  }

  void write(PoseGraph& graph) const {
    for (const int node : downwards_) {
      graph.T_map_node[node] = {poses_[node].x(), poses_[node].y(), wrap_angle(poses_[node].z())};
    }
  }

 private:
  static Mat3 information_map(const GraphEdge& edge, double theta_rad) {
    Mat3 R = Mat3::Identity();
    R.topLeftCorner<2, 2>() = Pose2{0, 0, theta_rad}.rotation();
    return R * edge.information * R.transpose();
  }

  // Up to the root: what lies above may have moved since the last sweep.
  Vec3 pose(int node) const {
    Vec3 sum = Vec3::Zero();
    for (; tree_.parent[node] >= 0; node = tree_.parent[node]) {
      sum += differences_[node];
    }
    return sum + poses_[node];
  }

  // How much the edges know of each node's difference, and the least that any knows.
  void weigh() {
    std::fill(weights_.begin(), weights_.end(), Vec3::Zero());
    least_information_ = Vec3::Constant(std::numeric_limits<double>::max());
    for (const Path& path : paths_) {
      const Vec3 knows = information_map(*path.edge, poses_[path.edge->from].z()).diagonal();
      least_information_ = least_information_.cwiseMin(knows);
      for (const auto* side : {&path.from_side, &path.to_side}) {
        for (const int node : *side) {
          weights_[node] += knows;
        }
      }
    }
  }

  Tree tree_;
  std::vector<Path> paths_;
  std::vector<int> downwards_;
  std::vector<Vec3> poses_;
  std::vector<Vec3> differences_;
  std::vector<Vec3> weights_;
  Vec3 least_information_;
};

}  // namespace

RelaxReport relax_by_tree(PoseGraph& graph, const TreeDescentOptions& options,
                          const RelaxProgress& progress, const RelaxStop& stop) {
  for (const GraphEdge& edge : graph.edges) {
    const int nodes = static_cast<int>(graph.T_map_node.size());
    PANOPTES_CHECK(edge.from >= 0 && edge.from < nodes && edge.to >= 0 && edge.to < nodes &&
                       edge.from != edge.to,
                   "an edge joins two nodes of the graph");
  }
  RelaxReport report;
  report.chi2_start = report.chi2_end = chi2(graph);
  if (graph.edges.empty()) {
    report.converged = true;
    return report;
  }
  Descent descent(graph);
  while (report.iterations < options.iterations && !report.converged && !(stop && stop(0))) {
    if (progress) {
      progress(report);
    }
    descent.sweep(++report.iterations);
    descent.write(graph);
    const double now = chi2(graph);
    report.converged = std::abs(now - report.chi2_end) <= kConverged * now;
    report.chi2_end = now;
  }
  return report;
}

}  // namespace panoptes
