// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/lens_fit.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/camera/lens_parameters.h"
#include "tests/support/board_pictures.h"

namespace panoptes {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kRoundoff_px = 1e-6;
constexpr double kNoise_px = 0.1;
constexpr double kSharp_px = 0.015;  // as corners are found
constexpr int kPictures = 30;

const Board kBoard;

Intrinsics wide() {
  Intrinsics lens =
      lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.28, 0.08, 0.0008, -0.0006, 0.01});
  lens.fy_px *= 1.003;
  lens.cx_px += 6;
  lens.cy_px -= 9;
  return lens;
}

Intrinsics fisheye() {
  Intrinsics lens =
      lens_of_view(640, 480, deg_to_rad(185), Equidistant{-0.012, 0.003, -0.0006, 0.0001});
  lens.cx_px += 4;
  lens.cy_px -= 5;
  return lens;
}

LensFit fit(const Intrinsics& lens, const std::vector<BoardCorners>& views) {
  return fit_best_lens({}, kBoard, views, lens.width_px, lens.height_px);
}

/// As many as it takes for a good lens.
std::vector<Pose3> enough_poses(const Intrinsics& lens, Rng& rng) {
  std::vector<Pose3> poses = board_poses(kBoard, lens, {}, kPictures, rng);
  const std::vector<Pose3> more = board_poses_in_corners(kBoard, lens, kPictures, rng);
  poses.insert(poses.end(), more.begin(), more.end());
  return poses;
}

TEST(LensFit, ExactCornersGiveTheLens) {
  for (const Intrinsics& lens : {wide(), fisheye()}) {
    Rng rng(1);
    const auto views =
        seen_corners(kBoard, lens, board_poses(kBoard, lens, {}, kPictures, rng), 0, rng);
    const LensFit found = fit(lens, views);
    EXPECT_EQ(found.verdict, Verdict::kGood) << testing::PrintToString(found.reasons);
    EXPECT_EQ(found.used(), kPictures);
    EXPECT_EQ(found.lens.distortion.index(), lens.distortion.index());
    EXPECT_LT(found.reprojection_rms_px, kRoundoff_px);
    EXPECT_LT(field_difference(lens, found.lens).most_px, 1e-3);
    EXPECT_NEAR(found.lens.fx_px, lens.fx_px, 1e-4 * lens.fx_px);
  }
}

TEST(LensFit, NoisyCornersGiveItAndHowWellItIsKnown) {
  for (const Intrinsics& lens : {wide(), fisheye()}) {
    double normalised = 0;
    constexpr int kSets = 12;
    for (int set = 0; set < kSets; ++set) {
      Rng rng(10 + set);
      const auto views =
          seen_corners(kBoard, lens, board_poses(kBoard, lens, {}, kPictures, rng), kNoise_px, rng);
      const LensFit found = fit(lens, views);
      ASSERT_NE(found.verdict, Verdict::kFailed) << testing::PrintToString(found.reasons);
      EXPECT_NEAR(found.noise_px, kNoise_px, 0.1 * kNoise_px);
      ASSERT_EQ(found.lens.distortion.index(), lens.distortion.index());
      const Eigen::VectorXd off = lens_parameters(found.lens) - lens_parameters(lens);
      normalised += off.dot(found.covariance.ldlt().solve(off)) / static_cast<double>(off.size());
      // four standard deviations each way, in two directions
      EXPECT_LT(field_difference(lens, found.lens).most_px,
                4 * std::sqrt(2.0) * found.field_sigma_most_px);
    }
    // chi-squared of 12 times 8 or 9 numbers: three sigma either way
    EXPECT_GT(normalised / kSets, 1 - 3 * std::sqrt(2.0 / (8 * kSets)));
    EXPECT_LT(normalised / kSets, 1 + 3 * std::sqrt(2.0 / (8 * kSets)));
  }
}

TEST(LensFit, AnotherBoardsPictureIsLeftOut) {
  const Intrinsics lens = wide();
  Rng rng(2);
  auto views =
      seen_corners(kBoard, lens, board_poses(kBoard, lens, {}, kPictures, rng), kNoise_px, rng);
  for (Vec2& px : views[7]) {
    px.x() += 30 * std::sin(0.02 * px.y());
  }
  const LensFit found = fit(lens, views);
  EXPECT_FALSE(found.views[7].used);
  EXPECT_EQ(found.used(), kPictures - 1);
  EXPECT_NEAR(found.noise_px, kNoise_px, 0.1 * kNoise_px);
}

TEST(LensFit, TooFewBoardsAreRefused) {
  const Intrinsics lens = wide();
  Rng rng(3);
  const auto views =
      seen_corners(kBoard, lens, board_poses(kBoard, lens, {}, 4, rng), kNoise_px, rng);
  const LensFit found = fit(lens, views);
  EXPECT_EQ(found.verdict, Verdict::kFailed);
  EXPECT_THAT(found.reasons, Contains(HasSubstr("4 pictures show a whole board: at least 5")));
  EXPECT_THAT(found.reasons, Contains(HasSubstr("a board of 10 x 7 squares has 9 x 6")));
  EXPECT_EQ(fit(lens, {}).verdict, Verdict::kFailed);
}

TEST(LensFit, BoardsThatAllFaceTheCameraAlikeAreRefused) {
  const Intrinsics lens = wide();
  Rng rng(4);
  std::vector<Pose3> poses;
  for (int i = 0; i < kPictures; ++i) {
    poses.push_back({Eigen::Quaterniond::Identity(),
                     Vec3(rng.uniform(-0.3, 0.1), rng.uniform(-0.2, 0.05), 0.5)});
  }
  const LensFit found = fit(lens, seen_corners(kBoard, lens, poses, kNoise_px, rng));
  EXPECT_EQ(found.verdict, Verdict::kFailed);
  EXPECT_THAT(found.reasons, Contains(HasSubstr("slant")));
}

TEST(LensFit, BoardsInOnePartOfThePictureAreRefused) {
  const Intrinsics lens = wide();
  Rng rng(5);
  BoardPoses left;
  left.most_width = 0.4;
  left.to = Vec2(0.3, 1);
  const LensFit found = fit(
      lens,
      seen_corners(kBoard, lens, board_poses(kBoard, lens, left, kPictures, rng), kNoise_px, rng));
  EXPECT_EQ(found.verdict, Verdict::kFailed);
  EXPECT_THAT(found.reasons, Contains(HasSubstr("right half of the picture")));
}

TEST(LensFit, BoardsFarFromTheCornersAreTooFewUntilThereAreSomeInThem) {
  const Intrinsics lens = wide();
  Rng rng(7);
  BoardPoses middle;
  middle.from = Vec2(0.3, 0.3);
  middle.to = Vec2(0.7, 0.7);
  auto views =
      seen_corners(kBoard, lens, board_poses(kBoard, lens, middle, kPictures, rng), kSharp_px, rng);
  const LensFit poor = fit(lens, views);
  EXPECT_EQ(poor.verdict, Verdict::kPoor);
  EXPECT_THAT(poor.reasons, Contains(HasSubstr("more boards near its edges and corners")));
  const auto more = seen_corners(kBoard, lens, board_poses_in_corners(kBoard, lens, kPictures, rng),
                                 kSharp_px, rng);
  views.insert(views.end(), more.begin(), more.end());
  const LensFit good = fit(lens, views);
  EXPECT_EQ(good.verdict, Verdict::kGood) << testing::PrintToString(good.reasons);
  EXPECT_LT(field_difference(lens, good.lens).rms_px, 0.1);
}

TEST(LensFit, AnImperfectBoardIsFoundWithTheLens) {
  constexpr BoardShape kStretched{0.005, 0, 0, 0, 0};
  constexpr BoardShape kBowed{0, 0, 0.0005, -0.0002, 0.0001};
  constexpr BoardShape kBoth{-0.003, 0.001, -0.0003, 0.0004, 0};
  for (const Intrinsics& lens : {wide(), fisheye()}) {
    for (const BoardShape& shape : {kStretched, kBowed, kBoth}) {
      Rng rng(8);
      const LensFit found = fit(lens, seen_corners(corners_board(kBoard, shape), lens,
                                                   enough_poses(lens, rng), kSharp_px, rng));
      EXPECT_EQ(found.verdict, Verdict::kGood) << testing::PrintToString(found.reasons);
      EXPECT_NEAR(found.noise_px, kSharp_px, 0.1 * kSharp_px);
      const ShapeNumbers off = shape_numbers(found.shape) - shape_numbers(shape);
      constexpr double kFourSigma = 4;
      EXPECT_LT(off.cwiseQuotient(shape_numbers(found.shape_sigma)).cwiseAbs().maxCoeff(),
                kFourSigma);
      EXPECT_LT(100 * found.shape_sigma.stretch, 0.01);
      EXPECT_LT(found.shape_sigma.bow_rows_m, 1e-5);
      const LensFitOptions asked;
      EXPECT_NEAR(found.lens.fx_px, lens.fx_px, asked.focal_sigma_ratio * lens.fx_px);
      EXPECT_NEAR(found.lens.fy_px, lens.fy_px, asked.focal_sigma_ratio * lens.fy_px);
      EXPECT_NEAR(found.lens.cx_px, lens.cx_px, asked.centre_sigma_px);
      EXPECT_NEAR(found.lens.cy_px, lens.cy_px, asked.centre_sigma_px);
    }
  }
}

TEST(LensFit, UprightBoardsDoNotTellAStretchedOneFromALens) {
  const Intrinsics lens = wide();
  const auto corners = corners_board(kBoard, {0.005, 0, 0, 0, 0});
  const auto held = [&](double most_roll_rad) {
    Rng rng(9);
    BoardPoses poses;
    poses.most_roll_rad = most_roll_rad;
    poses.most_slant_rad = 0.5;
    return fit(lens, seen_corners(corners, lens, board_poses(kBoard, lens, poses, kPictures, rng),
                                  kNoise_px, rng));
  };
  const auto ratio_sigma = [](const LensFit& found) {
    const Eigen::Vector2d by(1 / found.lens.fx_px, -1 / found.lens.fy_px);
    return std::sqrt(by.dot(found.covariance.topLeftCorner<2, 2>() * by));
  };
  const LensFit upright = held(0);
  EXPECT_EQ(upright.verdict, Verdict::kPoor);
  EXPECT_GT(ratio_sigma(upright), 0.001);
  EXPECT_THAT(upright.reasons, Contains(HasSubstr("turn it by a quarter turn")));
  const LensFit turned = held(deg_to_rad(90));
  EXPECT_LT(ratio_sigma(turned), 0.3 * ratio_sigma(upright));
  EXPECT_THAT(turned.reasons, Each(Not(HasSubstr("quarter turn"))));
}

TEST(LensFit, ABoardThatIsNotSmoothGivesNoGoodLens) {
  const Intrinsics lens = wide();
  const auto dented = [](Vec3 p) {
    constexpr double kDeep_m = 0.001;
    constexpr double kWide_m = 0.03;
    p.z() += kDeep_m *
             std::exp(-(p.head<2>() - Vec2(0.06, 0.05)).squaredNorm() / (2 * kWide_m * kWide_m));
    return p;
  };
  const auto printed_in_waves = [](Vec3 p) {
    p.x() += 0.0001 * std::sin(60 * p.x());
    return p;
  };
  for (const std::function<Vec3(Vec3)>& off :
       {std::function<Vec3(Vec3)>(dented), std::function<Vec3(Vec3)>(printed_in_waves)}) {
    Rng rng(10);
    std::vector<Vec3> corners = corners_board(kBoard, {});
    std::transform(corners.begin(), corners.end(), corners.begin(), off);
    const LensFit found =
        fit(lens, seen_corners(corners, lens, enough_poses(lens, rng), kSharp_px, rng));
    EXPECT_NE(found.verdict, Verdict::kGood);
    EXPECT_THAT(found.reasons, Contains(HasSubstr("off a smooth one")));
    const Eigen::VectorXd wrong = lens_parameters(found.lens) - lens_parameters(lens);
    constexpr double kThreeSigma = 9;
    EXPECT_LT(wrong.dot(found.covariance.ldlt().solve(wrong)) / static_cast<double>(wrong.size()),
              kThreeSigma);
  }
}

TEST(LensFit, CornersPrintedAtRandomCountInTheSigmas) {
  const Intrinsics lens = wide();
  constexpr double kSpread_m = 0.00003;
  constexpr int kSets = 12;
  double normalised = 0;
  for (int set = 0; set < kSets; ++set) {
    Rng rng(40 + set);
    std::vector<Vec3> corners = corners_board(kBoard, {});
    for (Vec3& p : corners) {
      p += kSpread_m * Vec3(rng.normal(), rng.normal(), rng.normal());
    }
    const LensFit found = fit(
        lens,
        seen_corners(corners, lens, board_poses(kBoard, lens, {}, kPictures, rng), kSharp_px, rng));
    constexpr double kFifth = 0.2;  // of 54 corners' spread
    EXPECT_NEAR(found.corner_spread_m, kSpread_m, kFifth * kSpread_m);
    const Eigen::VectorXd off = lens_parameters(found.lens) - lens_parameters(lens);
    normalised += off.dot(found.covariance.ldlt().solve(off)) / static_cast<double>(off.size());
  }
  // chi-squared of 12 times 9 numbers: three sigma either way
  EXPECT_NEAR(normalised / kSets, 1, 3 * std::sqrt(2.0 / (9 * kSets)));
}

TEST(LensFit, CopiesOfAPictureCountOnce) {
  const Intrinsics lens = wide();
  Rng rng(11);
  auto views =
      seen_corners(kBoard, lens, board_poses(kBoard, lens, {}, kPictures, rng), kNoise_px, rng);
  const LensFit once = fit(lens, views);
  views.insert(views.begin() + 5, views[3]);
  views.push_back(views[3]);
  const LensFit thrice = fit(lens, views);
  EXPECT_EQ(thrice.copies(), 2);
  EXPECT_EQ(thrice.used(), kPictures);
  EXPECT_TRUE(thrice.views[5].copy);
  EXPECT_FALSE(thrice.views[5].used);
  EXPECT_TRUE(thrice.views[6].used);
  EXPECT_EQ(lens_parameters(thrice.lens), lens_parameters(once.lens));
  EXPECT_EQ(thrice.covariance, once.covariance);
}

TEST(LensFit, WithoutALensNoNumberOfItIsTold) {
  const Intrinsics lens = wide();
  Rng rng(12);
  BoardPoses flat;
  flat.most_slant_rad = 0.02;
  flat.most_width = 0.3;
  const LensFit found = fit(
      lens, seen_corners(kBoard, lens, board_poses(kBoard, lens, flat, 6, rng), kNoise_px, rng));
  EXPECT_EQ(found.verdict, Verdict::kFailed);
  EXPECT_THAT(found.reasons, Each(Not(HasSubstr("known to"))));
}

TEST(LensFit, CornersOfNoBoardAreRefused) {
  Rng rng(6);
  std::vector<BoardCorners> views(kPictures);
  for (BoardCorners& corners : views) {
    for (int i = 0; i < kBoard.corners(); ++i) {
      corners.emplace_back(rng.uniform(0, 640), rng.uniform(0, 480));
    }
  }
  const LensFit found = fit_best_lens({}, kBoard, views, 640, 480);
  EXPECT_EQ(found.verdict, Verdict::kFailed);
  EXPECT_TRUE(found.used() == 0 || found.lens.fx_px > 0) << "what is drawn has a lens";
}

TEST(LensFit, WhereALensDrawsNothingNoCornersAreMissed) {
  const std::vector<BoardCorners> views{{Vec2(10, 10), Vec2(300, 200)}};
  EXPECT_DOUBLE_EQ(picture_use(views, 640, 480, {}), 2.0 / 48);
  std::vector<bool> lit(48, false);
  lit[0] = true;
  EXPECT_DOUBLE_EQ(picture_use(views, 640, 480, lit), 1);
}

TEST(LensFit, ATurnIsNoDifferenceOfLenses) {
  const Intrinsics lens = wide();
  Intrinsics other = lens;
  EXPECT_LT(field_difference(lens, other).most_px, kRoundoff_px);
  other.cx_px += 1;  // nearly a turn
  EXPECT_LT(field_difference(lens, other).rms_px, 0.5);
  other = lens;
  other.fx_px *= 1.01;
  other.fy_px *= 1.01;
  EXPECT_GT(field_difference(lens, other).most_px, 2);
}

}  // namespace
}  // namespace panoptes
