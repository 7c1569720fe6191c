// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/shared_graph.h"

#include <cmath>
#include <utility>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "core/graph/normal_equations.h"
#include "tests/core/graph/random_walk.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-6;

SharedGraph without_states(const PoseGraph& plain) {
  SharedGraph graph;
  graph.T_map_node = plain.T_map_node;
  graph.state = Eigen::VectorXd(0);
  graph.prior_information = Eigen::MatrixXd(0, 0);
  for (const GraphEdge& edge : plain.edges) {
    graph.edges.push_back({edge, graph.state, {}});
  }
  return graph;
}

TEST(SharedGraph, WithoutStatesIsAPoseGraph) {
  Walk walk = random_walk(120, 8, {}, Rng(1));
  SharedGraph shared = without_states(walk.graph);
  EXPECT_NEAR(chi2(shared), chi2(walk.graph), kRoundoff * chi2(walk.graph));
  relax(shared);
  relax(walk.graph);
  for (std::size_t k = 0; k < walk.graph.T_map_node.size(); ++k) {
    const Pose2 off = walk.graph.T_map_node[k].inverse() * shared.T_map_node[k];
    EXPECT_LT(off.position().norm(), 1e-4);
    EXPECT_LT(std::abs(off.theta_rad), 1e-4);
  }
  const Mat3 exact = relative_covariance(walk.graph, 10, 90);
  EXPECT_LT((SharedUncertainty(shared).relative(10, 90) - exact).norm(), 1e-3 * exact.norm());
}

// A wheel base that is wrong by a share: every turn that is told is too large by it.
struct Turns {
  static constexpr double kBaseWrong = 0.03;
  static constexpr double kSigma_rad = 0.002;
  static constexpr double kSigma_m = 0.005;
  std::vector<Pose2> truth;
  SharedGraph graph;

  explicit Turns(std::uint64_t seed, bool joined) {
    Rng rng(seed);
    graph.state = Eigen::VectorXd::Zero(1);
    graph.prior_information = Eigen::MatrixXd::Constant(1, 1, 1 / (0.05 * 0.05));
    truth.push_back({});
    graph.T_map_node.push_back({});
    const Mat3 information =
        Vec3(kSigma_m, kSigma_m, kSigma_rad).cwiseAbs2().cwiseInverse().asDiagonal();
    for (int k = 0; k < 48; ++k) {
      const Pose2 step{0.3, 0, k % 2 == 0 ? 0 : deg_to_rad(15)};
      const Pose2 told{step.x_m + rng.normal(0, kSigma_m), step.y_m + rng.normal(0, kSigma_m),
                       step.theta_rad * (1 + kBaseWrong) + rng.normal(0, kSigma_rad)};
      truth.push_back(truth.back() * step);
      graph.T_map_node.push_back(graph.T_map_node.back() * told);
      SharedEdge edge{{k, k + 1, told, information, false}, graph.state, Eigen::MatrixXd(3, 1)};
      edge.by_state << 0, 0, -told.theta_rad;
      if (!joined) {
        graph.edges.push_back(edge);
        continue;
      }
      // the same as a joint edge of one step: how far it is from what is told, given the state
      Eigen::MatrixXd J(3, 4);
      J << Mat3::Identity(), -edge.by_state;
      graph.joints.push_back(
          {k, {told}, graph.state, J.transpose() * information * J, Eigen::VectorXd::Zero(4)});
    }
  }

  void close(Rng rng) {
    const Pose2 T = truth.front().inverse() * truth.back();
    const Mat3 information = Vec3(0.01, 0.01, 0.005).cwiseAbs2().cwiseInverse().asDiagonal();
    graph.edges.push_back({{0,
                            48,
                            {T.x_m + rng.normal(0, 0.01), T.y_m + rng.normal(0, 0.01), T.theta_rad},
                            information,
                            true},
                           {},
                           {}});
  }
};

TEST(SharedGraph, ALoopShowsWhatEdgesHaveInCommon) {
  for (const bool joined : {false, true}) {
    Turns turns(3, joined);
    const double before = state_covariance(turns.graph)(0, 0);
    EXPECT_NEAR(before, 0.05 * 0.05, 1e-9);  // nothing has shown it
    turns.close(Rng(4));
    ASSERT_TRUE(relax(turns.graph).converged);
    const double sigma = std::sqrt(state_covariance(turns.graph)(0, 0));
    EXPECT_LT(sigma, 0.005);
    // told = true (1 + wrong), told + by_state * state = true
    const double true_state = Turns::kBaseWrong / (1 + Turns::kBaseWrong);
    EXPECT_NEAR(turns.graph.state[0], true_state, 4 * sigma);
    for (std::size_t k = 0; k < turns.truth.size(); ++k) {
      const Pose2 off = turns.truth[k].inverse() * turns.graph.T_map_node[k];
      EXPECT_LT(off.position().norm(), 0.06);
    }
  }
}

TEST(SharedGraph, JointsAndEdgesThatSayTheSameAreTheSame) {
  Turns apart(5, false);
  Turns joined(5, true);
  apart.close(Rng(6));
  joined.close(Rng(6));
  EXPECT_NEAR(chi2(apart.graph), chi2(joined.graph), 1e-6 * chi2(apart.graph));
  const Mat3 covariance = SharedUncertainty(apart.graph).relative(5, 40);
  EXPECT_LT((SharedUncertainty(joined.graph).relative(5, 40) - covariance).norm(),
            kRoundoff * covariance.norm());
  relax(apart.graph);
  relax(joined.graph);
  EXPECT_NEAR(apart.graph.state[0], joined.graph.state[0], 1e-5);
}

// Two steps in one joint edge, seen from where the first begins, are two edges.
TEST(SharedGraph, AJointOfSeveralStepsIsTheirEdgesTogether) {
  Turns apart(11, false);
  SharedGraph joined = apart.graph;
  joined.edges.clear();
  for (int k = 0; k < 48; k += 2) {
    const SharedEdge& one = apart.graph.edges[k];
    const SharedEdge& two = apart.graph.edges[k + 1];
    const Pose2 T_first_second = one.edge.T_from_to;
    const Pose2 T_first_third = T_first_second * two.edge.T_from_to;
    const RelativeJacobian second = relative_jacobian(T_first_second, T_first_third);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6, 7);
    J.topLeftCorner<3, 3>().setIdentity();
    J.block<3, 1>(0, 6) = -one.by_state;
    J.block<3, 3>(3, 0) = second.from;
    J.block<3, 3>(3, 3) = second.to;
    J.block<3, 1>(3, 6) = -two.by_state;
    Eigen::MatrixXd W = Eigen::MatrixXd::Zero(6, 6);
    W.topLeftCorner<3, 3>() = one.edge.information;
    W.bottomRightCorner<3, 3>() = two.edge.information;
    joined.joints.push_back({k,
                             {T_first_second, T_first_third},
                             joined.state,
                             J.transpose() * W * J,
                             Eigen::VectorXd::Zero(7)});
  }
  EXPECT_NEAR(chi2(joined), chi2(apart.graph), kRoundoff);
  for (const auto& [from, to] : {std::pair(0, 48), std::pair(5, 40), std::pair(31, 8)}) {
    const Mat3 exact = SharedUncertainty(apart.graph).relative(from, to);
    EXPECT_LT((SharedUncertainty(joined).relative(from, to) - exact).norm(),
              kRoundoff * exact.norm());
  }
}

TEST(SharedGraph, PairwiseKeepsWhereNodesAreAndHowTheyFollowTheState) {
  Turns turns(7, true);
  for (const JointEdge& joint : turns.graph.joints) {
    for (const double state : {0.0, 0.02}) {
      const std::vector<SharedEdge> edges =
          pairwise_edges(joint, Eigen::VectorXd::Constant(1, state));
      ASSERT_EQ(edges.size(), 1U);
      const Pose2& told = joint.T_first_node[0];
      EXPECT_NEAR(edges[0].edge.T_from_to.theta_rad, told.theta_rad * (1 - state), 1e-12);
      EXPECT_NEAR(edges[0].by_state(2, 0), -told.theta_rad, 1e-9);
    }
  }
  const PoseGraph plain = pairwise(turns.graph);
  EXPECT_EQ(plain.edges.size(), turns.graph.joints.size());
  // an edge that turns is as vague as the state is, one that does not is not
  EXPECT_GT(plain.edges[0].information(2, 2), 5 * plain.edges[1].information(2, 2));
}

// What all edges get wrong together adds up by itself, not by squares.
TEST(SharedGraph, APathIsNeverSurerThanItsMarginal) {
  for (const bool joined : {false, true}) {
    const Turns turns(8, joined);
    const std::vector<Mat3> along = path_covariances(turns.graph, 4, state_covariance(turns.graph));
    for (const int to : {5, 20, 48}) {
      const Mat3 exact = SharedUncertainty(turns.graph).relative(4, to);
      EXPECT_GE(along[to](2, 2), exact(2, 2) * (1 - 1e-6));
      EXPECT_LT(along[to](2, 2), exact(2, 2) * 1.2);
    }
  }
}

// Held at a value, states that change afterwards move nothing that was measured before.
TEST(SharedGraph, EdgesThatAreHeldFollowTheirStatesNoMore) {
  for (const bool joined : {false, true}) {
    Turns turns(13, joined);
    turns.close(Rng(14));
    relax(turns.graph);
    SharedGraph held = turns.graph;
    const Eigen::VectorXd as_measured = held.state;
    for (JointEdge& joint : held.joints) {
      hold(joint, 0, 1, as_measured);
    }
    for (SharedEdge& shared : held.edges) {
      hold(shared, 0, 1, as_measured);
    }
    held.state[0] += 0.3;
    relax(held);
    // their own prior is all that is left of them
    EXPECT_NEAR(held.state[0], 0, 1e-9);
    EXPECT_NEAR(state_covariance(held)(0, 0), 1 / held.prior_information(0, 0),
                1e-6 / held.prior_information(0, 0));
    for (std::size_t k = 0; k < turns.truth.size(); ++k) {
      const Pose2 off = turns.graph.T_map_node[k].inverse() * held.T_map_node[k];
      EXPECT_LT(off.position().norm(), 1e-4) << k;
      EXPECT_LT(std::abs(off.theta_rad), 1e-4) << k;
    }
  }
}

TEST(SharedGraph, SameBitsEveryTime) {
  Turns first(9, true);
  Turns second(9, true);
  first.close(Rng(10));
  second.close(Rng(10));
  relax(first.graph);
  relax(second.graph);
  EXPECT_EQ(first.graph.state, second.graph.state);
  EXPECT_EQ(first.graph.T_map_node, second.graph.T_map_node);
}

}  // namespace
}  // namespace panoptes
