// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/saddle.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRadius_px = 8;

/// A picture of so many grey levels at each place, averaged over each pixel.
cv::Mat picture(const std::function<double(const Vec2&)>& grey, double noise_grey, Rng& rng) {
  cv::Mat out(32, 32, CV_8U);
  constexpr int kParts = 8;
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      double sum = 0;
      for (int j = 0; j < kParts; ++j) {
        for (int i = 0; i < kParts; ++i) {
          sum += grey(Vec2(x + (i + 0.5) / kParts - 0.5, y + (j + 0.5) / kParts - 0.5));
        }
      }
      out.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(sum / (kParts * kParts) + noise_grey * rng.normal());
    }
  }
  return out;
}

struct Crossing {
  Vec2 at_px = Vec2(15.3, 16.4);
  double angle_a_rad = 0.3;
  double angle_b_rad = 1.7;
  double curve_per_px = 0;

  Vec2 along_a() const { return {std::cos(angle_a_rad), std::sin(angle_a_rad)}; }
  Vec2 along_b() const { return {std::cos(angle_b_rad), std::sin(angle_b_rad)}; }
  double grey(const Vec2& px) const {
    const Vec2 d = px - at_px;
    const auto side = [&](const Vec2& along) {
      const double t = along.dot(d);
      const double across = along.x() * d.y() - along.y() * d.x() - 0.5 * curve_per_px * t * t;
      return std::erf(across / 0.9);
    };
    return (110 + 70 * side(along_a()) * side(along_b())) * (1 + 0.007 * d.x());
  }
};

std::optional<Vec2> found(const Crossing& crossing, double noise_grey, Rng& rng) {
  const cv::Mat grey = picture([&](const Vec2& px) { return crossing.grey(px); }, noise_grey, rng);
  const Vec2 guess_px = crossing.at_px + Vec2(rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4));
  return fit_saddle(grey, guess_px, crossing.along_a() + Vec2(0.05, -0.03),
                    crossing.along_b() + Vec2(-0.04, 0.02), kRadius_px, 1);
}

TEST(Saddle, IsFoundWhereItIs) {
  Rng rng(1);
  constexpr double kWholeGreys_px = 0.004;  // what rounding to grey levels leaves
  for (int i = 0; i < 20; ++i) {
    Crossing crossing;
    crossing.at_px = Vec2(rng.uniform(15, 16), rng.uniform(15, 16));
    crossing.angle_a_rad = rng.uniform(0, 3);
    crossing.angle_b_rad = crossing.angle_a_rad + rng.uniform(0.9, 2.2);
    crossing.curve_per_px = rng.uniform(-0.01, 0.01);
    const auto px = found(crossing, 0, rng);
    ASSERT_TRUE(px.has_value());
    EXPECT_LT((*px - crossing.at_px).norm(), kWholeGreys_px);
  }
}

TEST(Saddle, NoiseMovesItByAHundredthOfAPixel) {
  Rng rng(2);
  double squared = 0;
  constexpr int kDraws = 100;
  for (int i = 0; i < kDraws; ++i) {
    const Crossing crossing;
    const auto px = found(crossing, 2, rng);
    ASSERT_TRUE(px.has_value());
    squared += (*px - crossing.at_px).squaredNorm() / 2;
  }
  constexpr double kHundredthAndAHalf_px = 0.015;
  EXPECT_LT(std::sqrt(squared / kDraws), kHundredthAndAHalf_px);
}

TEST(Saddle, WhatIsNoCrossingIsRefused) {
  Rng rng(3);
  const auto refused = [&](const std::function<double(const Vec2&)>& grey) {
    return !fit_saddle(picture(grey, 2, rng), Vec2(16, 16), Vec2(1, 0), Vec2(0, 1), kRadius_px, 1)
                .has_value();
  };
  EXPECT_TRUE(refused([](const Vec2&) { return 128.0; })) << "a wall";
  EXPECT_TRUE(refused([](const Vec2& px) { return px.x() > 16 ? 200.0 : 40.0; })) << "an edge";
  EXPECT_TRUE(refused([](const Vec2& px) { return px.x() > 16 && px.y() > 16 ? 200.0 : 40.0; }))
      << "the corner of a box";
  EXPECT_TRUE(refused([](const Vec2& px) {
    return 128 + 70 * std::sin(2 * px.x()) * std::sin(2.2 * px.y());
  })) << "texture";
  const Crossing far_off{Vec2(18.5, 16)};
  EXPECT_TRUE(refused([&](const Vec2& px) { return far_off.grey(px); }));
  const Crossing crossing;
  const cv::Mat grey = picture([&](const Vec2& px) { return crossing.grey(px); }, 0, rng);
  EXPECT_FALSE(
      fit_saddle(grey, crossing.at_px, crossing.along_a(), crossing.along_b(), 2, 1).has_value())
      << "too few pixels";
}

}  // namespace
}  // namespace panoptes
