// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "core/geometry/pose2.h"

namespace panoptes {

/// A rigid motion in space, metres and a unit quaternion. `T_a_b * p_b = p_a`.
struct Pose3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3 translation = Vec3::Zero();

  Pose3 inverse() const;
};

Pose3 operator*(const Pose3& T_a_b, const Pose3& T_b_c);
Vec3 operator*(const Pose3& T_a_b, const Vec3& p_b);

/// A pose on the floor, lifted into space: z up, turned about z.
Pose3 on_floor(const Pose2& T_a_b);

/// Where a camera looks along the floor, from straight ahead, counter-clockwise. Of one that looks
/// straight down or up: where the top or bottom of its picture points.
double floor_heading_rad(const Pose3& T_body_camera);

/// A camera (x right, y down, z forward) in its robot's body frame (x forward, y left, z up): at
/// `position_body`, its axis turned by `yaw_rad` from straight ahead (counter-clockwise seen from
/// above) and then by `tilt_rad` downwards; 0, 0 looks straight ahead along the floor.
Pose3 mounted_camera(const Vec3& position_body, double yaw_rad, double tilt_rad);

}  // namespace panoptes
