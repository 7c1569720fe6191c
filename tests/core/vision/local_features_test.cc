// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/local_features.h"

#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/rng.h"

namespace panoptes {
namespace {

// Random blotches of some pixels' width, shifted to the right, with noise.
cv::Mat patchwork(int shift_px, double noise_grey, Rng rng) {
  cv::Mat blotches(60, 80, CV_8U);
  Rng layout(11);
  for (int row = 0; row < blotches.rows; ++row) {
    for (int column = 0; column < blotches.cols; ++column) {
      blotches.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(layout.index(256));
    }
  }
  cv::Mat wide;
  cv::resize(blotches, wide, cv::Size(), 5, 5, cv::INTER_CUBIC);
  cv::Mat picture = wide(cv::Rect(40 - shift_px, 30, 320, 240)).clone();
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      auto& pixel = picture.at<std::uint8_t>(row, column);
      pixel = cv::saturate_cast<std::uint8_t>(pixel + rng.normal(0, noise_grey));
    }
  }
  return picture;
}

TEST(LocalFeatures, FindsAShiftBetweenNoisyPictures) {
  const FeatureOptions options;
  constexpr int kShift_px = 13;
  const LocalFeatures a = local_features(options, patchwork(0, 2, Rng(1)));
  const LocalFeatures b = local_features(options, patchwork(kShift_px, 2, Rng(2)));
  const auto matches = match_features(options, a, b);
  ASSERT_GE(matches.size(), 100U);
  const auto right = std::count_if(matches.begin(), matches.end(), [&](const FeatureMatch& match) {
    const Eigen::Vector2f moved = b.px[match.b] - a.px[match.a];
    constexpr float kCornerNoise_px = 2;  // a pixel on the coarsest level
    return (moved - Eigen::Vector2f(kShift_px, 0)).norm() < kCornerNoise_px;
  });
  EXPECT_GE(static_cast<double>(right), 0.95 * static_cast<double>(matches.size()));
}

TEST(LocalFeatures, MatchesAPictureWithItselfEntirely) {
  const FeatureOptions options;
  const LocalFeatures a = local_features(options, patchwork(0, 2, Rng(1)));
  for (const FeatureMatch& match : match_features(options, a, a)) {
    EXPECT_EQ(match.a, match.b);
  }
}

// A picture that is turned round shows everything where it was, seen from its middle. Pixels of the
// pyramid's levels that were counted from the corner would lie up to 0.4 px too far to one side.
TEST(LocalFeatures, LieWhereThePictureShowsThemOnEveryLevel) {
  const FeatureOptions options;
  const cv::Mat picture = patchwork(0, 2, Rng(1));
  cv::Mat turned;
  cv::rotate(picture, turned, cv::ROTATE_180);
  const LocalFeatures a = local_features(options, picture);
  const LocalFeatures b = local_features(options, turned);
  Eigen::Vector2f sum(0, 0);
  int found = 0;
  for (const Eigen::Vector2f& px : a.px) {
    constexpr float kSame_px = 2;
    for (const Eigen::Vector2f& other : b.px) {
      const Eigen::Vector2f apart = Eigen::Vector2f(319, 239) - other - px;
      if (apart.norm() < kSame_px) {
        sum += apart;
        ++found;
      }
    }
  }
  ASSERT_GE(found, 100);
  constexpr float kMean_px = 0.05F;  // a tenth of a sigma of 0.5 px each
  EXPECT_LT(sum.norm() / static_cast<float>(found), kMean_px);
}

TEST(LocalFeatures, SpreadsOverThePicture) {
  FeatureOptions options;
  // half the picture is ten times weaker in contrast
  cv::Mat picture = patchwork(0, 0, Rng(1));
  picture.colRange(0, 160).convertTo(picture.colRange(0, 160), CV_8U, 0.2, 60);
  const LocalFeatures features = local_features(options, picture);
  const auto weak = std::count_if(features.px.begin(), features.px.end(),
                                  [](const Eigen::Vector2f& px) { return px.x() < 160; });
  EXPECT_GE(static_cast<double>(weak), 0.3 * static_cast<double>(features.px.size()));
  EXPECT_LE(static_cast<int>(features.px.size()), options.max_count);
}

TEST(LocalFeatures, GivesTheSameBitsAgainAndForColour) {
  const cv::Mat grey = patchwork(0, 2, Rng(1));
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  const LocalFeatures a = local_features({}, grey);
  const LocalFeatures b = local_features({}, colour);
  ASSERT_EQ(a.px, b.px);
  EXPECT_EQ(cv::countNonZero(a.descriptors != b.descriptors), 0);
}

TEST(LocalFeatures, FindsNothingOnAPlainWall) {
  const LocalFeatures none = local_features({}, cv::Mat(240, 320, CV_8U, cv::Scalar(128)));
  EXPECT_TRUE(none.px.empty());
  const LocalFeatures some = local_features({}, patchwork(0, 2, Rng(1)));
  EXPECT_TRUE(match_features({}, none, some).empty());
  EXPECT_TRUE(match_features({}, some, none).empty());
}

// A camera that looks up shows a picture that turns when the body does.
TEST(LocalFeatures, FindsAgainWhatHasTurnedAboutTheAxis) {
  const FeatureOptions options{.levels = 1};
  const cv::Mat before = patchwork(0, 1, Rng(1))(cv::Rect(40, 0, 240, 240)).clone();
  const cv::Point2f middle(119.5F, 119.5F);
  cv::Mat now;
  const cv::Mat turn = cv::getRotationMatrix2D(middle, 50, 1);
  cv::warpAffine(before, now, turn, before.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  const auto right = [&](DescriptorPose pose) {
    const LocalFeatures a = local_features(options, before, pose);
    const LocalFeatures b = local_features(options, now, pose);
    int count = 0;
    for (const FeatureMatch& match : match_features(options, a, b)) {
      const Eigen::Vector2d p = a.px[match.a].cast<double>();
      const Eigen::Vector2d there(
          turn.at<double>(0, 0) * p.x() + turn.at<double>(0, 1) * p.y() + turn.at<double>(0, 2),
          turn.at<double>(1, 0) * p.x() + turn.at<double>(1, 1) * p.y() + turn.at<double>(1, 2));
      count += (there - b.px[match.b].cast<double>()).norm() < 3 ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(right(DescriptorPose::kTurned), 40);
  EXPECT_LT(right(DescriptorPose::kUpright), 10);
}

}  // namespace
}  // namespace panoptes
