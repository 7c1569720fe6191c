// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/camera/rig.h"

namespace panoptes {

/// A rig as Kalibr's camchain.yaml: `cameras` as cam0, cam1, ..., each with T_cn_cnm1, the pose of
/// the one before as it sees it. `timeshift_cam_imu` is against the odometry's clock, where Kalibr
/// has an IMU's: what is added to a stamp. Kalibr has no k3: a comment says how much that is.
std::string kalibr_camchain(const Rig& rig, const std::vector<std::string>& cameras);

/// A camera's lens as ROS's camera_calibration_parsers read it; the picture is not rectified.
std::string ros_camera_info(const std::string& camera, const Intrinsics& lens);

/// A URDF robot of `base_link`, the body, and a fixed joint to `<camera>_optical_frame` (x right,
/// y down, z ahead) for each of `cameras`. xyz in metres; rpy turns about the fixed x, y and z, in
/// this order.
std::string urdf_of(const Rig& rig, const std::vector<std::string>& cameras);

}  // namespace panoptes
