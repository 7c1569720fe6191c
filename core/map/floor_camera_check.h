// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "core/geometry/pose2.h"
#include "core/map/floor_flow.h"

namespace panoptes {

/// How a camera sits now, from how it sat before, about the axes of its view.
struct FloorKnock {
  Vec3 turned_rad = Vec3::Zero();
  Vec2 shifted_m = Vec2::Zero();
};

/// Notices a floor camera that is knocked while the robot drives: what the texture of the floor has
/// shown of its mounting lately is not what it showed before (a generalised likelihood ratio test
/// of a jump, Willsky and Jones 1976). What is off from the beginning (survey, lens, wheels) is
/// learned first and is no fault; by how much more stretches of the drive disagree than they claim
/// is learned, too. One odd stretch is no knock: the test must hold with any one left out.
class FloorCameraCheck {
 public:
  std::optional<FloorKnock> add(const FloorEvidence& evidence);

 private:
  struct Stretch {
    FloorEvidence evidence;
    // by which it disagrees with all before it beyond what both claim, in units of that, and what a
    // variance of one would make of it
    FloorState excess = FloorState::Zero();
    FloorState weight = FloorState::Zero();
  };
  struct Known {
    FloorEvidence evidence;
    int stretches = 0;
    FloorState excess = FloorState::Zero();
    FloorState weight = FloorState::Zero();

    void add(const Stretch& stretch);
    FloorInformation covariance() const;
    FloorInformation between_stretches() const;
    Stretch compare(const FloorEvidence& next) const;
  };
  struct Gain {
    double chi2 = 0;  ///< by which a jump explains better what was shown lately
    FloorKnock jump;
  };
  static Gain gain(const Known& before, const FloorEvidence& lately);
  std::optional<FloorKnock> judge() const;

  FloorEvidence open_;  // the stretch that is being driven
  int steps_ = 0;       // in it
  std::deque<Stretch> lately_;
  Known before_;  // all stretches before those
};

}  // namespace panoptes
