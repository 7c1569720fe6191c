// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/relax_starts.h"

#include <optional>
#include <queue>
#include <utility>

#include "core/graph/tree_descent.h"

namespace panoptes {
namespace {

constexpr const char* kGiven = "given";
constexpr double kSame = 1e-9;  // relative: two descents to one bottom end so near to each other
constexpr int kDescentSweeps = 10;  // most of what the descent gains from a tree, it gains at first
// After so many damped steps a start that leads anywhere is near; one that is still at so many
// times the least of the others is left there.
constexpr int kPatience = 30;
constexpr double kHopeless = 2;

// Poses along fewest edges from the first node; of two such paths that through the earlier edge.
void reckon_by_tree(PoseGraph& graph) {
  const std::size_t nodes = graph.T_map_node.size();
  std::vector<std::vector<int>> edges_of(nodes);
  for (int e = 0; e < static_cast<int>(graph.edges.size()); ++e) {
    edges_of[graph.edges[e].from].push_back(e);
    edges_of[graph.edges[e].to].push_back(e);
  }
  std::vector<bool> placed(nodes, false);
  std::queue<int> queue;
  if (nodes > 0) {
    queue.push(0);
    placed[0] = true;
  }
  while (!queue.empty()) {
    const int node = queue.front();
    queue.pop();
    for (const int e : edges_of[node]) {
      const GraphEdge& edge = graph.edges[e];
      const bool forward = edge.from == node;
      const int next = forward ? edge.to : edge.from;
      if (!placed[next]) {
        placed[next] = true;
        graph.T_map_node[next] =
            graph.T_map_node[node] * (forward ? edge.T_from_to : edge.T_from_to.inverse());
        queue.push(next);
      }
    }
  }
}

}  // namespace

StartsReport relax_from_every_start(PoseGraph& graph, const RelaxProgress& progress,
                                    const RelaxStop& stop) {
  StartsReport report;
  std::vector<Pose2> best;
  const auto attempt = [&](const std::string& name, PoseGraph start) {
    RelaxReport now;
    const auto told = [&](const RelaxReport& step) {
      now = step;
      if (progress) {
        progress(step);
      }
    };
    const auto hopeless = [&](double multiplications) {
      return (stop && stop(multiplications)) ||
             (!report.starts.empty() && now.iterations > kPatience &&
              now.chi2_end > kHopeless * report.relax.chi2_end);
    };
    const RelaxReport relaxed = descend(start, told, hopeless);
    // nothing is less than what is not a number, so it is asked the other way round
    const double gain = name == kGiven ? 1 - kSame : 1 + kSame;
    if (report.starts.empty() || !(report.relax.chi2_end <= gain * relaxed.chi2_end)) {
      report.best = name;
      report.relax = relaxed;
      best = std::move(start.T_map_node);
    }
    report.starts.push_back({name, relaxed});
  };
  const auto stopped = [&stop] { return stop && stop(0); };
  const double chi2_given = chi2(graph);
  PoseGraph start = graph;
  if (graph.T_map_node.size() > 1 && start_linearly(start)) {
    attempt("linear", start);
  }
  attempt(kGiven, graph);
  start = graph;
  dead_reckon(start);
  if (!stopped() && start.T_map_node != graph.T_map_node) {
    attempt("odometry", start);
  }
  start = graph;
  reckon_by_tree(start);
  if (!stopped()) {
    attempt("tree", start);
  }
  if (!stopped()) {
    relax_by_tree(start, {.iterations = kDescentSweeps}, {}, stop);
    attempt("descent", start);
  }
  graph.T_map_node = std::move(best);
  report.relax.chi2_start = chi2_given;
  return report;
}

}  // namespace panoptes
