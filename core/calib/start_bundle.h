// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A later picture of a camera that starts to move.
struct StartView {
  Pose3 T_first_camera;         ///< a first guess, in the frame of the first picture's camera
  std::map<int, Vec2> seen_px;  ///< where it shows points of the first picture, by their numbers
};

struct StartBundleOptions {
  double sigma_px = 0.15;             ///< of where points are seen, each way
  double inverse_depth_per_m = 0.5;   ///< of points: their mean comes out as this
  double inverse_depth_sigma = 0.25;  ///< what is known of each before
};

/// How far the points of a first picture are, as all views together have it: bundle adjustment of a
/// small motion (Yu and Gallup 2014), which needs no guess of the depths and next to none of the
/// poses, where a filter has to commit itself picture by picture. Inverse depths by the points'
/// numbers, in 1/m along the ray from the first picture; empty where the views do not determine
/// them.
std::optional<std::map<int, double>> start_inverse_depths(const StartBundleOptions& options,
                                                          const Intrinsics& lens,
                                                          const std::map<int, Vec2>& first_px,
                                                          const std::vector<StartView>& views);

}  // namespace panoptes
