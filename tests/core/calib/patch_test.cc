// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/patch.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr int kSide_px = 160;

/// A smooth pattern without repetition, seen through p -> A p + shift.
cv::Mat pattern(const Mat2& A, const Vec2& shift, double noise_grey = 0) {
  Rng rng(4);
  cv::Mat picture(kSide_px, kSide_px, CV_8U);
  for (int v = 0; v < kSide_px; ++v) {
    for (int u = 0; u < kSide_px; ++u) {
      const Vec2 p = A * Vec2(u, v) + shift;
      const double grey = 110 + 40 * std::sin(0.31 * p.x() + 0.002 * p.y() * p.y()) +
                          35 * std::cos(0.27 * p.y() - 0.0015 * p.x() * p.x());
      picture.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(grey + noise_grey * rng.normal());
    }
  }
  return picture;
}

cv::Mat around(const cv::Mat& picture, int u, int v) {
  constexpr int kHalf = Patch::kSourceHalf_px;
  return picture(cv::Rect(u - kHalf, v - kHalf, 2 * kHalf + 1, 2 * kHalf + 1)).clone();
}

TEST(Patch, IsFoundBetweenPixels) {
  const cv::Mat first = pattern(Mat2::Identity(), Vec2::Zero());
  const Patch patch = Patch::seen(around(first, 70, 80), Vec2(0.3, -0.2), Mat2::Identity()).value();
  for (const Vec2& shift : {Vec2(0, 0), Vec2(0.25, 0.5), Vec2(-4.4, 3.7)}) {
    const cv::Mat second = pattern(Mat2::Identity(), shift);
    const auto found = patch.find(second, Vec2(70, 80), 9 * Mat2::Identity(), 3, 0.8);
    ASSERT_TRUE(found);
    constexpr double kInterpolation_px = 0.03;  // linear, of a pattern with waves of 20 px
    EXPECT_LT((found->px - (Vec2(70.3, 79.8) - shift)).norm(), kInterpolation_px);
  }
}

TEST(Patch, IsFoundAsItLooksFromElsewhere) {
  Mat2 source_by_px;
  source_by_px << 0.7, 0.1, -0.05, 1.3;
  const cv::Mat first = pattern(Mat2::Identity(), Vec2::Zero());
  const cv::Mat second = pattern(source_by_px, Vec2::Zero());
  const Vec2 there = source_by_px.inverse() * Vec2(70, 80);
  const Patch patch = Patch::seen(around(first, 70, 80), Vec2::Zero(), source_by_px).value();
  const auto found = patch.find(second, there + Vec2(2, -1), 4 * Mat2::Identity(), 3, 0.9);
  ASSERT_TRUE(found);
  constexpr double kInterpolation_px = 0.05;
  EXPECT_LT((found->px - there).norm(), kInterpolation_px);
}

TEST(Patch, LightChangesNothing) {
  const cv::Mat first = pattern(Mat2::Identity(), Vec2::Zero());
  const Patch patch = Patch::seen(around(first, 70, 80), Vec2::Zero(), Mat2::Identity()).value();
  cv::Mat darker;
  pattern(Mat2::Identity(), Vec2(1.5, 0)).convertTo(darker, CV_8U, 0.5, 20);
  const auto found = patch.find(darker, Vec2(70, 80), 4 * Mat2::Identity(), 3, 0.9);
  ASSERT_TRUE(found);
  EXPECT_LT((found->px - Vec2(68.5, 80)).norm(), 0.05);
}

TEST(Patch, TellsHowWellItsPlaceIsTold) {
  const cv::Mat first = pattern(Mat2::Identity(), Vec2::Zero());
  const Patch patch = Patch::seen(around(first, 70, 80), Vec2::Zero(), Mat2::Identity()).value();
  double squares = 0;
  double told = 0;
  constexpr int kPictures = 40;
  Rng rng(9);
  for (int i = 0; i < kPictures; ++i) {
    cv::Mat noisy = first.clone();
    for (int k = 0; k < kSide_px * kSide_px; ++k) {
      noisy.at<std::uint8_t>(k) =
          cv::saturate_cast<std::uint8_t>(noisy.at<std::uint8_t>(k) + 6 * rng.normal());
    }
    const auto found = patch.find(noisy, Vec2(70, 80), Mat2::Identity(), 3, 0.5);
    ASSERT_TRUE(found);
    squares += (found->px - Vec2(70, 80)).squaredNorm() / 2;
    told += found->sigma_px * found->sigma_px;
  }
  EXPECT_GT(told / squares, 0.6);
  EXPECT_LT(told / squares, 1.6);
}

TEST(Patch, WhatShowsNothingIsNotFound) {
  const cv::Mat blank(kSide_px, kSide_px, CV_8U, cv::Scalar(90));
  const Patch patch = Patch::seen(around(blank, 70, 80), Vec2::Zero(), Mat2::Identity()).value();
  EXPECT_TRUE(std::isinf(patch.place_sigma_px(2)));
  EXPECT_FALSE(patch.find(blank, Vec2(70, 80), 4 * Mat2::Identity(), 3, 0.8));
  // nor something else, nor off the picture
  const cv::Mat first = pattern(Mat2::Identity(), Vec2::Zero());
  const Patch of_pattern =
      Patch::seen(around(first, 70, 80), Vec2::Zero(), Mat2::Identity()).value();
  EXPECT_FALSE(of_pattern.find(blank, Vec2(70, 80), 4 * Mat2::Identity(), 3, 0.8));
  EXPECT_FALSE(of_pattern.find(first, Vec2(-40, 80), 4 * Mat2::Identity(), 3, 0.8));
}

TEST(Patch, OfMoreThanItsSurroundingsIsNone) {
  const cv::Mat first = pattern(Mat2::Identity(), Vec2::Zero());
  EXPECT_FALSE(Patch::seen(around(first, 70, 80), Vec2::Zero(), 3 * Mat2::Identity()));
}

}  // namespace
}  // namespace panoptes
