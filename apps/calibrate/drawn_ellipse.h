// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes {

/// The line about `middle` at so many sigmas.
std::vector<Vec2> drawn_ellipse(const Vec2& middle, const Mat2& covariance, double sigmas);

}  // namespace panoptes
