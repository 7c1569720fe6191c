// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/calib/pose_block.h"

namespace ceres {
class LossFunction;
template <typename T>
class OrderedGroups;
class Problem;
}  // namespace ceres

// What bundle adjustments have in common.

namespace panoptes {

/// What counts of a residual, in standard deviations: all of it, or less of more than two.
enum class Loss { kSquare, kHuber, kCauchy };

/// For the solver, which owns it.
ceres::LossFunction* made(Loss loss);

/// A map without a metre keeps the first of some poses, and how far apart the first camera and the
/// one farthest from it are. Each block takes the map's points to a camera. False where all of them
/// are in one place, of which there is then nothing to keep.
bool keep_gauge(ceres::Problem& problem, const std::vector<PoseBlock*>& T_camera_map);

struct SchurOptions {
  int iterations = 50;
  double function_tolerance = 1e-6;  ///< a step that lowers the cost by a smaller share is the last
  double largest_radius = 1e16;      ///< of the trust region
};

/// Solves it, the first group of the ordering eliminated first. Whether it has converged. The
/// same bits every time. What `each_step` throws ends it.
bool solve_by_schur(ceres::Problem& problem,
                    const std::shared_ptr<ceres::OrderedGroups<double*>>& ordering,
                    const SchurOptions& options, const std::function<void()>& each_step = {});

}  // namespace panoptes
