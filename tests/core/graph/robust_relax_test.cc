// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/robust_relax.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/base/check.h"
#include "tests/core/graph/random_walk.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-6;     // what a converged relaxation leaves
constexpr double kMostDropped = 0.02;  // of the true closures
constexpr int kSide_m = 20;

int closures(const PoseGraph& graph) {
  return static_cast<int>(std::count_if(graph.edges.begin(), graph.edges.end(),
                                        [](const GraphEdge& e) { return e.closure; }));
}

struct Verdict {
  int false_kept = 0;
  int true_dropped = 0;
};
Verdict verdict(const RobustReport& report, std::size_t true_edges) {
  Verdict v;
  for (std::size_t e = 0; e < report.kept.size(); ++e) {
    v.false_kept += e >= true_edges && report.kept[e] ? 1 : 0;
    v.true_dropped += e < true_edges && !report.kept[e] ? 1 : 0;
  }
  return v;
}

TEST(RobustRelax, IsRelaxWhereNothingIsFalse) {
  Walk walk = random_walk(400, kSide_m, {}, Rng(1));
  PoseGraph plain = walk.graph;
  const RelaxReport wanted = relax(plain);
  const RobustReport report = relax_robustly(walk.graph);
  EXPECT_EQ(report.rejected, 0);
  EXPECT_TRUE(report.relax.converged);
  EXPECT_NEAR(report.relax.chi2_end, wanted.chi2_end, kRoundoff * wanted.chi2_end);
  EXPECT_LT(rms_m(walk.graph.T_map_node, plain.T_map_node), kRoundoff);
}

TEST(RobustRelax, KeepsNoFalseClosureOfAsManyAsAreTrue) {
  for (int seed = 0; seed < 10; ++seed) {
    Walk walk = random_walk(400, kSide_m, {}, Rng(10 + seed));
    const std::size_t true_edges = walk.graph.edges.size();
    const int count = closures(walk.graph);
    ASSERT_GT(count, 50);
    PoseGraph clean = walk.graph;
    relax(clean);
    add_false_closures(walk.graph, count, kSide_m, Rng(seed));
    const RobustReport report = relax_robustly(walk.graph);
    const Verdict v = verdict(report, true_edges);
    EXPECT_EQ(v.false_kept, 0) << seed;
    EXPECT_LE(v.true_dropped, kMostDropped * count) << seed;
    EXPECT_EQ(report.rejected, v.true_dropped + count);
    EXPECT_LT(rms_m(walk.graph.T_map_node, walk.truth),
              1.1 * rms_m(clean.T_map_node, walk.truth) + kRoundoff)
        << seed;
  }
}

TEST(RobustRelax, FindsOutThatTheInformationIsTooModest) {
  Walk walk = random_walk(400, kSide_m, {.stated = 20}, Rng(30));
  const std::size_t true_edges = walk.graph.edges.size();
  const int count = closures(walk.graph);
  add_false_closures(walk.graph, count, kSide_m, Rng(31));
  const RobustReport report = relax_robustly(walk.graph);
  EXPECT_LT(report.noise_scale, 0.2);
  EXPECT_EQ(verdict(report, true_edges).false_kept, 0);
  EXPECT_LE(verdict(report, true_edges).true_dropped, kMostDropped * count);
}

TEST(RobustRelax, SurvivesThreeFalseClosuresForATrueOne) {
  Walk walk = random_walk(400, kSide_m, {}, Rng(40));
  const std::size_t true_edges = walk.graph.edges.size();
  const int count = closures(walk.graph);
  add_false_closures(walk.graph, 3 * count, kSide_m, Rng(41));
  const RobustReport report = relax_robustly(walk.graph);
  EXPECT_EQ(verdict(report, true_edges).false_kept, 0);
  EXPECT_LE(verdict(report, true_edges).true_dropped, kMostDropped * count);
}

TEST(RobustRelax, IsLeftWithOdometryWhereEveryClosureIsFalse) {
  Walk walk = random_walk(200, kSide_m, {}, Rng(50));
  std::erase_if(walk.graph.edges, [](const GraphEdge& e) { return e.closure; });
  const std::vector<Pose2> odometry = walk.graph.T_map_node;
  add_false_closures(walk.graph, 40, kSide_m, Rng(51));
  const RobustReport report = relax_robustly(walk.graph);
  EXPECT_EQ(report.rejected, 40);
  EXPECT_LT(rms_m(walk.graph.T_map_node, odometry), kRoundoff);
}

TEST(RobustRelax, WorksOnAStraightLineThereAndBack) {
  constexpr int kNodes = 200;
  const Mat3 information = Vec3(2500, 2500, 10000).asDiagonal();
  PoseGraph graph;
  graph.T_map_node.resize(kNodes);
  for (int i = 1; i < kNodes; ++i) {
    const bool back = i >= kNodes / 2;
    graph.edges.push_back({i - 1, i, {back ? -1.0 : 1.0, 0, 0}, information, false});
    if (back && i % 5 == 0) {
      graph.edges.push_back({kNodes - 2 - i, i, {0, 0, 0}, information, true});
    }
  }
  const std::size_t true_edges = graph.edges.size();
  add_false_closures(graph, 19, kNodes / 2.0, Rng(55));
  const Verdict v = verdict(relax_robustly(graph), true_edges);
  EXPECT_EQ(v.false_kept, 0);
  EXPECT_EQ(v.true_dropped, 0);
}

TEST(RobustRelax, TrustsTheFirstEdgeBetweenNeighbours) {
  Walk walk = random_walk(200, kSide_m, {}, Rng(60));
  GraphEdge lie = walk.graph.edges[100];
  lie.T_from_to.x_m += 3;
  lie.closure = true;
  walk.graph.edges.push_back(lie);
  const RobustReport report = relax_robustly(walk.graph);
  EXPECT_TRUE(report.kept[100]);
  EXPECT_FALSE(report.kept.back());
  EXPECT_EQ(report.rejected, 1);
}

// Two false closures `apart` nodes from each other that agree by odometry, and with nothing else.
int pair_kept(int apart) {
  Walk walk = random_walk(400, kSide_m, {}, Rng(65));
  const std::vector<Pose2>& odometry = walk.graph.T_map_node;
  const Mat3 information = walk.graph.edges.front().information;
  const Pose2 lie = odometry[20].inverse() * odometry[300] * Pose2{5, 3, 1};
  const Pose2 T_first_from = odometry[20].inverse() * odometry[20 + apart];
  const Pose2 T_first_to = odometry[300].inverse() * odometry[300 + apart];
  walk.graph.edges.push_back({20, 300, lie, information, true});
  walk.graph.edges.push_back(
      {20 + apart, 300 + apart, T_first_from.inverse() * lie * T_first_to, information, true});
  const std::size_t edges = walk.graph.edges.size();
  const RobustReport report = relax_robustly(walk.graph);
  return int{report.kept[edges - 1]} + int{report.kept[edges - 2]};
}

TEST(RobustRelax, KeepsNoPairThatHardlyAgreesButWithItself) {
  for (const int apart : {13, 19, 25}) {
    EXPECT_EQ(pair_kept(apart), 0) << apart;
  }
}

TEST(RobustRelax, LooksAtNoPoseButTheFirst) {
  Walk walk = random_walk(200, kSide_m, {}, Rng(70));
  PoseGraph elsewhere = walk.graph;
  for (std::size_t i = 1; i < elsewhere.T_map_node.size(); ++i) {
    elsewhere.T_map_node[i] = {};
  }
  relax_robustly(walk.graph);
  relax_robustly(elsewhere);
  EXPECT_LT(rms_m(walk.graph.T_map_node, elsewhere.T_map_node), kRoundoff);
}

TEST(RobustRelax, GivesTheSameBitsAgain) {
  Walk walk = random_walk(200, kSide_m, {}, Rng(80));
  add_false_closures(walk.graph, 40, kSide_m, Rng(81));
  PoseGraph again = walk.graph;
  double told = 0;
  const RobustReport a = relax_robustly(walk.graph);
  int steps = 0;
  const RobustReport b = relax_robustly(
      again, [&told](double done) { told = done; }, [&steps](const RelaxReport&) { ++steps; });
  EXPECT_EQ(walk.graph.T_map_node, again.T_map_node);
  EXPECT_EQ(a.kept, b.kept);
  EXPECT_EQ(told, 1);
  EXPECT_GE(steps, b.relax.iterations);
}

TEST(RobustRelax, EndsWithTheBestSoFarWhereverItIsStopped) {
  Walk walk = random_walk(200, kSide_m, {}, Rng(80));
  add_false_closures(walk.graph, 40, kSide_m, Rng(81));
  int asked = 0;
  PoseGraph whole = walk.graph;
  const RobustReport done = relax_robustly(whole, {}, {}, [&asked](double) {
    ++asked;
    return false;
  });
  EXPECT_FALSE(done.stopped);
  EXPECT_TRUE(done.relax.converged);
  ASSERT_GT(asked, 10);
  for (int after = 0; after < asked; after += std::max(1, asked / 20)) {
    PoseGraph graph = walk.graph;
    int left = after;
    const RobustReport report =
        relax_robustly(graph, {}, {}, [&left](double) { return left-- <= 0; });
    EXPECT_TRUE(report.stopped) << after;
    EXPECT_FALSE(report.relax.converged) << after;
    PoseGraph kept{graph.T_map_node, {}};
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      if (report.kept[e]) {
        kept.edges.push_back(graph.edges[e]);
      }
    }
    EXPECT_EQ(odometry_gap(kept), std::nullopt) << after;
    EXPECT_NEAR(report.relax.chi2_end, chi2(kept), kRoundoff * (1 + chi2(kept))) << after;
  }
}

TEST(Plausibility, IsThatOfNoiseUpToTwiceAsLargeAsStated) {
  for (const double stated : {1.0, 0.55, 0.4}) {
    Walk walk = random_walk(400, kSide_m, {.stated = stated}, Rng(95));
    relax(walk.graph);
    const Plausibility noise = plausibility(walk.graph);
    EXPECT_EQ(noise.degrees_of_freedom, 3 * closures(walk.graph));
    EXPECT_EQ(noise.plausible, stated > 0.5) << stated;
  }
  Walk walk = random_walk(100, kSide_m, {}, Rng(96));
  std::erase_if(walk.graph.edges, [](const GraphEdge& e) { return e.closure; });
  EXPECT_TRUE(plausibility(walk.graph).plausible);
}

TEST(RobustRelax, NeedsOdometry) {
  Walk walk = random_walk(100, kSide_m, {}, Rng(90));
  EXPECT_EQ(odometry_gap(walk.graph), std::nullopt);
  std::erase_if(walk.graph.edges, [](const GraphEdge& e) { return e.from == 41 && e.to == 42; });
  EXPECT_EQ(odometry_gap(walk.graph), 42);
  EXPECT_THROW(relax_robustly(walk.graph), CheckError);
  PoseGraph nothing;
  EXPECT_EQ(odometry_gap(nothing), std::nullopt);
  EXPECT_EQ(relax_robustly(nothing).rejected, 0);
}

}  // namespace
}  // namespace panoptes
