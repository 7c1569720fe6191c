// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/motion/relative_motion.h"
#include "core/motion/rig_correction.h"

namespace panoptes {

/// A place and when its pictures were taken.
struct TimedPlace {
  const PictureTimes& taken;
  const PlaceFeatures& features;
  const PlaceDepths& depths;
};

/// How a motion that these matches show changes with the states of the rig, to first order: x, y,
/// theta in the frame of `a` a row. Depths have their unit from the wheels, and grow as these do: a
/// motion that they tell says nothing of the scale. They do not change with the cameras' states:
/// they came from pictures of one camera each, which what is wrong with it moves alike.
Eigen::MatrixXd motion_by_rig(const MotionOptions& options, const LoopCameras& believed,
                              const RigState& state, const TimedPlace& a, const TimedPlace& b,
                              const std::vector<PlaceMatch>& matches, const Pose2& T_a_b);

}  // namespace panoptes
