// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/alignment_graph.h"

#include <gmock/gmock.h>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::vector<std::string> kNames{"ahead", "left", "behind", "right"};

/// Maps that lie at random, and alignments of pairs of them that are off by what they say.
struct Maps {
  std::vector<Similarity> S_first_map{Similarity()};
  std::vector<MapAlignment> alignments;
  Rng rng;

  Maps(std::size_t count, std::uint64_t seed) : rng(seed) {
    while (S_first_map.size() < count) {
      const double turn_rad = rng.uniform(-3, 3);
      const double scale = rng.uniform(0.3, 3);
      S_first_map.push_back({scale, turned_by({0.1, turn_rad, 0}), Vec3(0.1, -0.2, 0.3)});
    }
  }
  void align(std::size_t a, std::size_t b, std::size_t points, const Similarity& by = {}) {
    MapAlignment alignment;
    alignment.a = a;
    alignment.b = b;
    alignment.far = 3 / S_first_map[a].scale;
    constexpr double kSigma = 0.01;
    SimilarityOffset sigma;
    sigma << Vec3::Constant(kSigma), Vec3::Constant(kSigma * alignment.far), kSigma;
    SimilarityOffset off;
    for (int i = 0; i < off.size(); ++i) {
      off[i] = sigma[i] * rng.normal();
    }
    alignment.agreed.S_a_b = by * moved(S_first_map[a].inverse() * S_first_map[b], off);
    alignment.agreed.covariance = sigma.cwiseAbs2().asDiagonal();
    alignment.agreed.agree.resize(points);
    alignments.push_back(alignment);
  }
  void align_all() {
    for (std::size_t a = 0; a < S_first_map.size(); ++a) {
      for (std::size_t b = a + 1; b < S_first_map.size(); ++b) {
        align(a, b, 10 + a + b);
      }
    }
  }
  double turn_off_deg(const AlignedMaps& found, std::size_t map) const {
    return rad_to_deg(found.S_first_map[map]->rotation.angularDistance(S_first_map[map].rotation));
  }
};

TEST(AlignmentGraph, WhatLeadsBackIsBelieved) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Maps maps(4, seed);
    maps.align_all();
    const AlignedMaps found = checked_by_cycles(4, maps.alignments, kNames);
    EXPECT_THAT(found.rejected, IsEmpty());
    EXPECT_THAT(found.doubtful, IsEmpty());
    for (std::size_t map = 0; map < 4; ++map) {
      EXPECT_LT(maps.turn_off_deg(found, map), 4);
      EXPECT_NEAR(found.S_first_map[map]->scale / maps.S_first_map[map].scale, 1, 0.1);
    }
  }
}

// Each of the six in turn, and the one that most points agree on, too.
TEST(AlignmentGraph, TheOneThatBreaksItsCyclesIsRejectedAndNamed) {
  for (std::size_t wrong = 0; wrong < 6; ++wrong) {
    Maps maps(4, 10 + wrong);
    maps.align_all();
    MapAlignment& of = maps.alignments[wrong];
    of.agreed.S_a_b = Similarity{1.1, turned_by({0, 0.5, 0}), Vec3::Zero()} * of.agreed.S_a_b;
    of.agreed.agree.resize(40);
    const AlignedMaps found = checked_by_cycles(4, maps.alignments, kNames);
    ASSERT_EQ(found.rejected.size(), 1);
    EXPECT_EQ(found.rejected[0].alignment, wrong);
    EXPECT_THAT(found.rejected[0].why,
                HasSubstr("the alignment of the maps of " + kNames[of.a] + " and " + kNames[of.b] +
                          " is rejected: it leads back round 0 of 2 cycles"));
    EXPECT_FALSE(found.is_believed[wrong]);
    for (std::size_t map = 0; map < 4; ++map) {
      EXPECT_LT(maps.turn_off_deg(found, map), 4);
    }
    // The thesis's chain believes it where most points do.
    const AlignedMaps chain = chained(4, maps.alignments, kNames);
    EXPECT_TRUE(chain.is_believed[wrong]);
  }
}

TEST(AlignmentGraph, OfThreeThatContradictOneAnotherTheWeakestIsRejected) {
  Maps maps(3, 20);
  maps.align(0, 1, 30);
  maps.align(1, 2, 12, {1, turned_by({0, 1, 0}), Vec3::Zero()});
  maps.align(0, 2, 20);
  const AlignedMaps found = checked_by_cycles(3, maps.alignments, kNames);
  ASSERT_EQ(found.rejected.size(), 1);
  EXPECT_EQ(found.rejected[0].alignment, 1);
  EXPECT_THAT(found.rejected[0].why, HasSubstr("which of 3 is false the cycles do not tell"));
  EXPECT_THAT(found.rejected[0].why, HasSubstr("it is off by 5"));  // 57 degrees
  EXPECT_THAT(found.doubtful, testing::ElementsAre(0, 2)) << "nothing confirms them any more";
  EXPECT_LT(maps.turn_off_deg(found, 2), 3);
}

TEST(AlignmentGraph, LongerCyclesAreGoneRound) {
  Maps maps(4, 30);
  maps.align(0, 1, 30);
  maps.align(1, 2, 20);
  maps.align(2, 3, 25);
  maps.align(0, 3, 10, {1.5, Eigen::Quaterniond::Identity(), Vec3::Zero()});
  const AlignedMaps found = checked_by_cycles(4, maps.alignments, kNames);
  ASSERT_EQ(found.rejected.size(), 1);
  EXPECT_EQ(found.rejected[0].alignment, 3);
  EXPECT_NEAR(found.S_first_map[3]->scale / maps.S_first_map[3].scale, 1, 0.1);
}

TEST(AlignmentGraph, AMapThatNothingLeadsToStaysOut) {
  Maps maps(4, 40);
  maps.align(0, 1, 30);
  maps.align(2, 3, 30);
  maps.align(1, 2, 0);
  maps.alignments.back().agreed.fault = "too few";
  for (const auto& join : {chained, checked_by_cycles}) {
    const AlignedMaps found = join(4, maps.alignments, kNames);
    EXPECT_TRUE(found.S_first_map[0] && found.S_first_map[1]);
    EXPECT_FALSE(found.S_first_map[2] || found.S_first_map[3]);
    ASSERT_EQ(found.rejected.size(), 1);
    EXPECT_EQ(found.rejected[0].why, "the maps of left and behind are not aligned: too few");
  }
}

// From each the nearest of those that are left.
TEST(AlignmentGraph, TheChainGoesFromNeighbourToNeighbour) {
  Maps maps(4, 50);
  maps.align(0, 1, 10);
  maps.align(0, 2, 30);
  maps.align(0, 3, 20);
  maps.align(1, 2, 9);
  maps.align(2, 3, 12);
  maps.align(1, 3, 11);
  const AlignedMaps found = chained(4, maps.alignments, kNames);
  EXPECT_EQ(found.is_believed, (std::vector<bool>{false, true, false, false, true, true}));
  for (std::size_t map = 0; map < 4; ++map) {
    EXPECT_LT(maps.turn_off_deg(found, map), 6);
  }
}

}  // namespace
}  // namespace panoptes
