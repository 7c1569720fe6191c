// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/turn_by_directions.h"

#include <gtest/gtest.h>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

Vec3 drawn_direction(Rng& rng) {
  return Vec3(rng.normal(), rng.normal(), rng.normal()).normalized();
}

/// So many pairs of a turn, with noise, and then false ones.
std::vector<DirectionPair> drawn_pairs(const Eigen::Quaterniond& R_a_b, int count, int false_count,
                                       double noise_rad, Rng& rng) {
  std::vector<DirectionPair> pairs;
  for (int i = 0; i < count + false_count; ++i) {
    const Vec3 in_b = drawn_direction(rng);
    const Vec3 noise = noise_rad * Vec3(rng.normal(), rng.normal(), rng.normal());
    const Vec3 in_a = i < count ? (R_a_b * in_b + noise).normalized() : drawn_direction(rng);
    pairs.push_back({in_a, in_b, 4 * noise_rad + 1e-9});
  }
  return pairs;
}

TEST(TurnByDirections, IsExactWherePairsAre) {
  Rng rng(1);
  const Eigen::Quaterniond R_a_b = turned_by({0.3, -1.2, 0.5});
  const auto turn = turn_by_directions(drawn_pairs(R_a_b, 20, 0, 0, rng), 20, Rng(2));
  ASSERT_TRUE(turn);
  EXPECT_LT(turn->R_a_b.angularDistance(R_a_b), 1e-9);
  EXPECT_EQ(turn->agree.size(), 20);
}

TEST(TurnByDirections, IsFoundAmongFalsePairs) {
  Rng rng(3);
  const Eigen::Quaterniond R_a_b = turned_by({-0.1, 0.02, 2.9});
  const auto turn = turn_by_directions(drawn_pairs(R_a_b, 60, 140, 0.01, rng), 20, Rng(4));
  ASSERT_TRUE(turn);
  EXPECT_LT(turn->R_a_b.angularDistance(R_a_b), 0.005);
  EXPECT_GE(turn->agree.size(), 55);
  EXPECT_LE(turn->agree.size(), 62);
}

TEST(TurnByDirections, IsNotToldByChance) {
  Rng rng(5);
  const auto pairs = drawn_pairs(Eigen::Quaterniond::Identity(), 0, 200, 0.01, rng);
  EXPECT_FALSE(turn_by_directions(pairs, 20, Rng(6)));
}

TEST(TurnByDirections, NeedsTwoPairs) {
  Rng rng(7);
  EXPECT_FALSE(turn_by_directions({}, 0, Rng(8)));
  EXPECT_FALSE(turn_by_directions(drawn_pairs(turned_by({1, 0, 0}), 1, 0, 0, rng), 1, Rng(8)));
}

}  // namespace
}  // namespace panoptes
