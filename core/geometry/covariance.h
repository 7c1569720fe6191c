// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/geometry/pose2.h"

namespace panoptes {

/// Nothing is known: infinite variances, and 0 beside them.
Mat3 unknown_covariance();

/// The inverse of a covariance or an information; empty where it is none: not finite, or not
/// positive definite, so that some direction would be known better than exactly.
std::optional<Mat3> inverse_of(const Mat3& covariance);

/// How many sigmas `off` is from what is expected, squared (Mahalanobis), for a gate. Infinite
/// where that cannot be told: what is not known passes no gate.
double squared_sigmas(const Vec3& off, const Mat3& covariance);

}  // namespace panoptes
