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
  std::map<int, Vec2> seen_px;  ///< where it shows points of the first picture, by their numbers
};

struct StartBundleOptions {
  double sigma_px = 0.15;             ///< of where points are seen, each way
  double inverse_depth_per_m = 0.5;   ///< of points: their mean comes out as this
  double inverse_depth_sigma = 0.25;  ///< what is known of each before
};

struct StartDepths {
  /// By the points' numbers, in 1/m along the ray from the first picture.
  std::map<int, double> inverse_depth_per_m;
  /// How well they are known by what the views leave over: the median share, one sigma.
  double known_ratio = 0;
  /// What no turn of the camera explains: the median of a view, of the view with most. Without any,
  /// depths all alike and a shift explain a turn.
  double parallax_px = 0;
};

/// How far the points of a first picture are, as all views together have it: bundle adjustment of a
/// small motion (Yu and Gallup 2014), which needs no guess of the depths nor of the poses, where a
/// filter has to commit itself picture by picture. Empty where nothing comes of it.
std::optional<StartDepths> start_depths(const StartBundleOptions& options, const Intrinsics& lens,
                                        const std::map<int, Vec2>& first_px,
                                        const std::vector<StartView>& views);

}  // namespace panoptes
