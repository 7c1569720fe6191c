// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/patch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr int kPixels = Patch::kSide_px * Patch::kSide_px;
constexpr int kIterations = 10;
constexpr double kConverged_px = 0.005;
constexpr double kFarthest_px = 2;  // from the best whole pixel

/// Between pixels, linearly; the place and its three neighbours must be on the picture.
float sampled(const cv::Mat& grey, double x, double y) {
  const int u = static_cast<int>(std::floor(x));
  const int v = static_cast<int>(std::floor(y));
  const auto fx = static_cast<float>(x - u);
  const auto fy = static_cast<float>(y - v);
  const std::uint8_t* above = grey.ptr<std::uint8_t>(v) + u;
  const std::uint8_t* below = grey.ptr<std::uint8_t>(v + 1) + u;
  return (1 - fy) * ((1 - fx) * static_cast<float>(above[0]) + fx * static_cast<float>(above[1])) +
         fy * ((1 - fx) * static_cast<float>(below[0]) + fx * static_cast<float>(below[1]));
}

/// Whether all that bilinear sampling of a square about a place needs is on the picture.
bool holds_square(const cv::Mat& grey, const Vec2& px, int half) {
  return px.x() >= half && px.y() >= half && px.x() < grey.cols - half - 1 &&
         px.y() < grey.rows - half - 1;
}

}  // namespace

std::optional<Patch> Patch::seen(const cv::Mat& source, const Vec2& offset_px,
                                 const Mat2& source_by_px) {
  PANOPTES_CHECK(
      source.type() == CV_8U && source.rows == 2 * kSourceHalf_px + 1 && source.cols == source.rows,
      "a patch is made of a grey square");
  // With a border of a pixel, for slopes.
  constexpr int kWide = kSide_px + 2;
  const Vec2 middle = Vec2::Constant(kSourceHalf_px) + offset_px;
  const Vec2 reach = source_by_px.cwiseAbs() * Vec2::Constant(kHalf_px + 1);
  if (!((middle - reach).minCoeff() >= 0 && (middle + reach).maxCoeff() < 2 * kSourceHalf_px)) {
    return std::nullopt;
  }
  std::vector<float> wide(kWide * kWide);
  for (int y = 0; y < kWide; ++y) {
    for (int x = 0; x < kWide; ++x) {
      const Vec2 at = middle + source_by_px * Vec2(x - kHalf_px - 1, y - kHalf_px - 1);
      wide[static_cast<std::size_t>(y * kWide + x)] = sampled(source, at.x(), at.y());
    }
  }
  Patch patch;
  patch.grey_.reserve(kPixels);
  patch.slope_.reserve(kPixels);
  double mean = 0;
  Vec2 mean_slope = Vec2::Zero();
  for (int y = 1; y <= kSide_px; ++y) {
    for (int x = 1; x <= kSide_px; ++x) {
      const float* here = wide.data() + y * kWide + x;
      patch.grey_.push_back(here[0]);
      patch.slope_.emplace_back((here[1] - here[-1]) / 2, (here[kWide] - here[-kWide]) / 2);
      mean += here[0] / kPixels;
      mean_slope += patch.slope_.back() / kPixels;
    }
  }
  for (int i = 0; i < kPixels; ++i) {
    float& grey = patch.grey_[static_cast<std::size_t>(i)];
    Vec2& slope = patch.slope_[static_cast<std::size_t>(i)];
    grey -= static_cast<float>(mean);
    slope -= mean_slope;
    patch.squares_ += static_cast<double>(grey) * grey;
    patch.curvature_ += slope * slope.transpose();
  }
  return patch;
}

double Patch::place_sigma_px(double noise_grey) const {
  // A slope is half the difference of two pixels.
  const double by_noise = kPixels * noise_grey * noise_grey / 2;
  const double least =
      Eigen::SelfAdjointEigenSolver<Mat2>(curvature_, Eigen::EigenvaluesOnly).eigenvalues()[0] -
      by_noise;
  return least > 0 ? noise_grey * std::sqrt(2 / least) : std::numeric_limits<double>::infinity();
}

std::optional<Patch::Found> Patch::find(const cv::Mat& picture, const Vec2& expected_px,
                                        const Mat2& covariance_px2, double sigmas,
                                        double least_correlation) const {
  // The ellipse, at least a pixel each way.
  const Mat2 covariance = covariance_px2 + Mat2::Identity() / (sigmas * sigmas);
  const Mat2 inverse = covariance.inverse();
  const Vec2 reach = sigmas * covariance.diagonal().cwiseSqrt();
  const int x0 = std::max(kHalf_px, static_cast<int>(std::ceil(expected_px.x() - reach.x())));
  const int x1 = std::min(picture.cols - 1 - kHalf_px,
                          static_cast<int>(std::floor(expected_px.x() + reach.x())));
  const int y0 = std::max(kHalf_px, static_cast<int>(std::ceil(expected_px.y() - reach.y())));
  const int y1 = std::min(picture.rows - 1 - kHalf_px,
                          static_cast<int>(std::floor(expected_px.y() + reach.y())));
  if (x0 > x1 || y0 > y1 || squares_ <= 0) {
    return std::nullopt;
  }
  std::vector<std::int32_t> whole(kPixels);
  std::transform(grey_.begin(), grey_.end(), whole.begin(),
                 [](float grey) { return static_cast<std::int32_t>(std::lround(grey)); });
  const int width = x1 - x0 + 1;
  const auto columns = static_cast<std::size_t>(width + kSide_px - 1);
  std::vector<std::int32_t> products(static_cast<std::size_t>(width));
  std::vector<std::int32_t> sums(columns);
  std::vector<std::int32_t> squares(columns);
  double best = least_correlation;
  Vec2 at = Vec2::Zero();
  bool found = false;
  for (int y = y0; y <= y1; ++y) {
    std::fill(products.begin(), products.end(), 0);
    std::fill(sums.begin(), sums.end(), 0);
    std::fill(squares.begin(), squares.end(), 0);
    for (int r = 0; r < kSide_px; ++r) {
      const std::uint8_t* row = picture.ptr<std::uint8_t>(y + r - kHalf_px) + x0 - kHalf_px;
      for (std::size_t x = 0; x < columns; ++x) {
        sums[x] += row[x];
        squares[x] += row[x] * row[x];
      }
      for (int c = 0; c < kSide_px; ++c) {
        const std::int32_t grey = whole[static_cast<std::size_t>(r * kSide_px + c)];
        for (int x = 0; x < width; ++x) {
          products[static_cast<std::size_t>(x)] += grey * row[x + c];
        }
      }
    }
    double sum = 0;
    double square = 0;
    for (std::size_t x = 0; x + 1 < static_cast<std::size_t>(kSide_px); ++x) {
      sum += sums[x];
      square += squares[x];
    }
    for (int x = 0; x < width; ++x) {
      const auto k = static_cast<std::size_t>(x);
      sum += sums[k + kSide_px - 1];
      square += squares[k + kSide_px - 1];
      const double variance = square - sum * sum / kPixels;
      const Vec2 off = Vec2(x0 + x, y) - expected_px;
      if (variance > 0 && off.dot(inverse * off) <= sigmas * sigmas) {
        const double correlation = products[k] / std::sqrt(variance * squares_);
        if (correlation > best) {
          best = correlation;
          at = Vec2(x0 + x, y);
          found = true;
        }
      }
      sum -= sums[k];
      square -= squares[k];
    }
  }
  std::optional<Found> refined = found ? refine(picture, at) : std::nullopt;
  if (refined && refined->correlation < least_correlation) {
    return std::nullopt;
  }
  return refined;
}

std::optional<Patch::Found> Patch::refine(const cv::Mat& picture, const Vec2& start_px) const {
  if (curvature_.determinant() <= 0) {
    return std::nullopt;
  }
  const Mat2 inverse = curvature_.inverse();
  Found found{start_px, 0, 0};
  std::vector<float> seen(kPixels);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (!holds_square(picture, found.px, kHalf_px)) {
      return std::nullopt;
    }
    float mean = 0;
    for (int y = 0, i = 0; y < kSide_px; ++y) {
      for (int x = 0; x < kSide_px; ++x, ++i) {
        const float grey =
            sampled(picture, found.px.x() + x - kHalf_px, found.px.y() + y - kHalf_px);
        seen[static_cast<std::size_t>(i)] = grey;
        mean += grey / kPixels;
      }
    }
    double product = 0;
    double square = 0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      seen[i] -= mean;
      product += static_cast<double>(seen[i]) * grey_[i];
      square += static_cast<double>(seen[i]) * seen[i];
    }
    if (square <= 0 || product <= 0) {
      return std::nullopt;
    }
    // What the picture has more than the patch, its contrast made the patch's.
    const double contrast = product / square;
    Vec2 pull = Vec2::Zero();
    double left = 0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      const double off = contrast * seen[i] - grey_[i];
      pull += off * slope_[i];
      left += off * off;
    }
    const Vec2 step = -(inverse * pull);
    found.correlation = product / std::sqrt(square * squares_);
    constexpr int kTold = 4;  // place, brightness, contrast
    found.sigma_px = std::sqrt(left / (kPixels - kTold) * inverse.trace() / 2);
    found.px += step;
    if ((found.px - start_px).norm() > kFarthest_px) {
      return std::nullopt;
    }
    if (step.norm() < kConverged_px) {
      return found;
    }
  }
  return std::nullopt;
}

}  // namespace panoptes
