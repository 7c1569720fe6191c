// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/places.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kPi = std::numbers::pi;

/// Along x, back the same way, and along it again, a keyframe every 0.5 m: 0..20, 21..41, 42..62.
std::vector<Pose2> to_and_fro() {
  std::vector<Pose2> poses;
  for (const int lap : {0, 1, 2}) {
    for (int i = 0; i <= 20; ++i) {
      poses.push_back({0.5 * (lap == 1 ? 20 - i : i), 0, lap == 1 ? kPi : 0});
    }
  }
  return poses;
}

/// How far apart two keyframes are, as if pictures told it, whichever way the robot looks.
DistanceTable ideal(const std::vector<Pose2>& poses) {
  return DistanceTable(static_cast<int>(poses.size()), [&](int i, int j) {
    return (poses[static_cast<std::size_t>(i)].position() -
            poses[static_cast<std::size_t>(j)].position())
        .norm();
  });
}

TEST(PlaceCandidates, OfPerfectPicturesAreTheTruth) {
  const std::vector<Pose2> truth = to_and_fro();
  const std::vector<double> path_m = path_lengths_m(truth);
  const auto candidates = place_candidates(ideal(truth), true, path_m);
  const PlaceRecall recall = recall_at_full_precision(candidates, truth, path_m);
  EXPECT_EQ(recall.revisits_opposite, 2);
  EXPECT_EQ(recall.revisits_same, 1);
  EXPECT_EQ(recall.recalled_opposite, 1);  // on the way back; again along, both headings are as
  EXPECT_EQ(recall.recalled_same, 1);      // near, and the one candidate is of the older
  EXPECT_GT(recall.keyframes, 20);
  EXPECT_EQ(recall.recognised, recall.keyframes);
}

TEST(PlaceCandidates, OfPicturesThatLookOneWayNeverGoTheOther) {
  const std::vector<Pose2> truth = to_and_fro();
  const std::vector<double> path_m = path_lengths_m(truth);
  // a picture of the way back shows nothing of the way there
  const DistanceTable one_way(static_cast<int>(truth.size()), [&](int i, int j) {
    const Pose2& a = truth[static_cast<std::size_t>(i)];
    const Pose2& b = truth[static_cast<std::size_t>(j)];
    return (a.position() - b.position()).norm() + (a.theta_rad == b.theta_rad ? 0 : 100);
  });
  const auto candidates = place_candidates(one_way, false, path_m);
  for (const DiagonalCandidate& candidate : candidates) {
    EXPECT_EQ(candidate.heading, Heading::kSame);
  }
  const PlaceRecall recall = recall_at_full_precision(candidates, truth, path_m);
  EXPECT_EQ(recall.recalled_same, 1);
  EXPECT_EQ(recall.recalled_opposite, 0);
}

TEST(DiagonalCandidates, WithNothingAroundAreTheNearestOfThoseAllowed) {
  constexpr int kCount = 6;
  const DistanceTable distances(kCount, [](int i, int j) { return 10 * (i - j) + j; });
  const std::vector<int> until{-1, 0, 1, 1, 2, 4};
  std::vector<int> earlier(kCount, -1);
  for (const DiagonalCandidate& found : diagonal_candidates(distances, 0, true, until)) {
    EXPECT_EQ(found.distance, distances(found.recent, found.earlier));
    EXPECT_EQ(found.heading, Heading::kSame);
    earlier[static_cast<std::size_t>(found.recent)] = found.earlier;
  }
  EXPECT_EQ(earlier, (std::vector<int>{-1, -1, 0, 0, 1, 3}));
}

TEST(PlaceRecall, EndsAtTheClosestWrongOne) {
  const std::vector<Pose2> truth = to_and_fro();
  const std::vector<double> path_m = path_lengths_m(truth);
  const DiagonalCandidate near{45, 3, Heading::kSame, 1};
  const DiagonalCandidate far{50, 8, Heading::kSame, 3};
  DiagonalCandidate wrong{52, 4, Heading::kSame, 2};
  EXPECT_EQ(recall_at_full_precision({near, wrong, far}, truth, path_m).recognised, 1);
  wrong.distance = 4;
  EXPECT_EQ(recall_at_full_precision({near, wrong, far}, truth, path_m).recognised, 2);
  wrong.distance = 1;  // a tie cannot be told apart
  EXPECT_EQ(recall_at_full_precision({near, wrong, far}, truth, path_m).recognised, 0);
  DiagonalCandidate turned = near;  // the right place, the wrong way round
  turned.heading = Heading::kOpposite;
  turned.distance = 0;
  EXPECT_EQ(recall_at_full_precision({turned, near, far}, truth, path_m).recognised, 0);
}

TEST(PlaceRecall, OfADriveTooShortToComeBackIsOfNothing) {
  const std::vector<Pose2> truth{{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}};
  const std::vector<double> path_m = path_lengths_m(truth);
  const auto candidates = place_candidates(ideal(truth), true, path_m);
  EXPECT_TRUE(candidates.empty());
  EXPECT_EQ(recall_at_full_precision(candidates, truth, path_m).keyframes, 0);
}

}  // namespace
}  // namespace panoptes
