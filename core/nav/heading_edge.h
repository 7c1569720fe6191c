// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/graph/shared_graph.h"
#include "core/motion/local_bundle.h"
#include "core/motion/motion_by_rig.h"
#include "core/motion/relative_motion.h"
#include "core/vision/local_features.h"

namespace panoptes {

/// One of two keyframes that look the same way from all but the same place.
struct HeadingView {
  int keyframe = 0;
  const BundleFrame* frame = nullptr;
  const PlaceFeatures* features = nullptr;
};

/// By how much the body turned from one keyframe to the other: what the pictures show without any
/// depth, about the motion as it is believed, `T_from_to` with its covariance. The edge says next
/// to nothing of the position. Empty where too few features agree.
std::optional<SharedEdge> heading_edge(const BundleOptions& options, const FeatureOptions& features,
                                       const LoopCameras& cameras, const RigState& state,
                                       const HeadingView& from, const HeadingView& to,
                                       const Pose2& T_from_to, const Mat3& covariance);

/// One of two keyframes at about one place, of which one shows by a camera what the other shows by
/// another.
struct FacingView {
  int keyframe = 0;
  TimedPlace place;
};

/// By how much the body turned and moved from one keyframe to the other, as `facing` pairs their
/// cameras: half a turn on the spot brings the back camera to where the front camera was, and no
/// depth is needed to tell how far that turn was. Empty where too few features agree, or where they
/// contradict `T_from_to`, as the graph with this uncertainty has it.
std::optional<SharedEdge> facing_edge(const MotionOptions& options, const FeatureOptions& features,
                                      const LoopCameras& cameras, const RigState& state,
                                      const Facing& facing, const FacingView& from,
                                      const FacingView& to, const Pose2& T_from_to,
                                      const SharedUncertainty& uncertainty);

}  // namespace panoptes
