// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/camera/rig.h"

namespace panoptes {

/// A lens as a row of numbers, for whoever estimates it: fx, fy, cx, cy in pixels, then the
/// coefficients of its distortion in the order of its struct.
Eigen::VectorXd lens_parameters(const Intrinsics& lens);

/// The same lens and sensor with other numbers: as many as lens_parameters gives.
Intrinsics with_parameters(Intrinsics lens, const Eigen::VectorXd& parameters);

/// What the numbers are called in a rig file: "fx_px", ..., "k1", ...
std::vector<std::string> lens_parameter_names(const Intrinsics& lens);

/// Where a point is drawn, and how that changes with the point and with the lens.
struct Projection {
  Vec2 px = Vec2::Zero();
  Eigen::Matrix<double, 2, 3> px_by_point = Eigen::Matrix<double, 2, 3>::Zero();  ///< px per metre
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 9> px_by_lens;  ///< a column a parameter
};

/// As Intrinsics::project, with the same demands on the point; on the axis of Equidistant the limit
/// is taken, behind it there is none.
Projection project_with_jacobian(const Intrinsics& lens, const Vec3& p_camera);

/// How a direction (unit) changes with the pixel that it is drawn at; empty where pixels have no
/// direction of their own.
std::optional<Eigen::Matrix<double, 3, 2>> direction_by_px(const Intrinsics& lens,
                                                           const Vec3& direction);

}  // namespace panoptes
