// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/graph/shared_graph.h"
#include "core/motion/local_bundle.h"
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

}  // namespace panoptes
