// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/mounting_fault.h"

#include <fmt/format.h>

namespace panoptes {

std::string mounting_fault(const Vec3& eye_body, const Body& body) {
  constexpr double kOnTop_m = 0.1;  // a camera that stands on the mast
  if (eye_body.z() <= 0) {
    return fmt::format("is mounted {:.3f} m below the floor; mount it above", -eye_body.z());
  }
  if (eye_body.z() > body.height_m + kOnTop_m) {
    return fmt::format(
        "is mounted {:.3f} m high, but the robot ends at {:.3f} m, and what hangs higher would "
        "pass through the camera; mount it lower, or correct the robot's height_m",
        eye_body.z(), body.height_m);
  }
  if (eye_body.head<2>().norm() > 2 * body.radius_m) {
    return fmt::format(
        "is mounted {:.3f} m from the robot's middle, but the robot reaches {:.3f} m: it would be "
        "farther out than the robot is wide, and what stands there would pass through it; mount "
        "it nearer, or correct the robot's radius_m",
        eye_body.head<2>().norm(), body.radius_m);
  }
  // Where its faces are known, they tell.
  if (!body.faces && eye_body.z() < body.hull_height_m &&
      eye_body.head<2>().norm() < body.radius_m) {
    return fmt::format(
        "is mounted inside the robot, whose hull is {:.3f} m high and reaches {:.3f} m from its "
        "middle; mount it above or farther out",
        body.hull_height_m, body.radius_m);
  }
  return {};
}

}  // namespace panoptes
