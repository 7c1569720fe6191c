// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_signature.h"

#include <cstdint>
#include <numbers>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/rng.h"

namespace panoptes {
namespace {

const Facing kOpposite{std::numbers::pi, {{0, 1}, {1, 0}}};

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

SignatureOptions options_of(SignatureMethod method) {
  SignatureOptions options;
  options.method = method;
  return options;
}

class PlaceSignatureOf : public ::testing::TestWithParam<SignatureMethod> {
 protected:
  SignatureOptions options_ = options_of(GetParam());
};

TEST_P(PlaceSignatureOf, IsTheSameTheOtherWayRoundWhenFrontAndBackChangePlaces) {
  const cv::Mat a = noise_picture(Rng(1), 0, 200);
  const cv::Mat b = noise_picture(Rng(2), 50, 255);
  EXPECT_EQ(
      emd_grey(place_signature(options_, {a, b}), place_signature(options_, {b, a}), kOpposite), 0);
}

TEST_P(PlaceSignatureOf, DistanceIsTheShiftOfGreyLevels) {
  options_.subtract_mean = false;
  const cv::Mat dark = noise_picture(Rng(3), 20, 120);
  const cv::Mat light = dark + 30;
  const PlaceSignature a = place_signature(options_, {dark, dark});
  const PlaceSignature b = place_signature(options_, {light, light});
  EXPECT_NEAR(emd_grey(a, b), 30, kRoundoff_grey);
  EXPECT_NEAR(emd_grey(a, b, kOpposite), 30, kRoundoff_grey);
  EXPECT_EQ(emd_grey(a, b), emd_grey(b, a));
  EXPECT_EQ(emd_grey(a, a), 0);
}

TEST_P(PlaceSignatureOf, WithoutItsMeanBrightnessCostsNothing) {
  const cv::Mat dark = noise_picture(Rng(3), 20, 120);
  const cv::Mat light = dark + 30;
  EXPECT_NEAR(
      emd_grey(place_signature(options_, {dark, dark}), place_signature(options_, {light, light})),
      0, kRoundoff_grey);
}

TEST_P(PlaceSignatureOf, KeepsTheTriangleInequality) {
  const PlaceSignature a =
      place_signature(options_, {noise_picture(Rng(1), 0, 90), noise_picture(Rng(2), 0, 255)});
  const PlaceSignature b =
      place_signature(options_, {noise_picture(Rng(3), 30, 200), noise_picture(Rng(4), 9, 99)});
  const PlaceSignature c =
      place_signature(options_, {noise_picture(Rng(5), 100, 250), noise_picture(Rng(6), 0, 40)});
  EXPECT_LE(emd_grey(a, c), emd_grey(a, b) + emd_grey(b, c) + kRoundoff_grey);
}

INSTANTIATE_TEST_SUITE_P(EitherMethod, PlaceSignatureOf,
                         ::testing::Values(SignatureMethod::kGrid, SignatureMethod::kMosaic));

TEST(PlaceSignature, AGridKnowsWhereThingsAreAndAMosaicDoesNot) {
  cv::Mat left = noise_picture(Rng(1), 0, 100);
  left.colRange(0, 160) += 100;
  cv::Mat right;
  cv::flip(left, right, 1);
  for (const SignatureMethod method : {SignatureMethod::kGrid, SignatureMethod::kMosaic}) {
    const SignatureOptions options = options_of(method);
    const double apart_grey =
        emd_grey(place_signature(options, {left, left}), place_signature(options, {right, right}));
    // each half is 100 grey levels from the other's
    EXPECT_NEAR(apart_grey, method == SignatureMethod::kGrid ? 100 : 0, 1);
    EXPECT_NEAR(emd_grey(place_signature(options, {left, right}),
                         place_signature(options, {right, left}), kOpposite),
                0, kRoundoff_grey);
  }
}

}  // namespace
}  // namespace panoptes
