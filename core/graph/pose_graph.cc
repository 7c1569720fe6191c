// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/pose_graph.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <deque>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "core/base/check.h"
#include "core/geometry/covariance.h"
#include "core/graph/descent.h"
#include "core/graph/normal_equations.h"

namespace panoptes {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr int kMaxIterations = 200;
constexpr double kConverged = 1e-10;  // relative change of chi2 at which nothing more is gained
constexpr double kBadStart = 10;      // chi2 a degree of freedom that no good graph has: start anew
constexpr double kSmallestDamping = 1e-9;  // of the diagonal: keeps loose nodes solvable
constexpr double kMostDamping = 1e6;       // steps are a millionth of what the diagonal asks for

void check(const PoseGraph& graph) {
  const int nodes = static_cast<int>(graph.T_map_node.size());
  for (const GraphEdge& edge : graph.edges) {
    PANOPTES_CHECK(edge.from >= 0 && edge.from < nodes && edge.to >= 0 && edge.to < nodes &&
                       edge.from != edge.to,
                   "an edge joins two nodes of the graph");
  }
}

void tell(const RelaxProgress& progress, const RelaxReport& report, double now) {
  if (progress) {
    progress({report.chi2_start, now, report.iterations, false});
  }
}

bool stopped(const RelaxStop& stop, const NormalEquations& normals) {
  return stop && stop(normals.work());
}

// The chi2 that rounding alone may give a graph whose edges all agree: of numbers as large as its
// coordinates, each a few ulps off.
double rounding_of(const PoseGraph& graph) {
  constexpr double kUlps = 8;
  double largest = 1;
  for (const Pose2& T : graph.T_map_node) {
    largest = std::max({largest, std::abs(T.x_m), std::abs(T.y_m)});
  }
  double information = 0;
  for (const GraphEdge& edge : graph.edges) {
    information += edge.information.trace();
  }
  const double off = kUlps * std::numeric_limits<double>::epsilon() * largest;
  return information * off * off;
}

// Whether the graph, linearised where it lies, promises no gain that rounding would not hide.
bool at_bottom(const PoseGraph& graph, NormalEquations& normals, double now) {
  if (!std::isfinite(now) || !(normals.factorise(0) || normals.factorise(kSmallestDamping))) {
    return false;
  }
  const double gain = normals.promised_gain();
  const double rounding = rounding_of(graph);
  // an error of chi2 by rounding: twice the residuals times what they are off
  return gain <= kConverged * now + rounding + 2 * std::sqrt(now * rounding);
}

// Full steps of Gauss-Newton, uphill ones too: from a fair start they pass what makes a damped
// descent creep. False, and the poses as they were, when that does not settle below the start.
bool newton(PoseGraph& graph, NormalEquations& normals, RelaxReport& report,
            const RelaxProgress& progress, const RelaxStop& stop) {
  constexpr int kSteps = 20;
  const std::vector<Pose2> before = graph.T_map_node;
  double now = report.chi2_start;
  for (int k = 0; k < kSteps && !stopped(stop, normals); ++k) {
    tell(progress, report, now);
    ++report.iterations;
    normals.linearise(graph);
    if (!normals.factorise(0)) {
      break;
    }
    const Eigen::VectorXd step = normals.step();
    if (!step.allFinite()) {
      break;
    }
    normals.move(step, graph.T_map_node);
    const double then = chi2(graph);
    if (std::abs(then - now) <= kConverged * now && then <= report.chi2_start) {
      report.chi2_end = then;
      report.converged = true;
      return true;
    }
    now = then;
  }
  graph.T_map_node = before;
  return false;
}

// Gauss-Newton, else Levenberg-Marquardt, from the poses as they are.
RelaxReport descend(PoseGraph& graph, NormalEquations& normals, const RelaxProgress& progress,
                    const RelaxStop& stop) {
  RelaxReport report;
  double now = chi2(graph);
  report.chi2_start = now;
  if (newton(graph, normals, report, progress, stop)) {
    return report;
  }
  report.iterations = 0;
  double damping = kSmallestDamping;
  bool given_up = false;
  while (report.iterations < kMaxIterations && !report.converged && !given_up) {
    normals.linearise(graph);
    bool better = false;
    while (!better && !report.converged && !given_up) {
      if (report.iterations == kMaxIterations || stopped(stop, normals)) {
        given_up = true;
        break;
      }
      tell(progress, report, now);
      ++report.iterations;
      const std::vector<Pose2> before = graph.T_map_node;
      double then = std::numeric_limits<double>::infinity();
      if (normals.factorise(damping)) {
        const Eigen::VectorXd step = normals.step();
        if (step.allFinite()) {
          normals.move(step, graph.T_map_node);
          then = chi2(graph);
        }
      }
      if (then <= now) {
        better = true;
        report.converged = now - then <= kConverged * now;
        now = then;
        damping = std::max(kSmallestDamping, damping / 10);
      } else {
        graph.T_map_node = before;
        report.converged = then - now <= kConverged * now;
        if (!report.converged && damping > kMostDamping) {
          // no step, however small, helps any more: the bottom, or nothing can be solved
          given_up = true;
          report.converged = at_bottom(graph, normals, now);
        }
        damping *= damping < 1e-6 ? 1e3 : 10;
      }
    }
  }
  report.chi2_end = now;
  return report;
}

// Orientations as complex numbers, relaxed to any length (the chordal start), then scaled back.
bool start_orientations(PoseGraph& graph) {
  using Complex = std::complex<double>;
  const int nodes = static_cast<int>(graph.T_map_node.size());
  const Complex first = std::polar(1.0, graph.T_map_node[0].theta_rad);
  std::vector<Eigen::Triplet<Complex>> triplets;
  Eigen::VectorXcd right = Eigen::VectorXcd::Zero(nodes - 1);
  for (const GraphEdge& edge : graph.edges) {
    // z_to = z_from * turn
    const Complex turn = std::polar(1.0, edge.T_from_to.theta_rad);
    const double weight = edge.information(2, 2);
    const int a = edge.from - 1;
    const int b = edge.to - 1;
    if (a >= 0) {
      triplets.emplace_back(a, a, weight);
    }
    if (b >= 0) {
      triplets.emplace_back(b, b, weight);
    }
    if (a >= 0 && b >= 0) {
      triplets.emplace_back(std::max(a, b), std::min(a, b),
                            b > a ? -weight * turn : -weight * std::conj(turn));
    } else if (a >= 0) {
      right[a] += weight * std::conj(turn) * first;
    } else if (b >= 0) {
      right[b] += weight * turn * first;
    }
  }
  Eigen::SparseMatrix<Complex> H(nodes - 1, nodes - 1);
  H.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> solver(H);
  if (solver.info() != Eigen::Success) {
    return false;
  }
  const Eigen::VectorXcd z = solver.solve(right);
  for (int node = 1; node < nodes; ++node) {
    const Complex value = z[node - 1];
    if (!std::isfinite(value.real()) || !std::isfinite(value.imag()) || std::abs(value) < 1e-12) {
      return false;
    }
    graph.T_map_node[node].theta_rad = std::arg(value);
  }
  return true;
}

// Positions with the orientations held: a linear problem.
bool start_positions(PoseGraph& graph) {
  const Eigen::Index nodes = static_cast<Eigen::Index>(graph.T_map_node.size());
  const Eigen::Index size = 2 * (nodes - 1);
  Triplets triplets;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  for (const GraphEdge& edge : graph.edges) {
    const Mat2 R = graph.T_map_node[edge.from].rotation();
    const Mat2 weight = R * edge.information.topLeftCorner<2, 2>() * R.transpose();
    Vec2 want = R * edge.T_from_to.position();  // to - from, in map
    const int a = 2 * (edge.from - 1);
    const int b = 2 * (edge.to - 1);
    if (a < 0) {
      want += graph.T_map_node[0].position();
    }
    if (b < 0) {
      want -= graph.T_map_node[0].position();
    }
    const Vec2 weighted = weight * want;
    for (int c = 0; c < 2; ++c) {
      for (int r = 0; r < 2; ++r) {
        if (a >= 0) {
          triplets.emplace_back(a + r, a + c, weight(r, c));
        }
        if (b >= 0) {
          triplets.emplace_back(b + r, b + c, weight(r, c));
        }
        if (a >= 0 && b >= 0) {
          triplets.emplace_back(std::max(a, b) + r, std::min(a, b) + c, -weight(r, c));
        }
      }
    }
    if (a >= 0) {
      right.segment<2>(a) -= weighted;
    }
    if (b >= 0) {
      right.segment<2>(b) += weighted;
    }
  }
  Sparse H(size, size);
  H.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SimplicialLDLT<Sparse> solver(H);
  if (solver.info() != Eigen::Success) {
    return false;
  }
  const Eigen::VectorXd t = solver.solve(right);
  if (!t.allFinite()) {
    return false;
  }
  for (Eigen::Index node = 1; node < nodes; ++node) {
    graph.T_map_node[node].x_m = t[2 * (node - 1)];
    graph.T_map_node[node].y_m = t[2 * (node - 1) + 1];
  }
  return true;
}

}  // namespace

bool start_linearly(PoseGraph& graph) {
  check(graph);
  const std::vector<Pose2> before = graph.T_map_node;
  if (graph.T_map_node.size() > 1 && !(start_orientations(graph) && start_positions(graph))) {
    graph.T_map_node = before;
    return false;
  }
  return true;
}

double chi2(const PoseGraph& graph, const GraphEdge& edge) {
  const Vec3 r = residual_of(edge, graph.T_map_node[edge.from], graph.T_map_node[edge.to]);
  return r.dot(edge.information * r);
}

double chi2(const PoseGraph& graph) {
  double sum = 0;
  for (const GraphEdge& edge : graph.edges) {
    sum += chi2(graph, edge);
  }
  return sum;
}

std::optional<int> dead_reckon(PoseGraph& graph) {
  check(graph);
  const std::size_t nodes = graph.T_map_node.size();
  std::vector<std::vector<int>> edges_of(nodes);
  for (int e = 0; e < static_cast<int>(graph.edges.size()); ++e) {
    edges_of[graph.edges[e].from].push_back(e);
    edges_of[graph.edges[e].to].push_back(e);
  }
  struct Step {
    int edge;
    int to;
  };
  std::vector<bool> placed(nodes, false);
  std::deque<Step> steps;  // odometry in front, closures behind
  const auto settle = [&](int node) {
    placed[node] = true;
    // the last pushed to the front goes first: edges backwards, so that of two the earlier is taken
    for (auto e = edges_of[node].rbegin(); e != edges_of[node].rend(); ++e) {
      const GraphEdge& edge = graph.edges[*e];
      const int to = edge.from == node ? edge.to : edge.from;
      if (!placed[to] && std::abs(to - node) == 1) {
        steps.push_front({*e, to});
      }
    }
    for (const int e : edges_of[node]) {
      const GraphEdge& edge = graph.edges[e];
      const int to = edge.from == node ? edge.to : edge.from;
      if (!placed[to] && std::abs(to - node) != 1) {
        steps.push_back({e, to});
      }
    }
  };
  if (nodes > 0) {
    settle(0);
  }
  while (!steps.empty()) {
    const Step step = steps.front();
    steps.pop_front();
    if (placed[step.to]) {
      continue;
    }
    const GraphEdge& edge = graph.edges[step.edge];
    graph.T_map_node[step.to] = edge.to == step.to
                                    ? graph.T_map_node[edge.from] * edge.T_from_to
                                    : graph.T_map_node[edge.to] * edge.T_from_to.inverse();
    settle(step.to);
  }
  const auto lost = std::find(placed.begin(), placed.end(), false);
  return lost == placed.end() ? std::nullopt
                              : std::optional(static_cast<int>(lost - placed.begin()));
}

RelaxReport descend(PoseGraph& graph, const RelaxProgress& progress, const RelaxStop& stop) {
  check(graph);
  if (graph.T_map_node.size() < 2 || graph.edges.empty()) {
    const double now = chi2(graph);
    return {now, now, 0, true};
  }
  NormalEquations normals(graph, 0);
  return descend(graph, normals, progress, stop);
}

RelaxReport relax(PoseGraph& graph, RelaxStart start, const RelaxProgress& progress) {
  return relax(graph, start, progress, {});
}

RelaxReport relax(PoseGraph& graph, RelaxStart start, const RelaxProgress& progress,
                  const RelaxStop& stop) {
  check(graph);
  RelaxReport report;
  report.chi2_start = chi2(graph);
  report.chi2_end = report.chi2_start;
  if (graph.T_map_node.size() < 2 || graph.edges.empty()) {
    report.converged = true;
    return report;
  }
  NormalEquations normals(graph, 0);
  const PoseGraph given = graph;
  const double degrees_of_freedom =
      std::max(3.0, 3.0 * static_cast<double>(graph.edges.size()) -
                        3.0 * static_cast<double>(graph.T_map_node.size() - 1));
  const bool from_given = start == RelaxStart::kCurrent;
  if (from_given) {
    report = descend(graph, normals, progress, stop);
    if (report.converged && report.chi2_end <= kBadStart * degrees_of_freedom) {
      return report;
    }
  }
  if (stopped(stop, normals)) {
    return report;
  }
  PoseGraph other = given;
  if (start_linearly(other)) {
    const RelaxReport linear = descend(other, normals, progress, stop);
    if (!from_given || !(report.chi2_end <= linear.chi2_end)) {
      graph.T_map_node = other.T_map_node;
      report = {chi2(given), linear.chi2_end, report.iterations + linear.iterations,
                linear.converged};
    }
  }
  if (!from_given && report.chi2_end >= chi2(given)) {
    // the start was better than where the linear one led, or there was none
    graph = given;
    report = descend(graph, normals, progress, stop);
  }
  return report;
}

Mat3 relative_covariance(const PoseGraph& graph, int from, int to) {
  check(graph);
  PANOPTES_CHECK(from != to, "two nodes");
  NormalEquations normals(graph, from);
  normals.linearise(graph);
  if (!normals.factorise(0) && !normals.factorise(kSmallestDamping)) {
    return unknown_covariance();
  }
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(normals.size(), 3);
  right.block<3, 3>(normals.column(to), 0).setIdentity();
  const Mat3 covariance_map = normals.solve(right).block<3, 3>(normals.column(to), 0);
  Mat3 R_from_map = Mat3::Identity();
  R_from_map.topLeftCorner<2, 2>() = graph.T_map_node[from].rotation().transpose();
  const Mat3 covariance = R_from_map * covariance_map * R_from_map.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

std::vector<Mat3> path_covariances(const PoseGraph& graph, int from, const SharedStates* states) {
  check(graph);
  const int nodes = static_cast<int>(graph.T_map_node.size());
  PANOPTES_CHECK(from >= 0 && from < nodes, "a node of the graph");
  // the edges of node n: edges_of[first[n]] and on, up to first[n + 1]
  std::vector<int> first(nodes + 1, 0);
  for (const GraphEdge& edge : graph.edges) {
    ++first[edge.from + 1];
    ++first[edge.to + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<int> edges_of(2 * graph.edges.size());
  std::vector<int> next_of(first.begin(), first.end() - 1);
  for (int e = 0; e < static_cast<int>(graph.edges.size()); ++e) {
    edges_of[next_of[graph.edges[e].from]++] = e;
    edges_of[next_of[graph.edges[e].to]++] = e;
  }
  constexpr double kLever_m2 = 1;  // weighs headings against positions: an error seen a metre away
  std::vector<Mat3> covariances(nodes, unknown_covariance());
  // how each node's pose moves with the states; empty while it does not
  std::vector<Eigen::MatrixXd> by_state(nodes);
  std::vector<double> cost(nodes, std::numeric_limits<double>::infinity());
  std::vector<bool> settled(nodes, false);
  using Item = std::pair<double, int>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
  covariances[from].setZero();
  cost[from] = 0;
  queue.emplace(0.0, from);
  const Pose2 T_from_map = graph.T_map_node[from].inverse();
  std::vector<Pose2> T_from_node(nodes);
  std::transform(graph.T_map_node.begin(), graph.T_map_node.end(), T_from_node.begin(),
                 [&](const Pose2& T_map_node) { return T_from_map * T_map_node; });
  while (!queue.empty()) {
    const int node = queue.top().second;
    queue.pop();
    if (settled[node]) {
      continue;
    }
    settled[node] = true;
    for (int at = first[node]; at < first[node + 1]; ++at) {
      const GraphEdge& edge = graph.edges[edges_of[at]];
      const int next = edge.from == node ? edge.to : edge.from;
      if (settled[next]) {
        continue;
      }
      // the edge's covariance lies in the frame of its own start; turned to `from`, the error of a
      // relative pose is the same either way round but for the lever of its heading
      const std::optional<Mat3> covariance = inverse_of(edge.information);
      if (!covariance) {
        continue;
      }
      Mat3 turn = Mat3::Identity();
      turn.topLeftCorner<2, 2>() = T_from_node[edge.from].rotation();
      const Vec2 offset = T_from_node[next].position() - T_from_node[node].position();
      if (edge.from != node) {
        // walked backwards, an error of heading at the far end swings the path back
        Mat3 swing = Mat3::Identity();
        swing(0, 2) = -offset.y();
        swing(1, 2) = offset.x();
        turn = -swing * turn;
      }
      const Mat3 step = turn * *covariance * turn.transpose();
      Mat3 carry = Mat3::Identity();
      carry(0, 2) = -offset.y();
      carry(1, 2) = offset.x();
      const double to_next = cost[node] + step(0, 0) + step(1, 1) + kLever_m2 * step(2, 2);
      if (to_next < cost[next]) {
        cost[next] = to_next;
        covariances[next] = carry * covariances[node] * carry.transpose() + step;
        if (states != nullptr) {
          const Eigen::MatrixXd& by_edge = states->by_state[edges_of[at]];
          by_state[next] = by_state[node].size() > 0 ? Eigen::MatrixXd(carry * by_state[node])
                                                     : Eigen::MatrixXd();
          if (by_edge.size() > 0) {
            const Eigen::MatrixXd moved = turn * by_edge;
            by_state[next] =
                by_state[next].size() > 0 ? Eigen::MatrixXd(by_state[next] + moved) : moved;
          }
        }
        queue.emplace(to_next, next);
      }
    }
  }
  for (int node = 0; node < nodes; ++node) {
    if (by_state[node].size() > 0 && settled[node]) {
      covariances[node] += by_state[node] * states->covariance * by_state[node].transpose();
    }
  }
  return covariances;
}

}  // namespace panoptes
