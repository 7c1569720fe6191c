// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/tree_descent.h"

#include <gtest/gtest.h>

#include "core/base/check.h"
#include "tests/core/graph/random_walk.h"

namespace panoptes {
namespace {

constexpr int kSide_m = 20;

TEST(TreeDescent, StaysWhereEveryEdgeIsContent) {
  Walk walk = random_walk(200, kSide_m, {.sigma_m = 1e-12, .sigma_rad = 1e-12}, Rng(1));
  for (GraphEdge& edge : walk.graph.edges) {
    edge.information.setIdentity();
  }
  relax_by_tree(walk.graph);
  constexpr double kDrawn_m = 1e-9;  // the noise above over the walk
  EXPECT_LT(rms_m(walk.graph.T_map_node, walk.truth), kDrawn_m);
}

TEST(TreeDescent, ComesNearLeastSquares) {
  for (int seed = 2; seed < 6; ++seed) {
    Walk walk = random_walk(400, kSide_m, {}, Rng(seed));
    const double odometry_m = rms_m(walk.graph.T_map_node, walk.truth);
    PoseGraph best = walk.graph;
    const RelaxReport wanted = relax(best);
    const RelaxReport report = relax_by_tree(walk.graph);
    EXPECT_EQ(report.chi2_start, wanted.chi2_start);
    EXPECT_DOUBLE_EQ(report.chi2_end, chi2(walk.graph));
    EXPECT_GE(report.chi2_end, wanted.chi2_end);
    EXPECT_LT(report.chi2_end, 2 * wanted.chi2_end) << seed;
    EXPECT_LT(rms_m(walk.graph.T_map_node, best.T_map_node), odometry_m / 4) << seed;
    EXPECT_EQ(walk.graph.T_map_node[0], Pose2());
  }
}

TEST(TreeDescent, GoesOnGettingBetter) {
  Walk walk = random_walk(400, kSide_m, {}, Rng(6));
  PoseGraph longer = walk.graph;
  std::vector<double> chi2s;
  const RelaxReport few =
      relax_by_tree(walk.graph, {.iterations = 10},
                    [&chi2s](const RelaxReport& now) { chi2s.push_back(now.chi2_end); });
  EXPECT_EQ(chi2s.size(), 10U);
  EXPECT_EQ(chi2s.front(), few.chi2_start);
  const RelaxReport many = relax_by_tree(longer, {.iterations = 100});
  EXPECT_EQ(few.iterations, 10);
  EXPECT_FALSE(few.converged);
  EXPECT_LT(many.chi2_end, few.chi2_end);
}

TEST(TreeDescent, GivesTheSameBitsAgain) {
  Walk a = random_walk(200, kSide_m, {}, Rng(7));
  Walk b = random_walk(200, kSide_m, {}, Rng(7));
  relax_by_tree(a.graph);
  relax_by_tree(b.graph);
  EXPECT_EQ(a.graph.T_map_node, b.graph.T_map_node);
}

TEST(TreeDescent, LeavesALonelyGraphAlone) {
  PoseGraph graph;
  EXPECT_TRUE(relax_by_tree(graph).converged);
  graph.T_map_node = {{1, 2, 3}, {4, 5, 6}, {0, 0, 0}, {1, 1, 1}};
  graph.edges.push_back({2, 3, {5, 0, 0}, Mat3::Identity(), false});
  relax_by_tree(graph);  // hangs on nothing
  EXPECT_EQ(graph.T_map_node[3], (Pose2{1, 1, 1}));
  graph.edges.push_back({0, 4, {}, Mat3::Identity(), false});
  EXPECT_THROW(relax_by_tree(graph), CheckError);
}

}  // namespace
}  // namespace panoptes
