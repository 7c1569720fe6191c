// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_histogram.h"

#include <cmath>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-5;  // sums of some hundred floats of up to one

const std::vector<HistogramKind> kKinds{HistogramKind::kGrey, HistogramKind::kColour,
                                        HistogramKind::kGradient, HistogramKind::kTwoDimensional};
const std::vector<HistogramDistance> kDistances{
    HistogramDistance::kEmd, HistogramDistance::kChiSquare, HistogramDistance::kIntersection,
    HistogramDistance::kL2};

// Blobs of a few pixels, so that there are flat parts and steep ones.
cv::Mat blobs(Rng rng) {
  cv::Mat picture(48, 64, CV_8UC3, cv::Scalar::all(rng.uniform(20, 200)));
  for (int i = 0; i < 40; ++i) {
    const cv::Rect at(rng.index(56), rng.index(40), 1 + rng.index(8), 1 + rng.index(8));
    picture(at).setTo(cv::Scalar(rng.index(256), rng.index(256), rng.index(256)));
  }
  return picture;
}

cv::Mat flat(const cv::Scalar& bgr) { return cv::Mat(48, 64, CV_8UC3, bgr); }

TEST(PlaceHistogram, IsMadeOfShares) {
  for (const HistogramKind kind : kKinds) {
    const PlaceHistogram h = place_histogram(kind, {blobs(Rng(1)), blobs(Rng(2))});
    EXPECT_NEAR(std::accumulate(h.shares.begin(), h.shares.end(), 0.0), 1, kRoundoff);
  }
}

TEST(PlaceHistogram, IsTheSameForARobotThatHasTurnedRound) {
  const std::vector<cv::Mat> corners{blobs(Rng(1)), blobs(Rng(2)), blobs(Rng(3)), blobs(Rng(4))};
  const std::vector<cv::Mat> turned{corners[2], corners[3], corners[0], corners[1]};
  for (const HistogramKind kind : kKinds) {
    const PlaceHistogram a = place_histogram(kind, corners);
    const PlaceHistogram b = place_histogram(kind, turned);
    EXPECT_EQ(a.shares, b.shares);
    EXPECT_EQ(a.cumulative, b.cumulative);
  }
}

TEST(PlaceHistogram, DistancesAreSymmetricAndZeroToItself) {
  for (const HistogramKind kind : kKinds) {
    const PlaceHistogram a = place_histogram(kind, {blobs(Rng(1))});
    const PlaceHistogram b = place_histogram(kind, {blobs(Rng(2))});
    for (const HistogramDistance distance : kDistances) {
      EXPECT_GT(histogram_distance(distance, a, b), 0);
      EXPECT_EQ(histogram_distance(distance, a, b), histogram_distance(distance, b, a));
      EXPECT_EQ(histogram_distance(distance, a, a), 0);
    }
  }
}

TEST(PlaceHistogram, DistancesThatAreMetricsKeepTheTriangleInequality) {
  for (const HistogramKind kind : kKinds) {
    const PlaceHistogram a = place_histogram(kind, {blobs(Rng(1))});
    const PlaceHistogram b = place_histogram(kind, {blobs(Rng(2))});
    const PlaceHistogram c = place_histogram(kind, {blobs(Rng(3))});
    for (const HistogramDistance distance :
         {HistogramDistance::kEmd, HistogramDistance::kIntersection, HistogramDistance::kL2}) {
      EXPECT_LE(
          histogram_distance(distance, a, c),
          histogram_distance(distance, a, b) + histogram_distance(distance, b, c) + kRoundoff);
    }
  }
}

TEST(PlaceHistogram, EarthIsMovedByAsManyBinsAsGreysChange) {
  const auto distance = [](HistogramKind kind, int from, int to) {
    return histogram_distance(HistogramDistance::kEmd,
                              place_histogram(kind, {flat(cv::Scalar::all(from))}),
                              place_histogram(kind, {flat(cv::Scalar::all(to))}));
  };
  EXPECT_NEAR(distance(HistogramKind::kGrey, 40, 80), 10, kRoundoff);  // bins of four levels
  EXPECT_NEAR(distance(HistogramKind::kColour, 40, 80), 10, kRoundoff);
  EXPECT_EQ(distance(HistogramKind::kGradient, 40, 80), 0);
  // ten bins of 16 levels along one axis: seen along directions 22.5 degrees apart
  const double seen = distance(HistogramKind::kTwoDimensional, 40, 200) / 10;
  EXPECT_NEAR(seen, 2 / std::numbers::pi, 0.01);  // the mean of |cos|, nearly
}

TEST(PlaceHistogram, ColourTellsApartWhatIsEquallyGrey) {
  const cv::Mat red = flat({0, 0, 200});
  const cv::Mat green = flat({0, 102, 0});  // 0.299 * 200 = 0.587 * 102
  const auto distance = [&](HistogramKind kind, HistogramDistance by) {
    return histogram_distance(by, place_histogram(kind, {red}), place_histogram(kind, {green}));
  };
  for (const HistogramDistance by : kDistances) {
    EXPECT_EQ(distance(HistogramKind::kGrey, by), 0);
    EXPECT_GT(distance(HistogramKind::kColour, by), 0.1);
  }
}

TEST(PlaceHistogram, GradientCountsHowSteepAPictureIs) {
  cv::Mat ramp(48, 64, CV_8UC3);
  for (int u = 0; u < ramp.cols; ++u) {
    ramp.col(u).setTo(cv::Scalar::all(3 * u));
  }
  const PlaceHistogram h = place_histogram(HistogramKind::kGradient, {ramp});
  EXPECT_NEAR(h.shares[3], 1, kRoundoff);  // three levels a pixel, everywhere
}

TEST(PlaceHistogram, OfNothingInCommonIsAsFarAsCanBe) {
  const PlaceHistogram a = place_histogram(HistogramKind::kGrey, {flat(cv::Scalar::all(10))});
  const PlaceHistogram b = place_histogram(HistogramKind::kGrey, {flat(cv::Scalar::all(250))});
  EXPECT_NEAR(histogram_distance(HistogramDistance::kChiSquare, a, b), 1, kRoundoff);
  EXPECT_NEAR(histogram_distance(HistogramDistance::kIntersection, a, b), 1, kRoundoff);
  EXPECT_NEAR(histogram_distance(HistogramDistance::kL2, a, b), std::sqrt(2.0), kRoundoff);
}

}  // namespace
}  // namespace panoptes
