// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/calib/salient_features.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A point that can be recognised.
struct KnownPoint {
  Vec3 p_map = Vec3::Zero();
  cv::Mat descriptor;  ///< see describe()
};

/// Where a camera is that sees known points, by their looks and then by their places, without any
/// guess (perspective-n-point within RANSAC). Empty where too few agree to be more than chance.
std::optional<Pose3> camera_by_points(FeatureMethod method, const Intrinsics& lens,
                                      const cv::Mat& grey, const std::vector<KnownPoint>& known);

}  // namespace panoptes
