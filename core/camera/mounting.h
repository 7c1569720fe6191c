// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/config/fields.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// By how much a camera is mounted otherwise than it is said to be: turned about its optical
/// centre, about axes that lie as the body's do, first by roll about x, then by pitch about y, then
/// by yaw about z, and shifted along them. So pitch turns down what looks ahead and up what looks
/// back.
struct MountingOffset {
  Vec3 rotation_rad = Vec3::Zero();  ///< roll, pitch, yaw
  Vec3 shift_m = Vec3::Zero();       ///< in body
};
/// {roll_deg, pitch_deg, yaw_deg, x_m, y_m, z_m}
void bind(Fields& f, MountingOffset& o);

/// Exp(turn_rad): about its direction by its length; the identity of none.
Eigen::Quaterniond turned_by(const Vec3& turn_rad);

/// The mounting that is off the given one by so much; the same bits where that is nothing.
Pose3 displaced(const Pose3& T_body_camera, const MountingOffset& by);

/// What leads from one mounting to the other. Pitch is from -90 to 90 degrees.
MountingOffset mounting_offset(const Pose3& from_T_body_camera, const Pose3& to_T_body_camera);

}  // namespace panoptes
