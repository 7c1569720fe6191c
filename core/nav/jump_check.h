// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/motion/local_bundle.h"
#include "core/nav/keyframe_odometry.h"
#include "core/nav/knock_check.h"

namespace panoptes {

/// Notices a loop camera that is knocked while the robot drives at the very keyframe: what is
/// followed across it shows the camera to have jumped, and the wheels and the other cameras show
/// that the body has not. A shift of some millimetres so shows at once, where the depths are known,
/// and long before bundles show another mounting each by itself (KnockCheck).
/// Each keyframe is looked at when a few have come after it; where it is suspicious, it is judged
/// by many before and after it. The verdict must hold with any third of the picture left out:
/// somebody who walks by is in a part of it.
class JumpCheck {
 public:
  /// What the keyframes show of a jump right before keyframe `at`: see KeyframeOdometry::jump.
  using Shows = std::function<MountingJump(
      int at, int before, int most, const std::optional<KeyframeOdometry::PictureThird>& without)>;

  /// Looks at what the newest keyframe has made old enough.
  void look(int newest, const Shows& shows);

  /// One of those that are to be judged by now, if any.
  std::optional<Knock> judge(int newest, const Shows& shows);
  bool to_judge(int newest) const;

  /// The rig is another one from this keyframe on.
  void begin_anew(int keyframe) {
    first_ = keyframe;
    suspicions_.clear();
  }

 private:
  struct Suspicion {
    int keyframe = 0;
    std::size_t judged = 0;  ///< how often
  };

  bool is_due(const Suspicion& suspicion, int newest) const;

  int first_ = 40;  // before it the rig is hardly known
  std::vector<Suspicion> suspicions_;
};

}  // namespace panoptes
