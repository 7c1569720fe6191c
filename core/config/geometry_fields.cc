// SPDX-License-Identifier: BSD-3-Clause
#include "core/config/geometry_fields.h"

#include <cmath>
#include <vector>

namespace panoptes {

void bind(Fields& f, Pose2& o) {
  f("x_m", o.x_m);
  f("y_m", o.y_m);
  f.angle("theta", o.theta_rad);
}

void bind(Fields& f, Pose3& o) {
  f("translation_m", o.translation);
  std::vector<double> wxyz{o.rotation.w(), o.rotation.x(), o.rotation.y(), o.rotation.z()};
  f("rotation_wxyz", wxyz);
  if (f.writing()) {
    return;
  }
  f.require(wxyz.size() == 4, "rotation_wxyz", "must be a list of 4 numbers");
  if (wxyz.size() != 4) {
    return;
  }
  const Eigen::Quaterniond read(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  // A few printed digits may be missing; what is off by no more than roundoff is kept to the bit.
  constexpr double kPrinted = 1e-3;
  constexpr double kRoundoff = 1e-12;
  const double error = std::abs(read.norm() - 1);
  f.require(error <= kPrinted, "rotation_wxyz", "must be a unit quaternion [w, x, y, z]");
  if (error <= kPrinted) {
    o.rotation = error <= kRoundoff ? read : read.normalized();
  }
}

void bind(Fields& f, BodyShape& o) {
  f.require(f.present("mesh"), "mesh", "missing; it must be given");
  f.path("mesh", o.mesh);
  o.mention = f.where("mesh");
  f("scale", o.scale, between(1e-6, 1e6));
  f.word("up", o.up, {{"usual", Up::kUsual}, {"y", Up::kY}, {"z", Up::kZ}});
  f("at_m", o.at_m);
  f.angle("yaw", o.yaw_rad);
}

void bind(Fields& f, Body& o) {
  f("radius_m", o.radius_m, between(0.01, 5));
  f("height_m", o.height_m, between(0.05, 5));
  f("hull_height_m", o.hull_height_m, between(0, 5));
  f("wheel_base_m", o.wheel_base_m, between(0.01, 5));
  f("wheel_radius_m", o.wheel_radius_m, between(0.001, 2));
  f("ticks_per_turn", o.ticks_per_turn, at_least(1));
  // From a snail to a racing car, on wheels.
  f("max_speed_mps", o.max_speed_mps, between(1e-3, 100));
  f("max_turn_radps", o.max_turn_radps, between(1e-3, 100));
  f("max_accel_mps2", o.max_accel_mps2, between(1e-3, 1000));
  f("max_turn_accel_radps2", o.max_turn_accel_radps2, between(1e-3, 1000));
  f("shape", o.shape);
}

}  // namespace panoptes
