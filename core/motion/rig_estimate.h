// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/time.h"
#include "core/camera/rig.h"
#include "core/motion/rig_correction.h"

namespace panoptes {

using CameraCovariance = Eigen::Matrix<double, kCameraStates, kCameraStates>;

/// A loop camera that sits otherwise than it did: what had been learned of its mounting has begun
/// anew, and no place from before is recognised by it.
struct KnockReport {
  std::string camera;
  Time since;  ///< at the latest
  Time found;
  double turned_rad = 0;
  double shifted_m = 0;
};

/// In words, for people.
std::string told(const KnockReport& knock);

/// What a run has learned of its loop cameras and its wheels, against what it believed of them.
struct RigEstimate {
  LoopCameras believed;  ///< of the pictures that were looked at, which are straightened
  RigState state;
  Eigen::MatrixXd covariance;        ///< of the state, as it is known at the end,
  Eigen::MatrixXd prior_covariance;  ///< and as it was before anything was seen
  std::vector<KnockReport> knocks = {};
};

/// What no run makes surer, however long: of every thing a picture shows, corners found a tenth of
/// a pixel off lie off the same way whenever it is seen, and a lens is not what its model says. Of
/// the states of all cameras; nothing of the wheels.
Eigen::MatrixXd systematic_covariance(const LoopCameras& cameras);

/// Says that a loop camera is found where no measuring and no knock would put it, across the floor:
/// the rig file is of another rig. Empty while none is.
std::string not_this_rig(const LoopCameras& believed, const RigState& state);

/// The rig that was believed, its loop cameras corrected, with the sigmas that are left. What no
/// state tells of (distortion, cameras that recognise no places) stays, and so does a lens
/// that the correction would make impossible. Sigmas are marginal: what was learned of yaw and
/// principal point together they tell of each alone, and the joint covariance is left out.
Rig refined(const Rig& believed, const RigEstimate& estimate);

}  // namespace panoptes
