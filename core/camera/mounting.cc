// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/mounting.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace panoptes {

void bind(Fields& f, MountingOffset& o) {
  const Rule turn = between(-std::numbers::pi, std::numbers::pi);
  const Rule shift = between(-1, 1);
  f.angle("roll", o.rotation_rad.x(), turn);
  f.angle("pitch", o.rotation_rad.y(), turn);
  f.angle("yaw", o.rotation_rad.z(), turn);
  f("x_m", o.shift_m.x(), shift);
  f("y_m", o.shift_m.y(), shift);
  f("z_m", o.shift_m.z(), shift);
}

Eigen::Quaterniond turned_by(const Vec3& turn_rad) {
  const double angle_rad = turn_rad.norm();
  return angle_rad > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad))
                       : Eigen::Quaterniond::Identity();
}

Pose3 displaced(const Pose3& T_body_camera, const MountingOffset& by) {
  Pose3 T = T_body_camera;
  if (!by.rotation_rad.isZero(0)) {
    const Eigen::Quaterniond turn = Eigen::AngleAxisd(by.rotation_rad.z(), Vec3::UnitZ()) *
                                    Eigen::AngleAxisd(by.rotation_rad.y(), Vec3::UnitY()) *
                                    Eigen::AngleAxisd(by.rotation_rad.x(), Vec3::UnitX());
    T.rotation = (turn * T.rotation).normalized();
  }
  T.translation += by.shift_m;
  return T;
}

MountingOffset mounting_offset(const Pose3& from_T_body_camera, const Pose3& to_T_body_camera) {
  const Mat3 turn =
      (to_T_body_camera.rotation * from_T_body_camera.rotation.conjugate()).toRotationMatrix();
  MountingOffset offset;
  offset.rotation_rad = {std::atan2(turn(2, 1), turn(2, 2)),
                         -std::asin(std::clamp(turn(2, 0), -1.0, 1.0)),
                         std::atan2(turn(1, 0), turn(0, 0))};
  offset.shift_m = to_T_body_camera.translation - from_T_body_camera.translation;
  return offset;
}

}  // namespace panoptes
