// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/camera/loop_cameras.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// What a run can learn of one loop camera, as the difference of what is true from what the rig
/// file says: where each entry of the vector lies. Motion over a flat floor does not show the
/// height; where one camera meets what another one saw, how much higher it stands is shown against
/// the scale.
enum CameraParameter : int {
  kRotation = 0,  ///< rad, about the body's x, y, z: T_body_camera.rotation = Exp(.) * believed
  kPosition = 3,  ///< m, along the body's x, y and z
  kHeight = 5,
  kFocal = 6,   ///< share of both focal lengths
  kCentre = 7,  ///< px, of the principal point
  kClock = 9,   ///< s, how much later than the odometry's clock says its stamps are
  kCameraStates = 10
};

/// And of the wheels, after the states of all cameras.
enum WheelParameter : int {
  kWheelScale = 0,       ///< share of both radii
  kWheelDifference = 1,  ///< share by which the right wheel is larger than the left
  kWheelBase = 2,        ///< share of the base
  kWheelStates = 3
};

/// What one camera's mounting can be changed by: the first of its states.
inline constexpr int kMountingStates = kFocal;
using MountingChange = Eigen::Matrix<double, kMountingStates, 1>;

using WheelJacobian = Eigen::Matrix<double, 3, kWheelStates>;

using CameraCorrection = Eigen::Matrix<double, kCameraStates, 1>;  ///< the states of one camera
using RigState = Eigen::VectorXd;  ///< of all loop cameras in their order, then the wheels

inline int rig_states(std::size_t cameras) {
  return static_cast<int>(cameras) * kCameraStates + kWheelStates;
}
inline int camera_state(int camera) { return camera * kCameraStates; }
inline int wheel_state(std::size_t cameras) { return static_cast<int>(cameras) * kCameraStates; }

/// The mounting that a camera's states make of the believed one.
Pose3 corrected(const Pose3& T_body_camera, const CameraCorrection& by);

/// The cameras as `state` corrects them; clocks aside, which are not the camera's.
LoopCameras corrected(const LoopCameras& believed, const RigState& state);

/// When the pictures of a keyframe were taken.
struct PictureTimes {
  Twist2 twist_body;           ///< of the body at the keyframe's instant,
  std::vector<double> late_s;  ///< after which each camera took its picture, by its stamp
};

/// The cameras as `state` corrects them, where the body's motion had taken each when it took its
/// picture, seen from the body at the keyframe's instant.
LoopCameras at_keyframe(const LoopCameras& believed, const RigState& state,
                        const PictureTimes& taken);

}  // namespace panoptes
