// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/body_faces.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/geometry/pose3.h"
#include "sim/world/mesh.h"
#include "sim/world/urdf.h"

namespace panoptes::sim {
namespace {

std::vector<Face> faces_of(const BodyShape& shape) {
  if (std::filesystem::path(shape.mesh).extension() == ".urdf") {
    if (shape.up != Up::kUsual) {
      throw ConfigError(shape.mention + ": up: in URDF z points up; leave `up` out");
    }
    return read_urdf(shape.mesh, shape.mention);
  }
  return read_faces(shape.mesh, shape.up, shape.mention);
}

}  // namespace

void read_body_faces(Body& body) {
  if (!body.shape) {
    return;
  }
  const BodyShape& shape = *body.shape;
  const Pose3 T_body_mesh = {Eigen::Quaterniond(Eigen::AngleAxisd(shape.yaw_rad, Vec3::UnitZ())),
                             shape.at_m};
  std::vector<Face> faces = faces_of(shape);
  double nearest_m = std::numeric_limits<double>::infinity();
  double highest_m = -nearest_m;
  for (Face& face : faces) {
    for (Vec3& corner : face) {
      corner = T_body_mesh * (shape.scale * corner);
      nearest_m = std::min(nearest_m, corner.head<2>().norm());
      highest_m = std::max(highest_m, corner.z());
    }
  }
  // A wrong unit, or an origin elsewhere, is what goes wrong.
  if (nearest_m > 2 * body.radius_m || highest_m < 0) {
    throw ConfigError(fmt::format(
        "{}: mesh '{}' is {:.3g} m from the middle of the robot's axle at the nearest and ends "
        "{:.3g} m above the floor; correct the shape's scale, up, at_m",
        shape.mention, shape.mesh, nearest_m, highest_m));
  }
  body.faces = std::make_shared<const std::vector<Face>>(std::move(faces));
}

}  // namespace panoptes::sim
