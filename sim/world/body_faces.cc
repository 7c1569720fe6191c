// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/body_faces.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/geometry/pose3.h"
#include "sim/world/mesh.h"
#include "sim/world/urdf.h"

namespace panoptes::sim {
namespace {

constexpr std::size_t kMostFaces = 50'000;  // each is looked at for every camera of every rig
constexpr double kOffMost = 4;              // times the robot's own radius, either way

/// In the mesh's own frame, metres.
std::vector<Face> faces_of(const BodyShape& shape) {
  if (format_of(shape.mesh) != ".urdf") {
    return read_faces(shape.mesh, shape.scale, shape.up, shape.mention);
  }
  if (shape.up != Up::kUsual) {
    throw ConfigError(shape.mention + ": up: in URDF z points up; leave `up` out");
  }
  std::vector<Face> faces = read_urdf(shape.mesh, shape.mention);
  for (Face& face : faces) {
    for (Vec3& corner : face) {
      corner *= shape.scale;
    }
  }
  return faces;
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
  if (faces.size() > kMostFaces) {
    throw ConfigError(fmt::format(
        "{}: mesh '{}' has {} triangles; a robot's shape takes {}: make it coarser (Blender: "
        "Decimate)",
        shape.mention, shape.mesh, faces.size(), kMostFaces));
  }
  double reach_m = 0;
  double highest_m = -std::numeric_limits<double>::infinity();
  for (Face& face : faces) {
    for (Vec3& corner : face) {
      corner = T_body_mesh * corner;
      reach_m = std::max(reach_m, corner.head<2>().norm());
      highest_m = std::max(highest_m, corner.z());
    }
  }
  // A wrong unit, or an origin elsewhere, is what goes wrong.
  if (reach_m > kOffMost * body.radius_m || reach_m < body.radius_m / kOffMost || highest_m < 0) {
    throw ConfigError(fmt::format(
        "{}: mesh '{}' reaches {:.3g} m from the middle of the robot's axle and ends {:.3g} m "
        "above the floor, but the robot's radius_m is {:.3g}; correct the shape's scale, up, at_m",
        shape.mention, shape.mesh, reach_m, highest_m, body.radius_m));
  }
  body.faces = std::make_shared<const std::vector<Face>>(std::move(faces));
}

}  // namespace panoptes::sim
