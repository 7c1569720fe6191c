// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/camera/rig.h"
#include "core/motion/rig_estimate.h"

namespace panoptes {

/// One number of the rig as a run has come to know it.
struct LearnedValue {
  double value = 0;
  double sigma = 0;
  std::optional<double> error;  ///< with truth: estimated minus true
};

/// What a run has learned of one loop camera. A direction in which it has not told at least as much
/// as the rig file is empty: one whose variance is not below half of what it was.
struct LearnedCamera {
  /// Corrections of the mounting, as `mounting_offset` has them.
  std::optional<LearnedValue> roll_rad;
  std::optional<LearnedValue> pitch_rad;
  std::optional<LearnedValue> yaw_rad;
  std::optional<LearnedValue> x_m;
  std::optional<LearnedValue> y_m;
  std::optional<LearnedValue> z_m;      ///< where another camera met what it saw
  std::optional<LearnedValue> clock_s;  ///< its whole offset, as a rig file has it
  /// Correction of where the picture's centre looks, about the vertical: yaw and principal point,
  /// of which pictures hardly tell which is which. Empty where it looks steeply up or down, too.
  std::optional<LearnedValue> centre_bearing_rad;
  std::optional<double> position_error_m;  ///< with truth: of x and y together

  /// With truth: the error of all that was learned. In how many independent directions of the
  /// states (those in which the variance, seen from the prior, is below half of it), and its
  /// squared Mahalanobis distance there.
  struct Consistency {
    int freedom = 0;
    double chi2 = 0;
    bool inside_95 = false;  ///< of the ellipsoid in which 95 of 100 truths ought to lie
  };
  std::optional<Consistency> consistency;
};

/// By the cameras' names. `believed` is the rig as the robot believed it, `truth` may be null; a
/// camera that the truth does not know has no errors.
std::map<std::string, LearnedCamera> learned_cameras(const RigEstimate& estimate,
                                                     const Rig& believed, const Rig* truth);

struct LearnedWheels {
  std::optional<LearnedValue> radius_ratio;  ///< left against right, believed to be 1
  std::optional<LearnedValue> base_m;
};
LearnedWheels learned_wheels(const RigEstimate& estimate, double believed_base_m);

}  // namespace panoptes
