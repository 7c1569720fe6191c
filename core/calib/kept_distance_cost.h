// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace ceres {
class CostFunction;
}

namespace panoptes {

/// A map has no metre of its own: how far two cameras are from each other is kept. Blocks: the
/// poses that take the map's points to each (core/calib/pose_block.h). For the solver, which owns
/// it.
ceres::CostFunction* kept_distance_cost(double distance_m);

}  // namespace panoptes
