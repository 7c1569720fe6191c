// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

namespace panoptes {

/// An 8-bit picture, BGR or grey, in greys: itself where it has no others.
cv::Mat grey_of(const cv::Mat& picture);

}  // namespace panoptes
