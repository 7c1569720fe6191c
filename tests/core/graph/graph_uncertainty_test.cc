// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/graph_uncertainty.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/core/graph/random_walk.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-6;

struct Pair {
  int from, to;
};
constexpr Pair kPairs[] = {{0, 5}, {120, 0}, {10, 299}, {150, 151}, {200, 30}};

TEST(GraphUncertainty, IsTheMarginalOfAFactorisationForEachPair) {
  Walk walk = random_walk(300, 15, {}, Rng(1));
  relax(walk.graph);
  const GraphUncertainty uncertainty(walk.graph);
  for (const auto& [from, to] : kPairs) {
    const Mat3 exact = relative_covariance(walk.graph, from, to);
    EXPECT_LT((uncertainty.relative(from, to) - exact).norm(), kRoundoff * exact.norm());
  }
}

TEST(GraphUncertainty, OfDrawsIsCloseToTheMarginal) {
  Walk walk = random_walk(300, 15, {}, Rng(2));
  relax(walk.graph);
  const GraphUncertainty uncertainty(walk.graph);
  for (const auto& [from, to] : kPairs) {
    const Mat3 exact = uncertainty.relative(from, to);
    const Vec3 ratio =
        (exact.inverse() * uncertainty.relative_roughly(from, to)).eigenvalues().real();
    // eigenvalues of a covariance of 64 draws in three dimensions: (1 +- sqrt(3/64))^2, and a bit
    EXPECT_GT(ratio.minCoeff(), 0.4);
    EXPECT_LT(ratio.maxCoeff(), 1.9);
  }
}

}  // namespace
}  // namespace panoptes
