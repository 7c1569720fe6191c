// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <opencv2/core/mat.hpp>

#include "core/config/fields.h"

namespace panoptes {

struct SignatureOptions {
  bool subtract_mean = true;  ///< a change of brightness by c grey levels would cost c otherwise
};
void bind(Fields& f, SignatureOptions& o);

/// What a place looks like at a glance: the cumulative grey histogram of the front|back mosaic, so
/// that it does not change when the robot stands there the other way round (thesis 6.3.2).
struct PlaceSignature {
  std::array<float, 256> cumulative{};  ///< share of pixels up to each grey level
};

/// From two 8-bit pictures, BGR or grey.
PlaceSignature place_signature(const SignatureOptions& options, const cv::Mat& front,
                               const cv::Mat& back);

/// Earth mover's distance in grey levels: in one dimension the L1 distance of the cumulatives.
double emd_grey(const PlaceSignature& a, const PlaceSignature& b);

}  // namespace panoptes
