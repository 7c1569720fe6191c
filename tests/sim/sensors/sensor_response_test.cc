// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/sensor_response.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace panoptes::sim {
namespace {

const Intrinsics kLens = pinhole(320, 240, deg_to_rad(80));

cv::Mat flat(int grey) { return {240, 320, CV_8UC3, cv::Scalar::all(grey)}; }

cv::Mat exposed(const SensorResponse& sites, int grey, std::int64_t number, double gain = 1) {
  cv::Mat picture = flat(grey);
  sites.expose(picture, gain, number);
  return picture;
}

TEST(SensorResponse, KeepThePhotonTransferCurve) {
  const PhotonNoise noise{8000, 12};
  for (const double gain : {1.0, 4.0}) {
    const SensorResponse sites(kLens, 3, 0, noise, Rng(1));
    const double white_e = noise.full_well_e / gain;
    for (const int grey : {30, 60, 120, 180, 220}) {
      const double expected_e = std::pow(grey / 255.0, 2) * white_e;
      double sum = 0;
      double sum2 = 0;
      constexpr int kPictures = 8;
      for (int i = 0; i < kPictures; ++i) {
        const cv::Mat values = exposed(sites, grey, i, gain).reshape(1);
        for (auto value = values.begin<std::uint8_t>(); value != values.end<std::uint8_t>();
             ++value) {
          const double e = std::pow(*value / 255.0, 2) * white_e;
          sum += e;
          sum2 += e * e;
        }
      }
      const double count = 320.0 * 240 * 3 * kPictures;
      const double mean_e = sum / count;
      // Rounding to whole grey levels adds a 12th of a level squared.
      const double level_e = 2 * expected_e / grey;
      const double variance_e2 = sum2 / count - mean_e * mean_e - level_e * level_e / 12;
      const double model_e2 = expected_e + noise.read_e * noise.read_e;
      EXPECT_NEAR(variance_e2 / model_e2, 1, 0.05) << "grey " << grey << " at gain " << gain;
      EXPECT_NEAR(mean_e / expected_e, 1, 0.01) << "grey " << grey << " at gain " << gain;
    }
  }
}

TEST(SensorResponse, ShotNoiseAloneIsTheSameAtEveryGrey) {
  const SensorResponse sites(kLens, 3, 0, PhotonNoise{4064, 0}, Rng(1));
  for (const int grey : {40, 120, 220}) {
    cv::Mat values;
    exposed(sites, grey, 0).reshape(1).convertTo(values, CV_64F);
    cv::Scalar mean;
    cv::Scalar sigma;
    cv::meanStdDev(values, mean, sigma);
    const double expected = std::sqrt(4 + 1.0 / 12);  // rounded to whole levels
    EXPECT_NEAR(sigma[0], expected, 0.02 * expected);
  }
}

TEST(SensorResponse, LightFallsOffAsCos4) {
  constexpr double kLost = 0.3;
  const SensorResponse sites(kLens, 3, kLost, NoNoise{}, Rng(1));
  EXPECT_NEAR(sites.headroom(), 1 - kLost, 1e-12);
  // A wall of grey 200, drawn darker by the headroom.
  const int rendered = static_cast<int>(std::lround(200 * std::sqrt(1 - kLost)));
  const double full = rendered / std::sqrt(1 - kLost);
  const cv::Mat bgr = exposed(sites, rendered, 0);
  const double corner2 = 159.5 * 159.5 + 119.5 * 119.5;
  const double tan2_corner = 1 / std::sqrt(1 - kLost) - 1;
  constexpr double kRounding = 0.51;
  for (const cv::Point px : {cv::Point(0, 0), cv::Point(319, 239), cv::Point(160, 120),
                             cv::Point(40, 200), cv::Point(300, 100)}) {
    const double r2 = std::pow(px.x - 159.5, 2) + std::pow(px.y - 119.5, 2);
    const double theta = std::atan(std::sqrt(tan2_corner * r2 / corner2));
    const double expected = full * std::sqrt(std::pow(std::cos(theta), 4));
    EXPECT_NEAR(bgr.at<cv::Vec3b>(px)[1], expected, kRounding);
  }
  EXPECT_NEAR(std::pow(bgr.at<cv::Vec3b>(0, 0)[0] / full, 2), 1 - kLost, 0.01);
}

TEST(SensorResponse, WhatIsTooBrightIsWhiteInTheCornersToo) {
  const SensorResponse sites(kLens, 3, 0.3, NoNoise{}, Rng(1));
  const cv::Mat bgr = exposed(sites, 255, 0);
  EXPECT_EQ(cv::countNonZero(bgr.reshape(1) != 255), 0);
}

TEST(SensorResponse, NoiseIsDecidedBySeedAndPictureAlone) {
  const SensorResponse sites(kLens, 3, 0.2, PhotonNoise{}, Rng(1));
  const SensorResponse same(kLens, 3, 0.2, PhotonNoise{}, Rng(1));
  const SensorResponse other(kLens, 3, 0.2, PhotonNoise{}, Rng(2));
  exposed(same, 100, 4);  // what was taken before does not matter
  EXPECT_EQ(cv::norm(exposed(sites, 100, 5), exposed(same, 100, 5), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(exposed(sites, 100, 5), exposed(sites, 100, 6), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(exposed(sites, 100, 5), exposed(other, 100, 5), cv::NORM_INF), 0);
}

TEST(SensorResponse, NeitherPicturesNorRowsNorChannelsShareTheirNoise) {
  const SensorResponse sites(kLens, 3, 0, PhotonNoise{2000, 0}, Rng(1));
  cv::Mat a;
  cv::Mat b;
  exposed(sites, 128, 1).convertTo(a, CV_64F, 1, -128);
  exposed(sites, 128, 2).convertTo(b, CV_64F, 1, -128);
  const auto correlation = [](const cv::Mat& x, const cv::Mat& y) {
    return x.dot(y) / std::sqrt(x.dot(x) * y.dot(y));
  };
  const double three_sigma = 3 / std::sqrt(320.0 * 239 * 3);
  EXPECT_LT(std::abs(correlation(a, b)), three_sigma);
  EXPECT_LT(std::abs(correlation(a.rowRange(0, 239).clone(), a.rowRange(1, 240).clone())),
            three_sigma);
  cv::Mat channels[3];
  cv::split(a, channels);
  EXPECT_LT(std::abs(correlation(channels[0], channels[1])), 2 * three_sigma);
}

TEST(SensorResponse, WithoutNoiseAndFalloffChangeNothing) {
  const SensorResponse sites(kLens, 3, 0, NoNoise{}, Rng(1));
  EXPECT_EQ(cv::norm(exposed(sites, 97, 0), flat(97), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace panoptes::sim
