// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/edges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-12;

// A chain of so many motions, of which `errors` went into the edges.
class EdgeFiguresTest : public testing::Test {
 protected:
  void move(const Pose2& T, const Vec3& error, const Mat3& information = Mat3::Identity()) {
    if (truth_.empty()) {
      truth_.push_back(Pose2{1, 2, 0.5});
      graph_.T_map_node.push_back(Pose2{});
    }
    const Pose2 seen{T.x_m + error.x(), T.y_m + error.y(), wrap_angle(T.theta_rad + error.z())};
    const int last = static_cast<int>(truth_.size()) - 1;
    graph_.edges.push_back({last, last + 1, seen, information, false});
    graph_.T_map_node.push_back(graph_.T_map_node.back() * seen);
    truth_.push_back(truth_.back() * T);
  }

  PoseGraph graph_;
  std::vector<Pose2> truth_;
};

TEST_F(EdgeFiguresTest, TellsWhatTurningBiasesFromWhatDrivingDoes) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Pose2 T{rng.uniform(0.1, 0.3), 0.01, rng.uniform(-0.2, 0.2)};
    move(T, {0, 0, 0.002 * T.position().norm() + 0.01 * T.theta_rad});
  }
  const EdgeFigures figures = edge_figures(graph_, truth_);
  EXPECT_EQ(figures.spins.count, 0);
  EXPECT_EQ(figures.driving.count, 100);
  EXPECT_NEAR(figures.driving.heading_bias_rad_per_m.value(), 0.002, kRoundoff);
  EXPECT_NEAR(figures.driving.heading_bias_share_of_turn.value(), 0.01, kRoundoff);
}

TEST_F(EdgeFiguresTest, SpinsToBothSidesHaveOneBias) {
  for (int i = 0; i < 40; ++i) {
    const double turn = i % 3 == 0 ? -0.2 : 0.2;
    move({0, 0, turn}, {0, 0, 0.004 * turn});
    move({0.25, 0, 0}, {0, 0, 0});
  }
  const EdgeFigures figures = edge_figures(graph_, truth_);
  EXPECT_EQ(figures.spins.count, 40);
  EXPECT_EQ(figures.driving.count, 40);
  EXPECT_NEAR(figures.spins.heading_bias_share_of_turn.value(), 0.004, kRoundoff);
  EXPECT_FALSE(figures.spins.heading_bias_rad_per_m);
  EXPECT_NEAR(figures.spins.heading_rms_rad, 0.0008, kRoundoff);
  EXPECT_NEAR(figures.driving.heading_bias_rad_per_m.value(), 0, kRoundoff);
  EXPECT_FALSE(figures.driving.heading_bias_share_of_turn);
}

TEST_F(EdgeFiguresTest, OnlyConsecutiveKeyframesCount) {
  for (int i = 0; i < 5; ++i) {
    move({0.25, 0, 0}, Vec3::Zero());
  }
  graph_.edges.push_back({0, 4, Pose2{1.5, 0, 0.1}, Mat3::Identity(), false});
  graph_.edges.push_back({1, 3, Pose2{0.6, 0, 0}, Mat3::Identity(), true});
  const EdgeFigures figures = edge_figures(graph_, truth_);
  EXPECT_EQ(figures.driving.count, 5);
  EXPECT_NEAR(figures.driving.nees, 0, kRoundoff);
}

TEST_F(EdgeFiguresTest, HonestCovariancesHaveANormalisedErrorOfOne) {
  Rng rng(5);
  const Vec3 sigma(0.01, 0.02, 0.003);
  const Mat3 information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  for (int i = 0; i < 3000; ++i) {
    const Vec3 error(rng.normal(), rng.normal(), rng.normal());
    move({0.25, 0, 0.1}, sigma.cwiseProduct(error), information);
  }
  const EdgeFigures figures = edge_figures(graph_, truth_);
  EXPECT_NEAR(figures.driving.nees, 1, 0.05);
  EXPECT_NEAR(figures.driving.heading_rms_rad, sigma.z(), 0.05 * sigma.z());
  EXPECT_NEAR(figures.driving.position_rms_m, sigma.head<2>().norm(), 0.05 * sigma.y());
}

TEST_F(EdgeFiguresTest, ClosuresAreNoneOfThem) {
  move({0.25, 0, 0}, {0, 0, 0});
  graph_.edges.push_back({0, 1, {5, 5, 1}, Mat3::Identity(), true});
  EXPECT_EQ(edge_figures(graph_, truth_).driving.count, 1);
  EXPECT_NEAR(edge_figures(graph_, truth_).driving.nees, 0, kRoundoff);
}

TEST_F(EdgeFiguresTest, NothingIsSaidOfNoEdges) {
  EXPECT_EQ(edge_figures({}, {}).driving.count, 0);
}

}  // namespace
}  // namespace panoptes
