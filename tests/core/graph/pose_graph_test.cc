// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/pose_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/base/rng.h"
#include "core/graph/descent.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-6;  // what a converged relaxation leaves
constexpr double kPi = std::numbers::pi;

struct World {
  PoseGraph graph;  // poses dead reckoned
  std::vector<Pose2> truth;
};

Pose2 noisy(const Pose2& T, double sigma_m, double sigma_rad, Rng& rng) {
  return {T.x_m + rng.normal(0, sigma_m), T.y_m + rng.normal(0, sigma_m),
          wrap_angle(T.theta_rad + rng.normal(0, sigma_rad))};
}

// A walk over a square of streets, `side` steps each, round and round, with noise and a closure
// each time a corner is met again.
World square_walk(int rounds, int side, double sigma_m, double sigma_rad, Rng rng) {
  World world;
  world.truth.emplace_back();
  world.graph.T_map_node.emplace_back();
  const Mat3 information =
      Vec3(1 / (sigma_m * sigma_m), 1 / (sigma_m * sigma_m), 1 / (sigma_rad * sigma_rad))
          .asDiagonal();
  const int corners = 4 * rounds;
  for (int corner = 0; corner < corners; ++corner) {
    for (int step = 0; step < side; ++step) {
      const Pose2 T_before_after{0.25, 0, step + 1 == side ? kPi / 2 : 0};
      const Pose2 measured = noisy(T_before_after, sigma_m, sigma_rad, rng);
      const int from = static_cast<int>(world.truth.size()) - 1;
      world.truth.push_back(world.truth.back() * T_before_after);
      world.graph.T_map_node.push_back(world.graph.T_map_node.back() * measured);
      world.graph.edges.push_back({from, from + 1, measured, information, false});
    }
    if (corner >= 4) {
      const int recent = static_cast<int>(world.truth.size()) - 1;
      const int earlier = recent - 4 * side;
      const Pose2 T = world.truth[earlier].inverse() * world.truth[recent];
      world.graph.edges.push_back(
          {earlier, recent, noisy(T, sigma_m, sigma_rad, rng), information, true});
    }
  }
  return world;
}

double rms_m(const World& world) {
  double sum = 0;
  for (std::size_t i = 0; i < world.truth.size(); ++i) {
    sum += (world.truth[i].position() - world.graph.T_map_node[i].position()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(world.truth.size()));
}

TEST(DeadReckon, FollowsOdometryAndClosuresOnlyWhereThereIsNone) {
  World world = square_walk(2, 10, 0.005, 0.01, Rng(1));
  PoseGraph graph = world.graph;
  std::rotate(graph.edges.begin(), graph.edges.end() - 1, graph.edges.end());  // a closure first
  for (std::size_t i = 1; i < graph.T_map_node.size(); ++i) {
    graph.T_map_node[i] = {9, 9, 9};
  }
  EXPECT_EQ(dead_reckon(graph), std::nullopt);
  EXPECT_EQ(graph.T_map_node, world.graph.T_map_node);
  // without one of the steps, what follows hangs on closures
  const auto step = std::find_if(graph.edges.begin(), graph.edges.end(),
                                 [](const GraphEdge& e) { return e.from == 60 && e.to == 61; });
  ASSERT_NE(step, graph.edges.end());
  graph.edges.erase(step);
  EXPECT_EQ(dead_reckon(graph), std::nullopt);
  EXPECT_LT((graph.T_map_node[61].position() - world.truth[61].position()).norm(), 0.5);
  graph.edges.erase(std::remove_if(graph.edges.begin(), graph.edges.end(),
                                   [](const GraphEdge& e) { return std::max(e.from, e.to) > 60; }),
                    graph.edges.end());
  EXPECT_EQ(dead_reckon(graph), 61);
}

TEST(Relax, RecoversTheTruthWithoutNoise) {
  World world = square_walk(2, 10, 1e-3, 1e-3, Rng(1));
  for (GraphEdge& edge : world.graph.edges) {
    edge.T_from_to = world.truth[edge.from].inverse() * world.truth[edge.to];
  }
  const RelaxReport report = relax(world.graph);
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(report.chi2_end, 0, kRoundoff);
  EXPECT_LT(rms_m(world), kRoundoff);
}

TEST(Relax, ClosuresTakeMostOfTheDriftAway) {
  World world = square_walk(3, 20, 0.005, 0.01, Rng(2));
  const double before_m = rms_m(world);
  const RelaxReport report = relax(world.graph);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(rms_m(world), before_m / 2);
  EXPECT_NEAR(report.chi2_end, chi2(world.graph), kRoundoff);
  // chi2 is about one a degree of freedom: 3 (edges - nodes + 1), within five sigma
  const double degrees_of_freedom =
      3.0 * static_cast<double>(world.graph.edges.size() - world.graph.T_map_node.size() + 1);
  EXPECT_NEAR(report.chi2_end, degrees_of_freedom, 5 * std::sqrt(2 * degrees_of_freedom));
  EXPECT_EQ(world.graph.T_map_node[0], Pose2());
}

TEST(Relax, NeedsNoGoodStart) {
  World world = square_walk(3, 20, 0.005, 0.01, Rng(3));
  PoseGraph best = world.graph;
  const double chi2_best = relax(best).chi2_end;
  Rng rng(4);
  for (std::size_t i = 1; i < world.graph.T_map_node.size(); ++i) {
    world.graph.T_map_node[i] = {rng.uniform(-10, 10), rng.uniform(-10, 10),
                                 rng.uniform(-kPi, kPi)};
  }
  PoseGraph linear = world.graph;
  EXPECT_NEAR(relax(linear).chi2_end, chi2_best, kRoundoff * chi2_best);
  PoseGraph current = world.graph;
  EXPECT_NEAR(relax(current, RelaxStart::kCurrent).chi2_end, chi2_best, kRoundoff * chi2_best);
}

TEST(Relax, GivesTheSameBitsAgain) {
  World a = square_walk(3, 20, 0.005, 0.01, Rng(5));
  World b = square_walk(3, 20, 0.005, 0.01, Rng(5));
  relax(a.graph);
  relax(b.graph);
  EXPECT_EQ(a.graph.T_map_node, b.graph.T_map_node);
}

TEST(Relax, ShowsAFalseLoopByItsChi2) {
  World world = square_walk(3, 20, 0.005, 0.01, Rng(6));
  const double honest = relax(world.graph).chi2_end;
  GraphEdge lie = world.graph.edges.back();
  lie.from = 15;
  lie.to = 130;
  lie.T_from_to = {};
  world.graph.edges.push_back(lie);
  const double growth = relax(world.graph, RelaxStart::kCurrent).chi2_end - honest;
  EXPECT_GT(growth, 100);
}

TEST(Relax, LeavesALonelyGraphAlone) {
  PoseGraph graph;
  EXPECT_TRUE(relax(graph).converged);
  graph.T_map_node = {{1, 2, 3}, {4, 5, 6}};
  EXPECT_TRUE(relax(graph).converged);
  EXPECT_EQ(graph.T_map_node[1], (Pose2{4, 5, 6}));
  graph.edges.push_back({0, 2, {}, Mat3::Identity(), false});
  EXPECT_THROW(relax(graph), CheckError);
}

TEST(Relax, SaysThatItGaveUp) {
  // numbers so large that no step can be computed, though the error can
  PoseGraph graph;
  graph.T_map_node = {{0, 0, 0}, {1e6, 0, 0}, {2e6, 0, 0}};
  for (const int from : {0, 1}) {
    graph.edges.push_back({from, from + 1, {1e6 - 1, 0, 0}, 1e300 * Mat3::Identity(), false});
  }
  PoseGraph alone = graph;
  EXPECT_FALSE(descend(alone).converged);
  for (const RelaxStart start : {RelaxStart::kLinear, RelaxStart::kCurrent}) {
    PoseGraph tried = graph;
    const RelaxReport report = relax(tried, start);
    EXPECT_FALSE(report.converged);
  }
}

TEST(Relax, HasNotConvergedWhereSomethingIsNotANumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const World world = square_walk(3, 20, 0.005, 0.01, Rng(9));
  PoseGraph best = world.graph;
  relax(best);
  PoseGraph lost = world.graph;
  lost.T_map_node[30].x_m = nan;
  EXPECT_FALSE(descend(lost).converged);
  const RelaxReport report = relax(lost, RelaxStart::kCurrent);  // by the linear start
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(report.chi2_end, chi2(best), kRoundoff * chi2(best));
  PoseGraph unmeasured = world.graph;
  unmeasured.edges.back().T_from_to.theta_rad = nan;
  EXPECT_FALSE(relax(unmeasured, RelaxStart::kCurrent).converged);
  EXPECT_FALSE(relax(unmeasured, RelaxStart::kLinear).converged);
}

TEST(Relax, HasConvergedAtABottomThatRoundingHides) {
  World world = square_walk(2, 10, 1e-3, 1e-3, Rng(10));
  for (GraphEdge& edge : world.graph.edges) {
    edge.T_from_to = world.truth[edge.from].inverse() * world.truth[edge.to];
  }
  world.graph.T_map_node = world.truth;
  EXPECT_TRUE(descend(world.graph).converged);
  PoseGraph far = world.graph;
  far.T_map_node[0] = {3000, -2000, 1};
  dead_reckon(far);
  EXPECT_TRUE(descend(far).converged);
}

TEST(Relax, EndsWithTheBestSoFarWhenToldTo) {
  World world = square_walk(3, 20, 0.005, 0.01, Rng(11));
  int left = 2;
  double most = 0;
  const RelaxReport report =
      relax(world.graph, RelaxStart::kCurrent, {}, [&](double multiplications) {
        most = std::max(most, multiplications);
        return left-- <= 0;
      });
  const auto unknowns = 3.0 * static_cast<double>(world.truth.size() - 1);
  EXPECT_GT(most, unknowns);  // a chain's factor has as many columns, of a few numbers each
  EXPECT_LT(most, unknowns * unknowns * unknowns / 6);  // no more than were it full
  EXPECT_FALSE(report.converged);
  EXPECT_LE(report.iterations, 3);
  EXPECT_LE(report.chi2_end, report.chi2_start);
  EXPECT_NEAR(report.chi2_end, chi2(world.graph), kRoundoff * report.chi2_end);
}

TEST(RelativeCovariance, IsUnknownWhereTheGraphCannotBeSolved) {
  PoseGraph graph;
  graph.T_map_node = {{0, 0, 0}, {1e6, 0, 0}, {2e6, 0, 0}};
  for (const int from : {0, 1}) {
    graph.edges.push_back({from, from + 1, {1e6, 0, 0}, 1e300 * Mat3::Identity(), false});
  }
  const Mat3 covariance = relative_covariance(graph, 0, 1);
  EXPECT_FALSE(covariance.array().isNaN().any());
  EXPECT_TRUE(std::isinf(covariance(0, 0)));
  const Mat3 unknown = path_covariances(PoseGraph{{{}, {}}, {}}, 0)[1];
  EXPECT_FALSE(unknown.array().isNaN().any());
  EXPECT_TRUE(std::isinf(unknown(0, 0)) && std::isinf(unknown(2, 2)));
}

TEST(RelativeCovariance, OfAChainIsDeadReckoning) {
  World world = square_walk(1, 10, 0.005, 0.01, Rng(7));
  PoseGraph& graph = world.graph;
  const auto paths_from_end = path_covariances(graph, 30);
  for (const int to : {3, 17, 29, 31, 40}) {
    const Mat3 exact = relative_covariance(graph, 30, to);
    EXPECT_LT((exact - paths_from_end[to]).norm(), kRoundoff * exact.norm()) << to;
  }
}

TEST(RelativeCovariance, IsThatOfManyWorlds) {
  constexpr int kWorlds = 400;
  Mat3 drawn = Mat3::Zero();
  Mat3 promised;
  for (int i = 0; i < kWorlds; ++i) {
    World world = square_walk(2, 8, 0.005, 0.01, Rng(100 + i));
    relax(world.graph);
    const Pose2 estimate = world.graph.T_map_node[5].inverse() * world.graph.T_map_node[50];
    const Pose2 truth = world.truth[5].inverse() * world.truth[50];
    const Vec3 off(estimate.x_m - truth.x_m, estimate.y_m - truth.y_m,
                   wrap_angle(estimate.theta_rad - truth.theta_rad));
    drawn += off * off.transpose() / kWorlds;
    promised = relative_covariance(world.graph, 5, 50);
  }
  const Vec3 ratio = (promised.inverse() * drawn).eigenvalues().real();
  EXPECT_GT(ratio.minCoeff(), 0.7);
  EXPECT_LT(ratio.maxCoeff(), 1.4);
}

TEST(PathCovariances, OfWhatNoEdgeReachesAreInfiniteAndNoMore) {
  World world = square_walk(1, 10, 0.005, 0.01, Rng(8));
  world.graph.T_map_node.push_back({1, 1, 0});
  const Mat3 lost = path_covariances(world.graph, 3).back();
  EXPECT_TRUE(std::isinf(lost(0, 0)));
  EXPECT_EQ(lost(0, 1), 0);  // not infinity times nothing, which is no number
}

TEST(PathCovariances, TakeNoWayByAnEdgeThatKnowsADirectionBetterThanExactly) {
  World world = square_walk(1, 10, 0.005, 0.01, Rng(8));
  const Mat3 before = path_covariances(world.graph, 3)[20];
  world.graph.edges.push_back({3, 20, {}, Vec3(1e6, 1e6, -1).asDiagonal(), true});
  EXPECT_EQ(path_covariances(world.graph, 3)[20], before);
}

TEST(PathCovariances, AreNeverSmallerThanTheMarginal) {
  World world = square_walk(3, 10, 0.005, 0.01, Rng(8));
  relax(world.graph);
  const auto paths = path_covariances(world.graph, 119);
  for (const int to : {2, 20, 45, 80, 100}) {
    const Mat3 slack = paths[to] - relative_covariance(world.graph, 119, to);
    Eigen::SelfAdjointEigenSolver<Mat3> solver(slack);
    EXPECT_GT(solver.eigenvalues().minCoeff(), -kRoundoff) << to;
  }
}

}  // namespace
}  // namespace panoptes
