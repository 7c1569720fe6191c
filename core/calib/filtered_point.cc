// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/filtered_point.h"

#include <cmath>
#include <limits>

#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

Vec3 ray_by_azimuth(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad), 0,
          -std::cos(elevation_rad) * std::sin(azimuth_rad)};
}

Vec3 ray_by_elevation(double azimuth_rad, double elevation_rad) {
  return {-std::sin(elevation_rad) * std::sin(azimuth_rad), -std::cos(elevation_rad),
          -std::sin(elevation_rad) * std::cos(azimuth_rad)};
}

}  // namespace

Vec3 ray_of_angles(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::sin(azimuth_rad), -std::sin(elevation_rad),
          std::cos(elevation_rad) * std::cos(azimuth_rad)};
}

Vec3 FilteredPoint::p_map() const {
  if (!is_inverse_depth()) {
    return state;
  }
  if (state[5] <= 0) {
    return Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  return state.head<3>() + ray_of_angles(state[3], state[4]) / state[5];
}

FilteredPoint seen_point(const Vec3& from_map, const Vec3& direction_map,
                         double inverse_depth_per_m) {
  FilteredPoint point;
  point.state.resize(6);
  point.state.head<3>() = from_map;
  point.state[3] = std::atan2(direction_map.x(), direction_map.z());
  point.state[4] = std::atan2(-direction_map.y(), std::hypot(direction_map.x(), direction_map.z()));
  point.state[5] = inverse_depth_per_m;
  return point;
}

Eigen::Matrix<double, 2, 3> angles_by_direction(const Vec3& d) {
  const double across2 = d.x() * d.x() + d.z() * d.z();
  const double across = std::sqrt(across2);
  const double norm2 = d.squaredNorm();
  Eigen::Matrix<double, 2, 3> by;
  by << d.z() / across2, 0, -d.x() / across2,  //
      d.x() * d.y() / (norm2 * across), -across / norm2, d.z() * d.y() / (norm2 * across);
  return by;
}

PointOfRay point_of_ray(const FilteredPoint& point) {
  const double azimuth_rad = point.state[3];
  const double elevation_rad = point.state[4];
  const double depth_m = 1 / point.state[5];
  PointOfRay out;
  out.p_map = point.p_map();
  out.by_state.leftCols<3>().setIdentity();
  out.by_state.col(3) = depth_m * ray_by_azimuth(azimuth_rad, elevation_rad);
  out.by_state.col(4) = depth_m * ray_by_elevation(azimuth_rad, elevation_rad);
  out.by_state.col(5) = -depth_m * depth_m * ray_of_angles(azimuth_rad, elevation_rad);
  return out;
}

PointSeen seen_from(const Pose3& T_map_camera, const FilteredPoint& point) {
  const Mat3 R_camera_map = T_map_camera.rotation.conjugate().toRotationMatrix();
  const Vec3 from_map = point.state.head<3>() - T_map_camera.translation;
  PointSeen seen;
  seen.by_state.resize(3, point.state.size());
  double shift = 1;  // how much a metre is
  if (point.is_inverse_depth()) {
    shift = point.state[5];
    seen.p_camera =
        R_camera_map * (shift * from_map + ray_of_angles(point.state[3], point.state[4]));
    seen.by_state.col(3) = R_camera_map * ray_by_azimuth(point.state[3], point.state[4]);
    seen.by_state.col(4) = R_camera_map * ray_by_elevation(point.state[3], point.state[4]);
    seen.by_state.col(5) = R_camera_map * from_map;
  } else {
    seen.p_camera = R_camera_map * from_map;
  }
  seen.by_state.leftCols<3>() = shift * R_camera_map;
  seen.by_camera.leftCols<3>() = -shift * R_camera_map;
  seen.by_camera.rightCols<3>() = cross_matrix(seen.p_camera);
  return seen;
}

}  // namespace panoptes
