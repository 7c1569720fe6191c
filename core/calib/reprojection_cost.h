// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/camera/rig.h"

namespace ceres {
class CostFunction;
}

namespace panoptes {

/// Whether the lens has a place for what lies there: not behind a pinhole, nor at the centre.
bool can_draw(const Intrinsics& lens, const Vec3& p_camera);

/// A point where a picture shows it, against where lens, pose and place draw it, in standard
/// deviations. Blocks: the lens (lens_parameters), T_camera_map (core/calib/pose_block.h), and the
/// point in map. For the solver, which owns it.
ceres::CostFunction* reprojection_cost(const Intrinsics& lens, const Vec2& seen_px,
                                       double sigma_px);

/// The same of a point whose place is known: without its block.
ceres::CostFunction* reprojection_cost(const Intrinsics& lens, const Vec2& seen_px, double sigma_px,
                                       const Vec3& p_map);

/// How far observations are off, each way, by the median of their squared distances: what is false
/// hardly counts. Of one at least.
double sigma_by_median(std::vector<double> squared_px);

}  // namespace panoptes
