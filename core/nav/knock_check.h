// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include <Eigen/Core>

#include "core/graph/shared_graph.h"
#include "core/motion/rig_correction.h"

namespace panoptes {

/// A camera that sits otherwise than it did.
struct Knock {
  int camera = 0;
  int begin = 0;  ///< it was knocked between this keyframe
  int end = 0;    ///< and that one
  MountingChange change = MountingChange::Zero();
};

/// Notices a loop camera that is knocked while the robot drives: what the newest bundles (here: the
/// parts of a few keyframes of KeyframeOdometry::part) show of its mounting is not what was known
/// of it before them (a generalised likelihood ratio test of a jump, Willsky and Jones 1976). A
/// bundle during which it was knocked fits neither, and says little of which camera it was: the
/// test must hold with any one bundle left out.
class KnockCheck {
 public:
  /// The next bundle; what was known of the states before it, and by how much more bundles disagree
  /// than they claim.
  std::optional<Knock> add(const JointEdge& bundle, const RigState& state,
                           const Eigen::MatrixXd& covariance, double variance_factor);

  /// The rig is another one from here on.
  void begin_anew() {
    bundles_.clear();
    seen_ = 0;
  }

 private:
  struct Bundle {
    int begin = 0;      ///< its first keyframe,
    int end = 0;        ///< and its last
    StateSystem shows;  ///< about `state`
    RigState state;     ///< as known before it,
    Eigen::MatrixXd covariance;
    double variance_factor = 1;
  };
  struct Gain {
    double chi2 = 0;  ///< by which the jump explains the bundles better
    MountingChange change = MountingChange::Zero();
  };

  Knock since_when(int camera, int at_most) const;
  StateSystem sum_of(int first) const;
  Gain gain(const Bundle& before, const StateSystem& shown, int camera) const;

  std::deque<Bundle> bundles_;
  int seen_ = 0;
};

}  // namespace panoptes
