// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

namespace panoptes {

/// What is counted of every pixel (thesis 6.3.2).
enum class HistogramKind {
  kGrey,           ///< its grey level, in 64 bins
  kColour,         ///< blue, green and red, in 64 bins each, each channel by itself
  kGradient,       ///< by how many levels its grey changes a pixel: 64 bins of one level, the last
                   ///< for all that is steeper
  kTwoDimensional  ///< grey and gradient together: 16 by 16 bins of 16 and of 4 levels
};

enum class HistogramDistance {
  /// The earth mover's, in bins (Rubner, Tomasi, Guibas 2000). Of colour the mean over the
  /// channels; in two dimensions the mean over eight directions of what it costs along each, which
  /// is a metric and never more than the whole (sliced, Rabin et al. 2011).
  kEmd,
  kChiSquare,     ///< half the sum of (a - b)^2 / (a + b)
  kIntersection,  ///< what the two do not share: 1 - sum of min(a, b) (Swain, Ballard 1991)
  kL2
};

/// One histogram of all pictures of a place, as if they stood side by side in one mosaic: it is the
/// same whatever their order, so for a robot that has turned round between two like cameras.
struct PlaceHistogram {
  std::vector<float> shares;      ///< of the pixels; they sum to 1
  std::vector<float> cumulative;  ///< their earth mover's distance is the L1 distance of these
};

/// Of at least one picture, 8-bit BGR, 3 x 3 pixels or larger. Its size counts: a larger picture is
/// a larger part of the mosaic.
PlaceHistogram place_histogram(HistogramKind kind, const std::vector<cv::Mat>& pictures_bgr);

/// Between two of a kind.
double histogram_distance(HistogramDistance distance, const PlaceHistogram& a,
                          const PlaceHistogram& b);

}  // namespace panoptes
