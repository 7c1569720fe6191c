// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose2.h"

namespace panoptes {

/// Which axis of a mesh points up. glTF and DAE say it themselves, and OBJ and 3DS come out of
/// assimp with y up; PLY, STL and OFF, which come from scanners and workshops, have z up. With y
/// up, (x, y, z) there is (x, -z, y) here.
enum class Up { kUsual, kY, kZ };

/// A flat piece of a surface, by its corners.
using Face = std::array<Vec3, 3>;

/// The shape of a robot for its cameras to look past, where a cylinder does not do.
struct BodyShape {
  std::string mesh;          ///< a robot as URDF, or any mesh that assimp reads
  double scale = 1;          ///< on the lengths in it
  Up up = Up::kUsual;        ///< its axis that points up here, where its format does not say
  Vec3 at_m = Vec3::Zero();  ///< in `body`: where its origin is
  double yaw_rad = 0;        ///< from `body` ahead to its x axis, to the left

  std::string mention;  ///< file:line:column of its mesh
};

/// What the robot believes of its own body: a disc about the middle of the wheel axle, driven by
/// two wheels on that axle. The defaults are a Pioneer P3-DX with a camera mast.
struct Body {
  double radius_m = 0.25;
  double height_m = 0.8;        ///< top of the mast
  double hull_height_m = 0.24;  ///< top of the hull that the mast stands on
  double wheel_base_m = 0.33;   ///< between the wheels' points of contact
  double wheel_radius_m = 0.0975;
  int ticks_per_turn = 500;
  double max_speed_mps = 0.6;
  double max_turn_radps = 1.5;
  double max_accel_mps2 = 0.6;
  double max_turn_accel_radps2 = 3.0;
  std::optional<BodyShape> shape;
  /// Of the shape's mesh, in `body`, once it has been read (sim/world/body_faces.h).
  std::shared_ptr<const std::vector<Face>> faces;
};

}  // namespace panoptes
