// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A camera that recognises places, as the robot believes it to be.
struct LoopCamera {
  std::string name;   ///< in the rig
  std::string looks;  ///< where its role says: front, back, left
  Intrinsics intrinsics;
  Pose3 T_body_camera;
  double clock_offset_s = 0;  ///< by which its stamps are believed to be late
  CameraSigmas sigma = {};    ///< of all of these

  /// Steeply upwards or downwards: it sees much the same whichever way the body has turned, and
  /// its picture turns with it.
  bool looks_steeply() const;
};
using LoopCameras = std::vector<LoopCamera>;  ///< front, back, then any others

/// The cameras whose roles begin with loop_: loop_front, loop_back, then all others in the order of
/// their roles. ConfigError where there is none.
LoopCameras loop_cameras(const Rig& rig);

/// Two cameras, of which one shows at one place what the other shows at another.
struct CameraPair {
  int a = 0;
  int b = 0;
  bool turned = false;  ///< both pictures by another angle about the vertical

  friend bool operator==(const CameraPair&, const CameraPair&) = default;
};

/// How a body that is back at a place may stand, so that cameras show again what was seen.
struct Facing {
  double turn_rad = 0;            ///< its heading now less that of before
  std::vector<CameraPair> pairs;  ///< a: the camera that showed it before, b: the one that does now
};

/// Each camera with itself: the same heading.
Facing same_facing(const LoopCameras& cameras);

/// All facings, the same heading first, the opposite one, where there is one, second. Cameras that
/// look level see the same where the headings of their axes then differ by less than a quarter of
/// what the narrower one sees; a camera that looks steeply is paired with itself in each.
std::vector<Facing> facings(const LoopCameras& cameras);

}  // namespace panoptes
