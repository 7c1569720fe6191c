// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/calib/mono_filter.h"
#include "core/camera/rig.h"
#include "core/geometry/pose2.h"

namespace panoptes {

/// What wheels tell of a camera's motion (thesis 4.5): that of the body, by how the camera is
/// believed to be mounted. Wheels slip, the body tilts, and the mounting is known as `sigma` of
/// the camera says.
MotionTold camera_motion(const Pose2& T_before_now, const RigCamera& camera);

}  // namespace panoptes
