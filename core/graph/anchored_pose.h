// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "core/geometry/pose2.h"

namespace panoptes {

/// A place of the map that is remembered. It is held by the keyframe nearest to it when it was
/// noted and goes where relaxation takes that, as the floor does that was seen from there.
class AnchoredPose {
 public:
  /// Without keyframes it stays where it is.
  AnchoredPose(const Pose2& T_map_place, std::span<const Pose2> T_map_keyframes);

  const Pose2& T_map_place() const { return T_map_place_; }
  Vec2 p_map() const { return T_map_place_.position(); }

  /// To where its keyframe lies now; the same to the bit while that has not moved.
  void follow(std::span<const Pose2> T_map_keyframes);

 private:
  Pose2 T_map_place_;
  int keyframe_ = -1;
  Pose2 T_map_keyframe_;
};

}  // namespace panoptes
