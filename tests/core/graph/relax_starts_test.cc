// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/relax_starts.h"

#include <limits>
#include <queue>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/core/graph/random_walk.h"

namespace panoptes {
namespace {

using testing::ElementsAre;

constexpr double kRoundoff = 1e-6;  // what a converged relaxation leaves

std::vector<std::string> names_of(const StartsReport& report) {
  std::vector<std::string> names;
  for (const StartReport& start : report.starts) {
    names.push_back(start.name);
  }
  return names;
}

// Poses as somebody may have left them: along fewest edges from the first node.
void reckon_by_fewest_edges(PoseGraph& graph) {
  std::vector<bool> placed(graph.T_map_node.size(), false);
  std::queue<int> queue({0});
  placed[0] = true;
  for (; !queue.empty(); queue.pop()) {
    const int node = queue.front();
    for (const GraphEdge& edge : graph.edges) {
      if ((edge.from == node && !placed[edge.to]) || (edge.to == node && !placed[edge.from])) {
        const bool forward = edge.from == node;
        const int next = forward ? edge.to : edge.from;
        graph.T_map_node[next] =
            graph.T_map_node[node] * (forward ? edge.T_from_to : edge.T_from_to.inverse());
        placed[next] = true;
        queue.push(next);
      }
    }
  }
}

// Streets in a grid, and headings that err by 0.2 rad a step: from the poses given a descent
// settles at less than ten times what the noise explains, and yet far above the least.
TEST(RelaxStarts, KeepTheLeastOfAGridWhoseFirstDescentSettlesTooHigh) {
  Walk walk = random_walk(3500, 30, {.sigma_m = 0.2, .sigma_rad = 0.2}, Rng(3));
  reckon_by_fewest_edges(walk.graph);
  PoseGraph once = walk.graph;
  const RelaxReport first = relax(once, RelaxStart::kCurrent);
  EXPECT_TRUE(first.converged);
  PoseGraph known = walk.graph;
  known.T_map_node = walk.truth;
  const double least = descend(known).chi2_end;
  ASSERT_GT(first.chi2_end, 1.2 * least);  // a quarter above it and more: another bottom

  const StartsReport report = relax_from_every_start(walk.graph);
  EXPECT_TRUE(report.relax.converged);
  EXPECT_EQ(report.relax.chi2_start, first.chi2_start);
  EXPECT_LE(report.relax.chi2_end, (1 + kRoundoff) * least);
  EXPECT_DOUBLE_EQ(report.relax.chi2_end, chi2(walk.graph));
  EXPECT_THAT(names_of(report), ElementsAre("linear", "given", "odometry", "tree", "descent"));
  for (const StartReport& start : report.starts) {
    EXPECT_LE(report.relax.chi2_end, (1 + kRoundoff) * start.relax.chi2_end) << start.name;
  }
}

TEST(RelaxStarts, StayWithTheGivenPosesWhereAllLeadToOneBottom) {
  Walk walk = random_walk(400, 20, {}, Rng(2));
  PoseGraph alone = walk.graph;
  const RelaxReport wanted = descend(alone);
  const StartsReport report = relax_from_every_start(walk.graph);
  EXPECT_EQ(report.best, "given");
  EXPECT_EQ(report.relax.chi2_end, wanted.chi2_end);
  EXPECT_EQ(walk.graph.T_map_node, alone.T_map_node);
  // dead reckoned as they were given, they are tried once
  EXPECT_THAT(names_of(report), ElementsAre("linear", "given", "tree", "descent"));
}

TEST(RelaxStarts, GetOverPosesThatAreNoNumbers) {
  Walk walk = random_walk(200, 20, {}, Rng(4));
  PoseGraph best = walk.graph;
  const double least = relax(best).chi2_end;
  walk.graph.T_map_node[50].y_m = std::numeric_limits<double>::quiet_NaN();
  const StartsReport report = relax_from_every_start(walk.graph);
  EXPECT_TRUE(report.relax.converged);
  EXPECT_NEAR(report.relax.chi2_end, least, kRoundoff * least);
  EXPECT_NE(report.best, "given");
}

TEST(RelaxStarts, EndWithTheBestSoFarWhenToldTo) {
  Walk walk = random_walk(400, 20, {}, Rng(5));
  const StartsReport report = relax_from_every_start(walk.graph, {}, [](double) { return true; });
  EXPECT_FALSE(report.relax.converged);
  EXPECT_DOUBLE_EQ(report.relax.chi2_end, chi2(walk.graph));
  EXPECT_LE(report.relax.chi2_end, report.relax.chi2_start);
}

TEST(RelaxStarts, LeaveALonelyGraphAlone) {
  PoseGraph graph;
  EXPECT_TRUE(relax_from_every_start(graph).relax.converged);
  graph.T_map_node = {{1, 2, 3}};
  EXPECT_TRUE(relax_from_every_start(graph).relax.converged);
  EXPECT_EQ(graph.T_map_node[0], (Pose2{1, 2, 3}));
}

}  // namespace
}  // namespace panoptes
