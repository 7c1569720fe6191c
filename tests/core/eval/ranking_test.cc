// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/ranking.h"

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr int kSeeds = 8;

// Seeds differ by more than contenders, as drives do.
std::vector<ScoreBySeed> noisy(Rng& rng, const std::vector<double>& truths) {
  std::vector<ScoreBySeed> contenders(truths.size());
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const double of_seed = rng.normal(0, 10);
    for (std::size_t i = 0; i < truths.size(); ++i) {
      contenders[i][seed] = truths[i] + of_seed + rng.normal();
    }
  }
  return contenders;
}

TEST(Ranking, IsByTheMean) {
  const std::vector<ScoreBySeed> contenders{
      {{1, 5}, {2, 7}}, {{1, 1}, {2, 2}}, {}, {{1, 4}, {2, 8}}};
  const auto most = rank(contenders, false);
  EXPECT_EQ(most[0]->rank, 1);
  EXPECT_EQ(most[1]->rank, 3);
  EXPECT_FALSE(most[2]) << "it has no value";
  EXPECT_EQ(most[3]->rank, 1) << "the same mean";
  EXPECT_EQ(most[1]->mean.mean, 1.5);
  const auto least = rank(contenders, true);
  EXPECT_EQ(least[1]->rank, 1);
  EXPECT_EQ(least[0]->rank, 2);
  EXPECT_EQ(least[3]->rank, 2);
  EXPECT_TRUE(least[1]->not_distinguishable_from_best);
  EXPECT_FALSE(least[1]->detectable) << "of the best itself";
}

TEST(Ranking, PutsThoseOfFewerSeedsBehind) {
  const auto standings = rank({{{1, 1}}, {{1, 3}, {2, 9}}}, true);
  EXPECT_EQ(standings[0]->rank, 2) << "it has not met the harder seed";
  EXPECT_EQ(standings[1]->rank, 1);
}

TEST(Ranking, SeesBySeedsWhatTheySpreadOver) {
  Rng rng(3);
  const auto standings = rank(noisy(rng, {0, 5, 0.2}), true);
  EXPECT_EQ(standings[1]->rank, 3);
  EXPECT_FALSE(standings[1]->not_distinguishable_from_best);
  EXPECT_TRUE(standings[0]->not_distinguishable_from_best);
  EXPECT_TRUE(standings[2]->not_distinguishable_from_best);
}

// Contenders that are all the same are told apart in few studies, however many they are; and a
// difference of the size that is called detectable shows in most.
TEST(Ranking, IsRightAboutWhatItCanTell) {
  Rng rng(1);
  constexpr int kStudies = 300;
  int wrong = 0;
  double detectable = 0;
  for (int k = 0; k < kStudies; ++k) {
    const auto same = rank(noisy(rng, {0, 0, 0, 0}), true);
    bool told_apart = false;
    for (const auto& standing : same) {
      told_apart = told_apart || !standing->not_distinguishable_from_best;
      detectable += standing->detectable.value_or(0) / (3.0 * kStudies);
    }
    wrong += told_apart ? 1 : 0;
  }
  // The best is chosen by the same seeds, so that more than one in twenty are.
  EXPECT_LT(wrong, kStudies / 6);
  int told = 0;
  for (int k = 0; k < kStudies; ++k) {
    told += rank(noisy(rng, {0, detectable}), true)[1]->not_distinguishable_from_best ? 0 : 1;
  }
  EXPECT_GT(told, kStudies * 7 / 10);
}

TEST(Ranking, TellsNothingOfTooFewSeeds) {
  const auto of_one = rank({{{1, 0}}, {{1, 9}}}, true);
  EXPECT_TRUE(of_one[1]->not_distinguishable_from_best);
  EXPECT_FALSE(of_one[1]->detectable);
  const auto of_two = rank({{{1, 0}, {2, 0}}, {{1, 1}, {2, 1}}}, true);
  EXPECT_TRUE(of_two[1]->not_distinguishable_from_best) << "a coin falls so every other time";
  const auto strangers = rank({{{1, 0}, {2, 0}}, {{3, 1}, {4, 1}}}, true);
  EXPECT_TRUE(strangers[1]->not_distinguishable_from_best) << "no seed in common";
  EXPECT_FALSE(strangers[1]->detectable);
  ScoreBySeed none;
  ScoreBySeed always;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    none[seed] = 0;
    always[seed] = 1;
  }
  EXPECT_FALSE(rank({none, always}, true)[1]->not_distinguishable_from_best);
}

TEST(Ranking, OfNobodyIsNothing) {
  EXPECT_TRUE(rank({}, true).empty());
  EXPECT_FALSE(rank({{}}, true)[0]);
}

TEST(Dominates, IsBetterInSomeAndWorseInNone) {
  EXPECT_TRUE(dominates({1, 2}, {1, 3}));
  EXPECT_FALSE(dominates({1, 2}, {1, 2}));
  EXPECT_FALSE(dominates({1, 2}, {0, 3}));
}

}  // namespace
}  // namespace panoptes
