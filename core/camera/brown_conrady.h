// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "core/camera/rig.h"

namespace panoptes {

/// Where the lens draws what a pinhole would draw at `p`, in normalised picture coordinates (x / z,
/// y / z).
Vec2 bent(const BrownConrady& o, const Vec2& p);

/// How that changes with p.
Eigen::Matrix2d bent_jacobian(const BrownConrady& o, const Vec2& p);

}  // namespace panoptes
