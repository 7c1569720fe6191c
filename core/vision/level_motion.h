// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/base/rng.h"

namespace panoptes {

/// One thing in two pictures, from the middle of each.
struct PixelPair {
  Eigen::Vector2f a_px;
  Eigen::Vector2f b_px;
};

struct LevelMotionOptions {
  double noise_px = 2;   ///< how far from its epipolar line a true match may lie
  int hypotheses = 200;  ///< finds a motion that three matches in ten agree with, 99 times in 100
};

/// How well pairs agree with one motion.
struct LevelAgreement {
  int inliers = 0;  ///< pairs that agree with the motion that most agree with
  /// ln of how many motions so many pairs would agree with, were the pairs matched at random among
  /// themselves (the number of false alarms of Moisan and Stival 2004): far below 0 where the
  /// agreement is no chance. How often a random match agrees is counted on the pairs' own points.
  double log_chance = 0;
  std::vector<int> agreeing;  ///< the inliers' places among the pairs
};

/// How many pairs agree with one motion of a camera that stays level, as on a robot's mast: turns
/// about the vertical and moves on the floor. The fundamental matrix of that has four numbers and
/// no scale, whatever the focal length, so three pairs give it by linear equations: much quicker
/// than seven that give any motion, and chance agrees much more rarely. The horizon must be near
/// the middle of the pictures.
LevelAgreement level_agreement(const LevelMotionOptions& options,
                               const std::vector<PixelPair>& pairs, Rng rng);

/// The pairs that agree alone.
int level_inliers(const LevelMotionOptions& options, const std::vector<PixelPair>& pairs, Rng rng);

}  // namespace panoptes
