// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <opencv2/core/mat.hpp>

#include "core/geometry/pose2.h"

namespace panoptes {

/// Where two edges cross, as a board's corner is seen: black and white each in two of the four
/// quarters, both edges blurred, a little curved where the lens bends them, and the light on them
/// not quite even. All of it is fitted to the grey levels of the pixels within `radius_px` by least
/// squares, so the corner is known as well as their noise allows: to a hundredth of a pixel where
/// corners by gradients reach a thirtieth. `a_px` and `b_px` are directions along the edges. Empty
/// where the grey levels are no such crossing, or it lies more than `farthest_px` from `guess_px`.
std::optional<Vec2> fit_saddle(const cv::Mat& grey, const Vec2& guess_px, const Vec2& a_px,
                               const Vec2& b_px, double radius_px, double farthest_px);

}  // namespace panoptes
