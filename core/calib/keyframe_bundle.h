// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/calib/mono_map.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

struct KeyframeChoice {
  int every = 0;            ///< the thesis's way: each so many-th picture; 0: by parallax
  double parallax_px = 40;  ///< by which what a keyframe shows has moved in the next, the median
  double shared = 0.6;      ///< of what it shows, at least, in the next
  int most = 120;  ///< of more by parallax, so many are taken, evenly: what turns to and fro shows
                   ///< again what it has shown
};

/// The frames of a map that are adjusted, by their numbers: the first, and from each the next that
/// shows what it shows clearly elsewhere (thesis 4.3.3).
std::vector<int> keyframes(const KeyframeChoice& options, const MonoMap& map);

struct KeyframeBundleOptions {
  KeyframeChoice keyframes;
  double inlier_sigma = 3;  ///< by which an observation may be off
  int iterations = 50;
  bool adjust_lens = true;  ///< within what is known of it
};

/// One camera's map as all that its keyframes show has it.
struct AdjustedMap {
  std::vector<int> keyframes;  ///< frames of the map, those that points hold
  std::vector<Pose3> T_map_camera;
  struct Point {
    int number = 0;  ///< as in the map
    Vec3 p_map = Vec3::Zero();
    int observations = 0;  ///< that are believed: fewer than two adjust nothing
  };
  std::vector<Point> points;  ///< those that at least two keyframes show, believed or not
  Intrinsics lens;
  int observations = 0;  ///< that are believed
  int left_out = 0;
  double rms_before_px = 0;  ///< sqrt(mean(dx^2 + dy^2)) of the believed, as the filter had it
  double rms_after_px = 0;
  bool converged = false;
};

/// Bundle adjustment of one camera's keyframes (Triggs et al. 2000; thesis 4.3.3): poses, points
/// and, within the sigmas that `known` gives it about `lens`, the lens. The first pose stays, and
/// the map keeps its scale. A keyframe in which next to nothing agrees is left out.
AdjustedMap adjust_map(const KeyframeBundleOptions& options, const Intrinsics& lens,
                       const CameraSigmas& known, const MonoMap& map);

/// The same by keyframes that are given, frames of the map in order.
AdjustedMap adjust_map(const KeyframeBundleOptions& options, const Intrinsics& lens,
                       const CameraSigmas& known, const MonoMap& map,
                       const std::vector<int>& keyframes);

}  // namespace panoptes
