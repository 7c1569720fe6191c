// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/pose2.h"

namespace panoptes {

/// A square of a picture around a point, as it looks when it is seen from where it is sought.
class Patch {
 public:
  static constexpr int kHalf_px = 6;
  static constexpr int kSide_px = 2 * kHalf_px + 1;
  /// What `source` must show about the point, each way.
  static constexpr int kSourceHalf_px = 20;

  /// From the surroundings of the point (grey, 2 kSourceHalf_px + 1 square, the point `offset_px`
  /// from the middle of its middle pixel). `source_by_px` is how a place in it moves with one in
  /// the picture in which it is sought. Empty where that reaches out of the surroundings.
  static std::optional<Patch> seen(const cv::Mat& source, const Vec2& offset_px,
                                   const Mat2& source_by_px);

  struct Found {
    Vec2 px = Vec2::Zero();
    double correlation = 0;  ///< -1 to 1, brightness and contrast left aside
    double sigma_px = 0;     ///< of the place, by what is left between patch and picture
  };

  /// Where in the ellipse of `sigmas` about `expected_px` the picture (grey) looks most like it:
  /// whole pixels by correlation, then between them by least squares (Lucas and Kanade 1981, Baker
  /// and Matthews 2004). Empty where the ellipse is not on the picture or nothing alike is there.
  std::optional<Found> find(const cv::Mat& picture, const Vec2& expected_px,
                            const Mat2& covariance_px2, double sigmas,
                            double least_correlation) const;

  /// How well its place could be told where it and the picture have this noise, of grey levels: one
  /// sigma in the direction that it tells least of. Infinite for one that shows noise alone.
  double place_sigma_px(double noise_grey) const;

 private:
  Patch() = default;
  std::optional<Found> refine(const cv::Mat& picture, const Vec2& start_px) const;

  std::vector<float> grey_;        // less its mean
  std::vector<Vec2> slope_;        // of grey by px, less their mean
  Mat2 curvature_ = Mat2::Zero();  // sum of slope * slope^T
  double squares_ = 0;             // of grey_
};

}  // namespace panoptes
