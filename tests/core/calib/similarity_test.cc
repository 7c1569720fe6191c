// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/similarity.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

using ::testing::HasSubstr;

constexpr double kRoundoff = 1e-12;

Vec3 drawn(Rng& rng) {
  const double x = rng.normal();
  const double y = rng.normal();
  return {x, y, rng.normal()};
}

Similarity drawn_similarity(Rng& rng) {
  const double scale = std::exp(rng.uniform(-1, 1));
  const Vec3 turn_rad = drawn(rng);
  return {scale, turned_by(turn_rad), 2 * drawn(rng)};
}

double apart(const Similarity& a, const Similarity& b) {
  return a.rotation.angularDistance(b.rotation) + (a.translation - b.translation).norm() +
         std::abs(a.scale - b.scale);
}

/// Points of two maps, so many of which are truly the same.
std::vector<PointPair> drawn_pairs(const Similarity& S_a_b, int count, int false_count,
                                   double sigma, Rng& rng) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < count + false_count; ++i) {
    const Vec3 p_b = 2 * drawn(rng);
    const Vec3 p_a = S_a_b * (i < count ? p_b : Vec3(2 * drawn(rng)));
    const double sigma_b = sigma / S_a_b.scale;
    pairs.push_back({p_a + sigma * drawn(rng), p_b + sigma_b * drawn(rng),
                     sigma * sigma * Mat3::Identity(), sigma_b * sigma_b * Mat3::Identity()});
  }
  return pairs;
}

TEST(Similarity, KeepsItsLaws) {
  Rng rng(1);
  for (int i = 0; i < 50; ++i) {
    const Similarity S_a_b = drawn_similarity(rng);
    const Similarity S_b_c = drawn_similarity(rng);
    const Vec3 p = drawn(rng);
    EXPECT_LT((S_a_b.inverse() * (S_a_b * p) - p).norm(), kRoundoff * 100);
    EXPECT_LT(((S_a_b * S_b_c) * p - S_a_b * (S_b_c * p)).norm(), kRoundoff * 100);
    const Pose3 T{turned_by(drawn(rng)), drawn(rng)};
    // What a camera sees ahead of it stays ahead, farther by the factor.
    EXPECT_LT(((S_a_b * T).inverse() * (S_a_b * (T * p)) - S_a_b.scale * p).norm(),
              kRoundoff * 100);
    EXPECT_LT(apart(S_a_b * S_a_b.inverse(), Similarity()), kRoundoff * 100);
  }
}

TEST(Similarity, AnOffsetLooksInAnotherFrameAsItsAdjointSays) {
  Rng rng(2);
  constexpr double kSmall = 1e-6;
  for (int i = 0; i < 20; ++i) {
    const Similarity S_a_b = drawn_similarity(rng);
    SimilarityOffset in_b;
    for (int k = 0; k < in_b.size(); ++k) {
      in_b[k] = kSmall * rng.normal();
    }
    const Similarity off = S_a_b * moved(Similarity(), in_b) * S_a_b.inverse();
    EXPECT_LT((offset_of(off) - adjoint(S_a_b) * in_b).norm(), 100 * kSmall * kSmall);
  }
}

TEST(Similarity, IsFittedToPointsExactly) {
  Rng rng(3);
  const Similarity S_a_b = drawn_similarity(rng);
  std::vector<Vec3> in_a;
  std::vector<Vec3> in_b;
  for (int i = 0; i < 3; ++i) {
    in_b.push_back(drawn(rng));
    in_a.push_back(S_a_b * in_b.back());
  }
  EXPECT_LT(apart(*fitted_similarity(in_a, in_b), S_a_b), 1e-9);
  // Nor is it mirrored by points that a mirror would fit better.
  const std::vector<Vec3> mirrored{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  const std::vector<Vec3> truly{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  EXPECT_NEAR(fitted_similarity(mirrored, truly)->rotation.toRotationMatrix().determinant(), 1,
              1e-9);
  // A line turns about itself.
  const std::vector<Vec3> line{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}};
  EXPECT_FALSE(fitted_similarity(line, line));
  EXPECT_FALSE(fitted_similarity({{1, 2, 3}, {1, 2, 4}}, {{1, 2, 3}, {1, 2, 4}}));
}

TEST(AgreedSimilarity, IsKnownToWhatItSays) {
  double sum = 0;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    Rng rng(static_cast<std::uint64_t>(100 + run));
    const Similarity S_a_b = drawn_similarity(rng);
    SimilarityOptions options;
    options.shuffles = 0;
    const AgreedSimilarity found =
        agreed_similarity(options, drawn_pairs(S_a_b, 40, 0, 0.02, rng), Rng(9));
    ASSERT_EQ(found.fault, "");
    EXPECT_GE(found.agree.size(), 36);
    const SimilarityOffset off = offset_of(found.S_a_b * S_a_b.inverse());
    sum += off.dot(found.covariance.ldlt().solve(off)) / 7;
  }
  // Three sigmas of the mean of so many chi-squared of 7.
  EXPECT_NEAR(sum / kRuns, 1, 3 * std::sqrt(2.0 / 7 / kRuns) + 0.1);
}

TEST(AgreedSimilarity, IsFoundAmongSixtyPercentOfFalsePairs) {
  for (const std::uint64_t seed : {4, 5, 6}) {
    Rng rng(seed);
    const Similarity S_a_b = drawn_similarity(rng);
    const std::vector<PointPair> pairs = drawn_pairs(S_a_b, 24, 36, 0.03 * S_a_b.scale, rng);
    const AgreedSimilarity found = agreed_similarity({}, pairs, Rng(seed));
    ASSERT_EQ(found.fault, "");
    EXPECT_LT(rad_to_deg(found.S_a_b.rotation.angularDistance(S_a_b.rotation)), 1.5);
    EXPECT_NEAR(found.S_a_b.scale / S_a_b.scale, 1, 0.02);
    EXPECT_GE(found.agree.size(), 22);
    EXPECT_LT(found.agree.back(), 24 + 36);
    std::size_t false_agree = 0;
    for (const std::size_t i : found.agree) {
      false_agree += i >= 24 ? 1 : 0;
    }
    EXPECT_LE(false_agree, 1);
    EXPECT_LT(found.by_chance, 10);

    const AgreedSimilarity again = agreed_similarity({}, pairs, Rng(seed));
    EXPECT_EQ(again.S_a_b.rotation.coeffs(), found.S_a_b.rotation.coeffs());
    EXPECT_EQ(again.agree, found.agree);
    // Another seed draws others, and finds the same.
    const AgreedSimilarity other = agreed_similarity({}, pairs, Rng(seed + 50));
    EXPECT_LT(rad_to_deg(other.S_a_b.rotation.angularDistance(S_a_b.rotation)), 1.5);
  }
}

TEST(AgreedSimilarity, IsNotToldByChance) {
  for (const std::uint64_t seed : {7, 8, 9}) {
    Rng rng(seed);
    const std::vector<PointPair> pairs = drawn_pairs(Similarity(), 0, 150, 0.3, rng);
    const AgreedSimilarity found = agreed_similarity({}, pairs, Rng(seed));
    EXPECT_THAT(found.fault, HasSubstr("of 150 points that look alike in both "));
    EXPECT_THAT(found.fault, HasSubstr("by chance"));
  }
  Rng rng(10);
  EXPECT_THAT(agreed_similarity({}, drawn_pairs(Similarity(), 5, 0, 0.01, rng), Rng(1)).fault,
              HasSubstr("5 points look alike in both, fewer than the 8 that must agree"));
  EXPECT_THAT(agreed_similarity({}, {}, Rng(1)).fault, HasSubstr("0 points look alike"));
}

// All in one place, or on one line, tell no turn.
TEST(AgreedSimilarity, IsNotToldByPointsOfOnePlace) {
  Rng rng(11);
  std::vector<PointPair> pairs = drawn_pairs(Similarity(), 30, 0, 0.05, rng);
  for (PointPair& pair : pairs) {
    pair.in_a = Vec3(1, 2, 3) + 0.05 * drawn(rng);
  }
  EXPECT_NE(agreed_similarity({}, pairs, Rng(1)).fault, "");
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].in_a = pairs[i].in_b = Vec3(0.2 * static_cast<double>(i), 0, 0);
  }
  EXPECT_NE(agreed_similarity({}, pairs, Rng(1)).fault, "");
}

}  // namespace
}  // namespace panoptes
