// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <Eigen/Core>

#include "core/geometry/pose3.h"

namespace ceres {
class Problem;
}

namespace panoptes {

/// A pose as the solver stores it: the quaternion's x, y, z, w, then the translation.
using PoseBlock = std::array<double, 7>;

PoseBlock to_block(const Pose3& pose);
Pose3 from_block(const double* block);

/// The pose moves by six numbers: a small turn and a shift, both in the frame that it takes points
/// to. A cost function's derivatives by the block are these six and a column of zeros.
void add_pose(ceres::Problem& problem, PoseBlock& block);

/// How T * p moves with the six.
Eigen::Matrix<double, 3, 6> moved_by_pose(const Pose3& T, const Vec3& p);

/// T after such a move.
Pose3 moved(const Pose3& T, const Eigen::Matrix<double, 6, 1>& by);

}  // namespace panoptes
