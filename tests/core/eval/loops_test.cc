// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/loops.h"

#include <numbers>

#include <gmock/gmock.h>

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-9;
constexpr double kPi = std::numbers::pi;

/// 10 m out along x in 0.5 m keyframes (0..20), a loop aside (21..26), and the first 10 m again,
/// in the same direction (27..47), 0.1 m to the side.
std::vector<Pose2> there_and_again() {
  std::vector<Pose2> poses;
  for (int i = 0; i <= 20; ++i) {
    poses.push_back({0.5 * i, 0, 0});
  }
  for (const Pose2& aside : {Pose2{10, 2, kPi / 2}, Pose2{8, 4, kPi}, Pose2{4, 4, kPi},
                             Pose2{-2, 4, kPi}, Pose2{-2, 2, -kPi / 2}, Pose2{-2, 0.1, 0}}) {
    poses.push_back(aside);
  }
  for (int i = 0; i <= 20; ++i) {
    poses.push_back({0.5 * i, 0.1, 0});
  }
  return poses;
}

ClosureReport closure(int recent, int earlier, const Pose2& claim,
                      Heading heading = Heading::kSame) {
  ClosureReport report;
  report.recent = recent;
  report.earlier = earlier;
  report.heading = heading;
  report.T_earlier_recent = claim;
  report.information = Vec3(1e4, 1e4, 1e4).asDiagonal();
  report.accepted = true;
  return report;
}

TEST(Revisits, AreOneForAStretchDrivenAgain) {
  const auto truth = there_and_again();
  const auto found = revisits(truth, path_lengths_m(truth));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].heading, Heading::kSame);
  EXPECT_EQ(found[0].first, 30);  // at 1.5 m: keyframes 0 to 2 have not three before them
  EXPECT_EQ(found[0].last, 44);   // the last with three after it
}

TEST(Revisits, KnowTheWayBack) {
  std::vector<Pose2> truth;
  for (int i = 0; i <= 20; ++i) {
    truth.push_back({0.5 * i, 0, 0});
  }
  for (int i = 20; i >= 0; --i) {
    truth.push_back({0.5 * i, 0, kPi});
  }
  const auto found = revisits(truth, path_lengths_m(truth));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].heading, Heading::kOpposite);
  // 5 m of path between: back at 7.5 m and less, 8 m being near enough; three keyframes follow
  EXPECT_EQ(found[0].first, 26);
  EXPECT_EQ(found[0].last, 38);
}

TEST(Revisits, SplitWhereAMetreOrMoreLiesBetween) {
  auto truth = there_and_again();
  for (int i = 35; i <= 38; ++i) {
    truth[static_cast<std::size_t>(i)].y_m = 1.2;  // around something for 1.5 m
  }
  EXPECT_EQ(revisits(truth, path_lengths_m(truth)).size(), 2U);
}

TEST(Revisits, NeedTheSameWayOfLooking) {
  auto truth = there_and_again();
  for (std::size_t i = 27; i < truth.size(); ++i) {
    truth[i].theta_rad = kPi / 2;
  }
  EXPECT_TRUE(revisits(truth, path_lengths_m(truth)).empty());
}

TEST(Correct, MeansNearAndTurnedAsClaimed) {
  const std::vector<Pose2> truth = {{0, 0, 0}, {0.3, 0.4, deg_to_rad(30)}};
  EXPECT_TRUE(is_correct(closure(1, 0, {0, 0, deg_to_rad(30)}), truth));
  EXPECT_TRUE(is_correct(closure(1, 0, {0, 0, deg_to_rad(11)}), truth));
  EXPECT_FALSE(is_correct(closure(1, 0, {0, 0, deg_to_rad(9)}), truth));
  EXPECT_FALSE(is_correct(closure(1, 0, {0, 0, deg_to_rad(-150)}), truth));
  const std::vector<Pose2> away = {{0, 0, 0}, {0.3, 0.41, 0}};
  EXPECT_FALSE(is_correct(closure(1, 0, {0.3, 0.41, 0}), away));
}

TEST(LoopFigures, CountRightOnesOnceARevisitAndWrongOnesEach) {
  const auto truth = there_and_again();
  std::vector<ClosureReport> closures = {
      closure(30, 3, {0, 0.1, 0}),   // at 1.5 m, right
      closure(40, 13, {0, 0.1, 0}),  // the same revisit, 5 m on
      closure(35, 3, {0, 0, 0}),     // wrong
      closure(36, 4, {0, 0, 0}),     // wrong again
  };
  closures.push_back(closure(33, 6, {0, 0.1, 0}));
  closures.back().accepted = false;
  const LoopFigures figures = loop_figures(closures, truth, path_lengths_m(truth));
  EXPECT_EQ(figures.accepted, 3);
  EXPECT_EQ(figures.same_heading, 3);
  EXPECT_EQ(figures.opposite_heading, 0);
  EXPECT_EQ(figures.against_truth.correct, 1);
  EXPECT_EQ(figures.against_truth.wrong, 2);
  EXPECT_EQ(figures.against_truth.revisits_same, 1);
  EXPECT_EQ(figures.against_truth.recalled_same, 1);
  EXPECT_EQ(figures.against_truth.revisits_opposite, 0);
}

TEST(LoopFigures, MeasureOnlyWhatAClosureClaims) {
  const auto truth = there_and_again();
  std::vector<ClosureReport> closures = {
      closure(30, 3, {0.03, 0.14, deg_to_rad(1)}),  // 5 cm, 1 degree
      closure(31, 4, {0, 0.1, deg_to_rad(3)}),      // heading claimed alone
  };
  closures[1].information.topLeftCorner<2, 2>() = Mat2::Identity();  // known to 1 m
  const auto error = loop_figures(closures, truth, path_lengths_m(truth)).against_truth.error_same;
  EXPECT_EQ(error.translations, 1);
  EXPECT_EQ(error.rotations, 2);
  EXPECT_NEAR(error.median_m, 0.05, kRoundoff);
  EXPECT_NEAR(error.median_deg, 2, kRoundoff);
  EXPECT_NEAR(error.p95_deg, 2.9, kRoundoff);
}

TEST(LoopFigures, WithoutTruthCountByGaps) {
  const std::vector<double> path_m = {0, 0.5, 1.0, 1.5, 2.0, 2.5};
  const auto figures = loop_figures({closure(1, 0, {}), closure(2, 0, {}), closure(5, 0, {}),
                                     closure(5, 0, {}, Heading::kOpposite)},
                                    {}, path_m);
  EXPECT_EQ(figures.same_heading, 2);
  EXPECT_EQ(figures.opposite_heading, 1);
  EXPECT_EQ(figures.accepted, 3);
}

}  // namespace
}  // namespace panoptes
