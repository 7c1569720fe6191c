// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <opencv2/core/mat.hpp>

#include "core/config/fields.h"

namespace panoptes {

/// What is counted in a signature.
enum class SignatureMethod {
  kGrid,   ///< the greys of each of eight cells of each picture, in 16 bins
  kMosaic  ///< the thesis's own (6.3.2): the greys of both pictures together
};

struct SignatureOptions {
  SignatureMethod method = SignatureMethod::kGrid;
  bool subtract_mean = true;  ///< a change of brightness by c grey levels would cost c otherwise
};
void bind(Fields& f, SignatureOptions& o);

/// A coarse descriptor of a place: cumulative grey histograms of its front and back picture.
struct PlaceSignature {
  /// The share of pixels up to each grey level of the front|back mosaic; or, of a grid, up to the
  /// end of each bin in each cell: the front's four columns by two rows first, row by row.
  std::array<float, 256> cumulative{};
  bool grid = false;
};

/// From two 8-bit pictures, BGR or grey.
PlaceSignature place_signature(const SignatureOptions& options, const cv::Mat& front,
                               const cv::Mat& back);

/// Earth mover's distance in grey levels, the mean over the cells of a grid: in one dimension the
/// L1 distance of the cumulatives. `opposite`: as if the robot had stood at `b` the other way
/// round, front and back exchanged, which makes no difference to a mosaic.
double emd_grey(const PlaceSignature& a, const PlaceSignature& b, bool opposite = false);

}  // namespace panoptes
