// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/camera/loop_cameras.h"
#include "core/geometry/pose2.h"
#include "core/motion/relative_motion.h"
#include "core/vision/local_features.h"

namespace panoptes {

/// A place seen from where `here` was or will be.
struct Neighbour {
  const LoopCameras& cameras;
  const PlaceFeatures& features;
  Pose2 T_here_there;
};

/// Depth of each of a place's features, from its matches in neighbouring places at known relative
/// poses, together with how the depths of this place are distributed (empirical Bayes); a feature
/// without a consistent partner keeps the default. `cameras` are those of the
/// place in its keyframe's body.
PlaceDepths triangulate(const FeatureOptions& feature_options, const MotionOptions& options,
                        const LoopCameras& cameras, const PlaceFeatures& here,
                        const std::vector<Neighbour>& neighbours);

}  // namespace panoptes
