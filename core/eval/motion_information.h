// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/eval/rig_sight.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// What is assumed of the features that a rig's pictures show of a motion.
struct MotionInformationOptions {
  Vec3 room_m{5.5, 5.5, 2.6};        ///< length, width, height; the robot stands in the middle
  int features = 150;                ///< a camera, spread evenly over its picture
  double feature_sigma_px = 0.5;     ///< of where one is seen in a picture, each way
  double drive_m = 0.25;             ///< straight ahead, between two pictures,
  double turn_rad = deg_to_rad(15);  ///< or on the spot
};

/// The Fisher information that two pictures of each camera have of a planar motion between them:
/// x ahead (m), y to the left (m), heading (rad), in `body` before it.
struct MotionInformation {
  std::vector<Mat3> of_camera;  ///< in the order of the rig; zero where it has no role that shows
                                ///< motion
  Mat3 of(CameraSet cameras) const;
};

/// One sigma of what is known of a motion. A direction that the pictures do not show is empty: no
/// single camera tells lengths, unless it sees the floor.
struct MotionSigma {
  std::optional<double> ahead_m;
  std::optional<double> aside_m;
  std::optional<double> heading_rad;
};
MotionSigma motion_sigma(const Mat3& information);

/// Of cameras with a loop_ or stereo_ role, features on walls, floor and ceiling, whose depths are
/// unknown and taken out (so two cameras that see the same count as strangers); of cameras with the
/// role floor, features where they map it, whose places their homography tells.
MotionInformation motion_information(const MotionInformationOptions& options, const RigSight& sight,
                                     const Pose2& T_body_after);

}  // namespace panoptes
