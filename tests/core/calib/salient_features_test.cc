// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/salient_features.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/rng.h"
#include "tests/support/wall_pictures.h"

namespace panoptes {
namespace {

class OfMethod : public ::testing::TestWithParam<FeatureMethod> {};

TEST_P(OfMethod, LieInTheAreaTheMostSalientFirst) {
  const cv::Mat picture = wall_picture(0, Rng(1));
  const cv::Rect area(80, 60, 120, 90);
  const auto features = salient_features(GetParam(), picture, area);
  ASSERT_GT(features.size(), 5U);
  for (std::size_t i = 0; i < features.size(); ++i) {
    EXPECT_GE(features[i].px.x(), area.x);
    EXPECT_LT(features[i].px.x(), area.x + area.width);
    EXPECT_GE(features[i].px.y(), area.y);
    EXPECT_LT(features[i].px.y(), area.y + area.height);
    if (i > 0) {
      EXPECT_LE(features[i].saliency, features[i - 1].saliency);
    }
  }
}

TEST_P(OfMethod, AreRecognisedUnderAnotherLight) {
  const cv::Mat picture = wall_picture(0, Rng(1));
  cv::Mat darker;
  picture.convertTo(darker, -1, 0.8, 5);
  const auto features = salient_features(GetParam(), picture, cv::Rect(80, 60, 120, 90));
  const auto kNorm = GetParam() == FeatureMethod::kOrb ? cv::NORM_HAMMING : cv::NORM_L2;
  int right = 0;
  constexpr int kCount = 5;
  for (int i = 0; i < kCount; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const cv::Mat there = describe(GetParam(), darker, features[k]);
    ASSERT_EQ(there.rows, 1);
    double best = 1e9;
    std::size_t nearest = 0;
    for (std::size_t j = 0; j < features.size(); ++j) {
      const double distance = cv::norm(there, describe(GetParam(), picture, features[j]), kNorm);
      if (distance < best) {
        best = distance;
        nearest = j;
      }
    }
    right += (features[nearest].px - features[k].px).norm() < 1 ? 1 : 0;
  }
  EXPECT_GE(right, kCount - 1);
}

INSTANTIATE_TEST_SUITE_P(Features, OfMethod,
                         ::testing::Values(FeatureMethod::kSift, FeatureMethod::kAkaze,
                                           FeatureMethod::kOrb),
                         [](const auto& each) { return std::string(name(each.param)); });

TEST(Features, ThatThisOpenCvLacksAreRefusedInWords) {
  if (const std::string fault = feature_method_fault(FeatureMethod::kSurf); !fault.empty()) {
    EXPECT_EQ(fault,
              "surf is not built in: this OpenCV lacks xfeatures2d; akaze is the nearest to it");
  }
  EXPECT_EQ(feature_method_fault(FeatureMethod::kSift), "");
}

}  // namespace
}  // namespace panoptes
