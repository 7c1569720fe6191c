// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/place_signature.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr int kLevels = 256;
constexpr double kMiddle_grey = 128;  // where the mean is moved to

cv::Mat to_grey(const cv::Mat& picture) {
  PANOPTES_CHECK(picture.type() == CV_8UC3 || picture.type() == CV_8UC1, "8-bit BGR or grey");
  if (picture.channels() == 1) {
    return picture;
  }
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

void count_greys(const cv::Mat& picture, std::array<std::int64_t, kLevels>& count) {
  const cv::Mat grey = to_grey(picture);
  for (int row = 0; row < grey.rows; ++row) {
    const std::uint8_t* pixels = grey.ptr<std::uint8_t>(row);
    for (int column = 0; column < grey.cols; ++column) {
      ++count[pixels[column]];
    }
  }
}

}  // namespace

void bind(Fields& f, SignatureOptions& o) { f("subtract_mean", o.subtract_mean); }

PlaceSignature place_signature(const SignatureOptions& options, const cv::Mat& front,
                               const cv::Mat& back) {
  std::array<std::int64_t, kLevels> count{};
  count_greys(front, count);
  count_greys(back, count);
  std::int64_t total = 0;
  std::int64_t sum = 0;
  for (int grey = 0; grey < kLevels; ++grey) {
    total += count[grey];
    sum += grey * count[grey];
  }
  PANOPTES_CHECK(total > 0, "a picture has pixels");
  const double shift = options.subtract_mean
                           ? kMiddle_grey - static_cast<double>(sum) / static_cast<double>(total)
                           : 0;
  std::array<double, kLevels> share{};
  for (int grey = 0; grey < kLevels; ++grey) {
    // a fraction of a level is split between two
    const double at = std::clamp(grey + shift, 0.0, kLevels - 1.0);
    const int below = static_cast<int>(std::floor(at));
    const double above_share = at - below;
    const double mass = static_cast<double>(count[grey]) / static_cast<double>(total);
    share[below] += mass * (1 - above_share);
    share[std::min(below + 1, kLevels - 1)] += mass * above_share;
  }
  PlaceSignature signature;
  double up_to = 0;
  for (int grey = 0; grey < kLevels; ++grey) {
    up_to += share[grey];
    signature.cumulative[grey] = static_cast<float>(up_to);
  }
  return signature;
}

double emd_grey(const PlaceSignature& a, const PlaceSignature& b) {
  // eight sums side by side, so that the order is fixed and yet runs in vector registers
  std::array<float, 8> sums{};
  for (int grey = 0; grey < kLevels; grey += 8) {
    for (int lane = 0; lane < 8; ++lane) {
      sums[lane] += std::abs(a.cumulative[grey + lane] - b.cumulative[grey + lane]);
    }
  }
  float total = 0;
  for (const float sum : sums) {
    total += sum;
  }
  return total;
}

}  // namespace panoptes
