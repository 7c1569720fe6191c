// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/anchored_pose.h"

#include <algorithm>

namespace panoptes {

AnchoredPose::AnchoredPose(const Pose2& T_map_place, std::span<const Pose2> T_map_keyframes)
    : T_map_place_(T_map_place) {
  const Vec2 p = T_map_place.position();
  const auto nearest = std::min_element(
      T_map_keyframes.begin(), T_map_keyframes.end(), [&p](const Pose2& a, const Pose2& b) {
        return (a.position() - p).squaredNorm() < (b.position() - p).squaredNorm();
      });
  if (nearest != T_map_keyframes.end()) {
    keyframe_ = static_cast<int>(nearest - T_map_keyframes.begin());
    T_map_keyframe_ = *nearest;
  }
}

void AnchoredPose::follow(std::span<const Pose2> T_map_keyframes) {
  if (keyframe_ < 0 || keyframe_ >= std::ssize(T_map_keyframes)) {
    return;
  }
  const Pose2& T_map_now = T_map_keyframes[static_cast<std::size_t>(keyframe_)];
  if (!(T_map_now == T_map_keyframe_)) {
    T_map_place_ = T_map_now * (T_map_keyframe_.inverse() * T_map_place_);
    T_map_keyframe_ = T_map_now;
  }
}

}  // namespace panoptes
