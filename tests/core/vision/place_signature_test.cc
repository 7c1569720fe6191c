// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_signature.h"

#include <cstdint>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_grey = 1e-3;  // 256 sums of floats of up to one

cv::Mat noise_picture(Rng rng, int low, int high) {
  cv::Mat picture(240, 320, CV_8U);
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      picture.at<std::uint8_t>(row, column) =
          static_cast<std::uint8_t>(low + rng.index(high - low));
    }
  }
  return picture;
}

TEST(PlaceSignature, IsTheSameWhenFrontAndBackChangePlaces) {
  const SignatureOptions options;
  const cv::Mat a = noise_picture(Rng(1), 0, 200);
  const cv::Mat b = noise_picture(Rng(2), 50, 255);
  EXPECT_EQ(emd_grey(place_signature(options, a, b), place_signature(options, b, a)), 0);
}

TEST(PlaceSignature, DistanceIsTheShiftOfGreyLevels) {
  SignatureOptions options;
  options.subtract_mean = false;
  const cv::Mat dark = noise_picture(Rng(3), 20, 120);
  const cv::Mat light = dark + 30;
  const PlaceSignature a = place_signature(options, dark, dark);
  const PlaceSignature b = place_signature(options, light, light);
  EXPECT_NEAR(emd_grey(a, b), 30, kRoundoff_grey);
  EXPECT_EQ(emd_grey(a, b), emd_grey(b, a));
  EXPECT_EQ(emd_grey(a, a), 0);
}

TEST(PlaceSignature, WithoutItsMeanBrightnessCostsNothing) {
  const cv::Mat dark = noise_picture(Rng(3), 20, 120);
  const cv::Mat light = dark + 30;
  EXPECT_NEAR(emd_grey(place_signature({}, dark, dark), place_signature({}, light, light)), 0,
              kRoundoff_grey);
}

TEST(PlaceSignature, KeepsTheTriangleInequality) {
  const PlaceSignature a =
      place_signature({}, noise_picture(Rng(1), 0, 90), noise_picture(Rng(2), 0, 255));
  const PlaceSignature b =
      place_signature({}, noise_picture(Rng(3), 30, 200), noise_picture(Rng(4), 9, 99));
  const PlaceSignature c =
      place_signature({}, noise_picture(Rng(5), 100, 250), noise_picture(Rng(6), 0, 40));
  EXPECT_LE(emd_grey(a, c), emd_grey(a, b) + emd_grey(b, c) + kRoundoff_grey);
}

}  // namespace
}  // namespace panoptes
