// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/rng.h"

namespace panoptes {

constexpr int kWallStep_px = 80;  // a picture of 320 pixels has nothing of the fourth after it

/// What a camera sees that drives along a wall of random blotches, `at_px` from its beginning, a
/// little nearer or farther and under another light each time.
inline cv::Mat wall_picture(int at_px, Rng rng) {
  constexpr int kBlotch_px = 6;
  constexpr int kPad_px = 24;
  cv::Mat blotches(50, (400 + 2 * kPad_px) / kBlotch_px + 2, CV_8U);
  const int first = at_px / kBlotch_px;
  for (int column = 0; column < blotches.cols; ++column) {
    Rng of_column = Rng(11).fork(std::to_string(first + column));
    const int shade = of_column.index(120);
    for (int row = 0; row < blotches.rows; ++row) {
      blotches.at<std::uint8_t>(row, column) =
          static_cast<std::uint8_t>(shade + of_column.index(120));
    }
  }
  cv::Mat wide;
  cv::resize(blotches, wide, cv::Size(), kBlotch_px, kBlotch_px, cv::INTER_CUBIC);
  const int nearer_px = rng.index(kPad_px);
  const cv::Rect seen(at_px % kBlotch_px + nearer_px, 24 + nearer_px * 3 / 4,
                      320 - 2 * nearer_px + 48, 240 - 3 * nearer_px / 2);
  cv::Mat picture;
  cv::resize(wide(seen), picture, cv::Size(320, 240), 0, 0, cv::INTER_LINEAR);
  const double light = rng.uniform(0.7, 1.1);
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      auto& pixel = picture.at<std::uint8_t>(row, column);
      pixel = cv::saturate_cast<std::uint8_t>(light * pixel + rng.normal(0, 4));
    }
  }
  return picture;
}

}  // namespace panoptes
