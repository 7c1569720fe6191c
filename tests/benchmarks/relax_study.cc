// SPDX-License-Identifier: BSD-3-Clause
// How relaxation does on pose graphs of others: relax_study [--draws N] [--seed K] FILE...
// For each file the chi2 and CPU time from the file's poses and from odometry, by least squares and
// by tree descent; then, N times, with as many false closures added as there are closures (uniform
// random pairs and relative poses over the graph's extent, the information of the true ones), what
// the robust stage keeps, and how far its poses lie from those without false closures.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "core/base/rng.h"
#include "core/graph/graph_uncertainty.h"
#include "core/graph/normal_equations.h"
#include "core/graph/pose_graph.h"
#include "core/graph/relax_starts.h"
#include "core/graph/robust_relax.h"
#include "core/graph/tree_descent.h"
#include "core/io/graph_file.h"

namespace panoptes {
namespace {

double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Both have the first pose where it was: no other alignment.
double rms_m(const PoseGraph& a, const PoseGraph& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.T_map_node.size(); ++i) {
    sum += (a.T_map_node[i].position() - b.T_map_node[i].position()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(a.T_map_node.size()));
}

PoseGraph with_false_closures(const PoseGraph& graph, const PoseGraph& relaxed, Rng rng) {
  Vec2 low = relaxed.T_map_node[0].position();
  Vec2 high = low;
  for (const Pose2& T : relaxed.T_map_node) {
    low = low.cwiseMin(T.position());
    high = high.cwiseMax(T.position());
  }
  const Vec2 size = high - low;
  PoseGraph all = graph;
  const int nodes = static_cast<int>(graph.T_map_node.size());
  for (const GraphEdge& edge : graph.edges) {
    if (!edge.closure) {
      continue;
    }
    GraphEdge lie = edge;
    do {
      lie.from = rng.index(nodes);
      lie.to = rng.index(nodes);
    } while (lie.from == lie.to);
    lie.T_from_to = {rng.uniform(-size.x(), size.x()), rng.uniform(-size.y(), size.y()),
                     rng.uniform(-std::numbers::pi, std::numbers::pi)};
    all.edges.push_back(lie);
  }
  return all;
}

double chi2_of(const GraphEdge& edge, const PoseGraph& relaxed, const Mat3& covariance) {
  const Vec3 error = residual_of(edge, relaxed.T_map_node[edge.from], relaxed.T_map_node[edge.to]);
  return error.dot(covariance.inverse() * error);
}

// What could be had of a graph by anyone who knew its true closures: how many false ones lie as
// close to it as all but a fiftieth of the true ones lie to the graph without them.
void study_chance(const PoseGraph& relaxed, const std::string& name) {
  constexpr int kDraws = 100;
  constexpr double kDropped = 0.02;
  const GraphUncertainty uncertainty(relaxed);
  std::vector<double> of_true;
  for (const GraphEdge& edge : relaxed.edges) {
    if (edge.closure) {  // its own weight taken out
      const Mat3 own = edge.information.inverse();
      of_true.push_back(chi2_of(edge, relaxed, own - uncertainty.relative(edge.from, edge.to)));
    }
  }
  if (of_true.empty()) {
    return;
  }
  std::sort(of_true.begin(), of_true.end(), std::greater<>());
  const auto dropped = static_cast<std::size_t>(kDropped * static_cast<double>(of_true.size()));
  const double limit = of_true[dropped];
  int close = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const PoseGraph all = with_false_closures(relaxed, relaxed, Rng(draw).fork("false-closures"));
    for (std::size_t e = relaxed.edges.size(); e < all.edges.size(); ++e) {
      const GraphEdge& lie = all.edges[e];
      const Mat3 own = lie.information.inverse();
      const Mat3 rough = own + 2 * uncertainty.relative_roughly(lie.from, lie.to);
      if (chi2_of(lie, relaxed, rough) <= 2 * limit) {
        const Mat3 exact = own + uncertainty.relative(lie.from, lie.to);
        close += chi2_of(lie, relaxed, exact) <= limit ? 1 : 0;
      }
    }
  }
  std::printf(
      "%s: true closures lie up to chi2 %.2f from the graph without them, but for %zu; so "
      "close are %d false ones in %d draws of %zu\n",
      name.c_str(), limit, dropped, close, kDraws, of_true.size());
}

// From every start, as `panoptes relax` does.
void study_every_start(const GraphFile& file, const std::string& name) {
  PoseGraph graph = file.graph;
  const double from_s = cpu_s();
  const StartsReport report = relax_from_every_start(graph);
  std::printf("%s from every start: chi2 %.9g -> %.9g, best %s, %.3f s\n", name.c_str(),
              report.relax.chi2_start, report.relax.chi2_end, report.best.c_str(),
              cpu_s() - from_s);
  for (const StartReport& start : report.starts) {
    std::printf("%s   %s: chi2 %.9g -> %.9g, %d iterations%s\n", name.c_str(), start.name.c_str(),
                start.relax.chi2_start, start.relax.chi2_end, start.relax.iterations,
                start.relax.converged ? "" : ", not settled");
  }
}

// Relaxed by least squares; from odometry in the end.
PoseGraph study_starts(const GraphFile& file, const std::string& name) {
  PoseGraph clean;
  for (const bool odometry : {false, true}) {
    if (!odometry && !file.poses_given) {
      continue;
    }
    for (const bool tree : {true, false}) {
      PoseGraph graph = file.graph;
      if (odometry) {
        dead_reckon(graph);
      }
      const double from_s = cpu_s();
      const RelaxReport report = tree ? relax_by_tree(graph) : relax(graph, RelaxStart::kCurrent);
      std::printf("%s %s from %s: chi2 %.9g -> %.9g, %d iterations, %.3f s\n", name.c_str(),
                  tree ? "tree descent" : "least squares", odometry ? "odometry" : "the file",
                  report.chi2_start, report.chi2_end, report.iterations, cpu_s() - from_s);
      clean = graph;
    }
  }
  return clean;
}

void study(const std::string& path, int draws, int seed) {
  const GraphFile file = read_graph(path);
  const std::string name = path.substr(path.rfind('/') + 1);
  study_every_start(file, name);
  const PoseGraph clean = study_starts(file, name);
  int closures = 0;
  for (const GraphEdge& edge : file.graph.edges) {
    closures += edge.closure ? 1 : 0;
  }
  int most_false_kept = 0;
  int most_true_dropped = 0;
  double most_m = 0;
  const auto robustly = [&](PoseGraph graph, const std::string& what) {
    const double from_s = cpu_s();
    const RobustReport report = relax_robustly(graph);
    int false_kept = 0;
    int true_dropped = 0;
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      const bool lie = e >= file.graph.edges.size();
      false_kept += lie && report.kept[e] ? 1 : 0;
      true_dropped += !lie && !report.kept[e] ? 1 : 0;
    }
    const double off_m = rms_m(graph, clean);
    std::printf("%s %s: false kept %d, true dropped %d of %d, %.4f m rms to clean, %.3f s\n",
                name.c_str(), what.c_str(), false_kept, true_dropped, closures, off_m,
                cpu_s() - from_s);
    std::fflush(stdout);
    most_false_kept = std::max(most_false_kept, false_kept);
    most_true_dropped = std::max(most_true_dropped, true_dropped);
    most_m = std::max(most_m, off_m);
  };
  if (draws > 0) {
    study_chance(clean, name);
    robustly(file.graph, "clean");
  }
  for (int draw = seed; draw < seed + draws; ++draw) {
    robustly(with_false_closures(file.graph, clean, Rng(draw).fork("false-closures")),
             "seed " + std::to_string(draw));
  }
  if (draws > 0) {
    std::printf("%s at worst: false kept %d, true dropped %.2f %%, %.4f m rms to clean\n",
                name.c_str(), most_false_kept, 100.0 * most_true_dropped / std::max(1, closures),
                most_m);
  }
}

}  // namespace
}  // namespace panoptes

int main(int argc, char** argv) {
  int draws = 0;
  int seed = 100;  // the robust stage was tuned on seeds below
  try {
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i];
      if (word == "--draws" && i + 1 < argc) {
        draws = std::atoi(argv[++i]);
      } else if (word == "--seed" && i + 1 < argc) {
        seed = std::atoi(argv[++i]);
      } else {
        panoptes::study(word, draws, seed);
      }
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
