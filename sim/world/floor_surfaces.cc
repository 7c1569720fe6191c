// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/floor_surfaces.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <set>

#include "sim/world/layers.h"

namespace panoptes::sim {
namespace {

constexpr double kSample_m = 0.05;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The height of a face above a point; empty beside it.
std::optional<double> height_m(const std::array<Vec3, 3>& corners, const Vec2& p) {
  const Vec2 a = corners[0].head<2>();
  const Vec2 ab = corners[1].head<2>() - a;
  const Vec2 ac = corners[2].head<2>() - a;
  const double area = cross(ab, ac);
  const double b = cross(p - a, ac) / area;
  const double c = cross(ab, p - a) / area;
  if (b < 0 || c < 0 || b + c > 1) {
    return std::nullopt;
  }
  return corners[0].z() + b * (corners[1].z() - corners[0].z()) +
         c * (corners[2].z() - corners[0].z());
}

}  // namespace

FloorSurfaces::FloorSurfaces(const World& world) : has_sun_(world.sun.has_value()) {
  constexpr double kSliver_m2 = 1e-9;
  for (const Object& object : world.objects) {
    if (object.kind == Object::Kind::kPerson) {
      continue;
    }
    for (const Triangle& triangle : object.triangles) {
      Face face;
      face.texture = triangle.texture;
      for (std::size_t i = 0; i < 3; ++i) {
        face.corners_scene[i] = object.T_scene_object * triangle.corners[i].p_object;
      }
      const auto& [a, b, c] = face.corners_scene;
      if (std::max({a.z(), b.z(), c.z()}) > kFloorLayerTop_m ||
          cross((b - a).head<2>(), (c - a).head<2>()) < kSliver_m2) {
        continue;
      }
      face.low_scene = a.cwiseMin(b).cwiseMin(c).head<2>();
      face.high_scene = a.cwiseMax(b).cwiseMax(c).head<2>();
      low_scene_ = low_scene_.cwiseMin(face.low_scene);
      high_scene_ = high_scene_.cwiseMax(face.high_scene);
      faces_.push_back(face);
    }
  }
}

int FloorSurfaces::looks_within(double radius_m, const Vec2& p_scene) const {
  std::vector<const Face*> near;
  for (const Face& face : faces_) {
    const Vec2 nearest = p_scene.cwiseMax(face.low_scene).cwiseMin(face.high_scene);
    if ((nearest - p_scene).norm() <= radius_m) {
      near.push_back(&face);
    }
  }
  std::set<int> shown;
  const int reach = static_cast<int>(radius_m / kSample_m);
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const Vec2 offset = kSample_m * Vec2(i, j);
      if (offset.norm() > radius_m) {
        continue;
      }
      double highest_m = -std::numeric_limits<double>::infinity();
      const Face* seen = nullptr;
      for (const Face* face : near) {
        const std::optional<double> z_m = height_m(face->corners_scene, p_scene + offset);
        if (z_m && *z_m > highest_m) {
          highest_m = *z_m;
          seen = face;
        }
      }
      if (seen != nullptr) {
        shown.insert(seen->texture);
      }
    }
  }
  return static_cast<int>(shown.size()) * (has_sun_ ? 2 : 1);
}

}  // namespace panoptes::sim
