// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A point as the camera that saw it first and the one that looks for it have it.
struct PointFromBoth {
  Vec3 from_first = Vec3::Zero();  ///< both in one frame, m; or two directions of what is far
  Vec3 from_now = Vec3::Zero();
  Mat3 R_now_first = Mat3::Identity();  ///< of the cameras
  Vec3 p_now = Vec3::Zero();            ///< from_now in the frame of the camera that looks
};

/// How the place in the first picture moves with one in this picture: the point lies on a little
/// plane that faces where it was first seen from. `first_direction_by_px` is of the first camera,
/// at the point. Empty where it looks too different.
std::optional<Mat2> source_by_px(const PointFromBoth& point, const Intrinsics& lens_now,
                                 const Eigen::Matrix<double, 3, 2>& first_direction_by_px);

}  // namespace panoptes
