// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/level_motion.h"

#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

// Points before a level camera of some focal length that turns and moves on the floor.
std::vector<PixelPair> seen_twice(int count, double noise_px, Rng rng) {
  const double focal_px = rng.uniform(150, 600);
  const double turn_rad = rng.uniform(-0.3, 0.3);
  const Eigen::Vector3d t(rng.uniform(-0.5, 0.5), 0, rng.uniform(-1, 1));
  const Eigen::AngleAxisd R(turn_rad, Eigen::Vector3d::UnitY());
  const auto noisy = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector2f(static_cast<float>(focal_px * p.x() / p.z() + rng.normal(0, noise_px)),
                           static_cast<float>(focal_px * p.y() / p.z() + rng.normal(0, noise_px)));
  };
  std::vector<PixelPair> pairs;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p(rng.uniform(-2, 2), rng.uniform(-1, 1), rng.uniform(3, 9));
    const Eigen::Vector2f a = noisy(p);
    pairs.push_back({a, noisy(R * p + t)});
  }
  return pairs;
}

std::vector<PixelPair> at_random(int count, Rng rng) {
  std::vector<PixelPair> pairs;
  const auto anywhere = [&] {
    return Eigen::Vector2f(static_cast<float>(rng.uniform(-160, 160)),
                           static_cast<float>(rng.uniform(-120, 120)));
  };
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f a = anywhere();
    pairs.push_back({a, anywhere()});
  }
  return pairs;
}

TEST(LevelMotion, AllAgreeThatWereTrulySeenWhateverTheFocalLength) {
  constexpr double kRoundoff_px = 0.1;  // of single precision, in a thousand pixels
  LevelMotionOptions options;
  options.noise_px = kRoundoff_px;
  for (int seed = 0; seed < 50; ++seed) {
    EXPECT_EQ(level_inliers(options, seen_twice(40, 0, Rng(seed)), Rng(1)), 40) << seed;
  }
}

TEST(LevelMotion, MostAgreeDespiteNoiseAmongTwiceAsManyFalseOnes) {
  const LevelMotionOptions options;
  for (int seed = 0; seed < 20; ++seed) {
    std::vector<PixelPair> pairs = seen_twice(40, 0.5, Rng(seed));
    const std::vector<PixelPair> others = at_random(80, Rng(seed).fork("others"));
    pairs.insert(pairs.end(), others.begin(), others.end());
    EXPECT_GE(level_inliers(options, pairs, Rng(1)), 30) << seed;
  }
}

TEST(LevelMotion, FewAgreeByChance) {
  const LevelMotionOptions options;
  for (int seed = 0; seed < 20; ++seed) {
    EXPECT_LE(level_inliers(options, at_random(100, Rng(seed)), Rng(1)), 20) << seed;
  }
}

TEST(LevelMotion, ChanceIsKnownFromTruth) {
  constexpr double kOneInAMillion = -13.8;  // ln
  for (int seed = 0; seed < 20; ++seed) {
    for (const int count : {40, 100, 300}) {
      const LevelAgreement chance = level_agreement({}, at_random(count, Rng(seed)), Rng(1));
      EXPECT_GT(chance.log_chance, kOneInAMillion / 2)
          << seed << " " << count << " " << chance.inliers;
      std::vector<PixelPair> pairs = seen_twice(count / 2, 0.5, Rng(seed));
      const std::vector<PixelPair> others = at_random(count - count / 2, Rng(seed).fork("others"));
      pairs.insert(pairs.end(), others.begin(), others.end());
      EXPECT_LT(level_agreement({}, pairs, Rng(1)).log_chance, kOneInAMillion)
          << seed << " " << count;
    }
  }
}

TEST(LevelMotion, SaysNothingOfThreePairsWhichAlwaysAgree) {
  EXPECT_EQ(level_inliers({}, seen_twice(3, 0, Rng(1)), Rng(1)), 0);
  EXPECT_EQ(level_inliers({}, {}, Rng(1)), 0);
}

TEST(LevelMotion, SaysTheSameAgain) {
  const std::vector<PixelPair> pairs = at_random(60, Rng(3));
  EXPECT_EQ(level_inliers({}, pairs, Rng(1)), level_inliers({}, pairs, Rng(1)));
}

}  // namespace
}  // namespace panoptes
