// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A point as the filter holds it: six numbers where its depth is little known, three after that
/// (Civera, Davison and Montiel 2008).
struct FilteredPoint {
  /// x, y, z of the camera that saw it first, azimuth, elevation and inverse depth (1/m) of the ray
  /// from there: all in `map`, azimuth from z to x, elevation up against y. Or x, y, z of the
  /// point.
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> state;

  bool is_inverse_depth() const { return state.size() == 6; }

  /// Metres; a point of no inverse depth, or one behind where it was seen from, has none.
  Vec3 p_map() const;
};

/// The ray that an azimuth and an elevation stand for.
Vec3 ray_of_angles(double azimuth_rad, double elevation_rad);

/// A point seen in `direction_map` (any length) from `from_map`.
FilteredPoint seen_point(const Vec3& from_map, const Vec3& direction_map,
                         double inverse_depth_per_m);

/// How azimuth and elevation change with a ray's direction, any length.
Eigen::Matrix<double, 2, 3> angles_by_direction(const Vec3& direction);

/// The same point by x, y, z, and how that changes with its six numbers.
struct PointOfRay {
  Vec3 p_map = Vec3::Zero();
  Eigen::Matrix<double, 3, 6> by_state;
};
PointOfRay point_of_ray(const FilteredPoint& point);

/// Where a camera sees a point: `p_camera` is known up to a positive factor.
struct PointSeen {
  Vec3 p_camera = Vec3::Zero();
  /// By the camera's shift (in map) and turn (about its own axes), and by the point's numbers.
  Eigen::Matrix<double, 3, 6> by_camera;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6> by_state;
};
PointSeen seen_from(const Pose3& T_map_camera, const FilteredPoint& point);

}  // namespace panoptes
