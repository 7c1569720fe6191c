// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/geometry/homography.h"
#include "core/geometry/pose3.h"

namespace panoptes {
namespace {

// The homography of a camera where the rig believes it to be: a ray meets z = 0 at
// c - c_z * (R ray) / (R ray)_z, which is linear in the ray but for the last division.
Mat3 mounted_homography(const RigCamera& camera) {
  const Mat3 R = camera.T_body_camera.rotation.toRotationMatrix();
  const Vec3 c = camera.T_body_camera.translation;
  Mat3 H_body_ray;
  H_body_ray.row(0) = c.z() * R.row(0) - c.x() * R.row(2);
  H_body_ray.row(1) = c.z() * R.row(1) - c.y() * R.row(2);
  H_body_ray.row(2) = -R.row(2);
  const Intrinsics& k = camera.intrinsics;
  Mat3 H_ray_px;
  H_ray_px << 1 / k.fx_px, 0, -k.cx_px / k.fx_px, 0, 1 / k.fy_px, -k.cy_px / k.fy_px, 0, 0, 1;
  return H_body_ray * H_ray_px;
}

Mat3 believed_homography(const RigCamera& camera) {
  const FloorView& view = *camera.floor;
  if (view.H_body_px) {
    return *view.H_body_px;
  }
  if (view.marks.empty()) {
    return mounted_homography(camera);
  }
  std::vector<PlanePair> pairs;
  for (const FloorMark& mark : view.marks) {
    pairs.push_back({mark.px, mark.p_body});
  }
  const HomographyFit fit = fit_homography(pairs);
  if (!fit.H_to_from) {
    throw ConfigError("floor.marks: do not give a homography: " + fit.fault +
                      "; four or more marks are needed, no three on a line");
  }
  return *fit.H_to_from;
}

// Where the camera of a homography is: K^-1 H^-1 holds the first two axes of its rotation and its
// translation up to scale (Zhang 2000).
Vec3 camera_of(const Mat3& H_view_px, const Intrinsics& k) {
  Mat3 K;
  K << k.fx_px, 0, k.cx_px, 0, k.fy_px, k.cy_px, 0, 0, 1;
  Mat3 G = K.inverse() * H_view_px.inverse();
  G *= 2 / (G.col(0).norm() + G.col(1).norm());
  Mat3 axes;
  axes << G.col(0), G.col(1), G.col(0).cross(G.col(1));
  const Eigen::JacobiSVD<Mat3> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 R_camera_view = svd.matrixU() * svd.matrixV().transpose();
  return -(R_camera_view.transpose() * G.col(2));
}

std::vector<Vec2> convex_hull(const std::vector<Vec2>& points) {
  std::vector<cv::Point2f> rounded;
  for (const Vec2& p : points) {
    rounded.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  std::vector<int> corners;
  cv::convexHull(rounded, corners);
  std::vector<Vec2> hull;
  for (const int corner : corners) {
    hull.push_back(points[static_cast<std::size_t>(corner)]);
  }
  return hull;
}

// Which pixels are mapped, and where they lie.
struct Mapped {
  Mat3 H_view_px;
  Mat3 H_px_view;
  int width = 0;
  int height = 0;
  int top_row = 0;
  double low_x = 0;
  double high_x = 0;

  // The pixel under a floor point; -1 when it is not mapped.
  std::int32_t pixel(const Vec2& p_view) const {
    if (p_view.x() < low_x || p_view.x() > high_x) {
      return -1;
    }
    const std::optional<Vec2> px = transfer(H_px_view, p_view);
    if (!px) {
      return -1;
    }
    const double u = std::round(px->x());
    const double v = std::round(px->y());
    if (!(u >= 0 && u < width && v >= top_row && v < height)) {
      return -1;
    }
    return static_cast<std::int32_t>(v) * width + static_cast<std::int32_t>(u);
  }
};

// The camera's picture over the floor that is to be mapped.
Mapped mapped_by(const RigCamera& camera, const Body& body, double heading_rad) {
  const FloorView& view = *camera.floor;
  const Intrinsics& k = camera.intrinsics;
  Mapped mapped;
  Mat3 H_view_body = Mat3::Identity();
  H_view_body.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-heading_rad).toRotationMatrix();
  mapped.H_view_px = H_view_body * believed_homography(camera);
  if (!(std::abs(mapped.H_view_px.determinant()) > 0) || !mapped.H_view_px.allFinite()) {
    throw ConfigError("floor.homography: is singular; must map pixels to floor points");
  }
  // the bottom of the picture is before the horizon, so there the third coordinate is positive
  const Vec3 bottom = mapped.H_view_px * Vec3(k.cx_px, k.height_px - 1.0, 1);
  mapped.H_view_px *= (bottom.z() > 0 ? 1 : -1) / mapped.H_view_px.norm();
  mapped.H_px_view = mapped.H_view_px.inverse();
  const Vec2 bottom_view = bottom.hnormalized();
  if ((mapped.H_px_view * bottom_view.homogeneous()).z() < 0) {
    mapped.H_px_view = -mapped.H_px_view;
  }
  mapped.width = k.width_px;
  mapped.height = k.height_px;
  mapped.top_row = view.rows == FloorView::Rows::kLowerHalf ? k.height_px / 2 : 0;
  mapped.low_x = body.radius_m + view.near_m;
  mapped.high_x = body.radius_m + view.far_m;
  return mapped;
}

// What the picture covers: directions and distances of the mapped pixels from the foot, and the box
// around them.
struct Covered {
  double az_low = std::numeric_limits<double>::infinity();
  double az_high = -std::numeric_limits<double>::infinity();
  double range_low = std::numeric_limits<double>::infinity();
  double range_high = 0;
  double x_low = std::numeric_limits<double>::infinity();
  double x_high = -std::numeric_limits<double>::infinity();
  double y_low = std::numeric_limits<double>::infinity();
  double y_high = -std::numeric_limits<double>::infinity();
};

Covered covered_by(const Mapped& mapped, const Vec2& foot_view) {
  Covered covered;
  for (int v = mapped.top_row; v < mapped.height; ++v) {
    for (int u = 0; u < mapped.width; ++u) {
      const std::optional<Vec2> p = transfer(mapped.H_view_px, Vec2(u, v));
      if (!p || p->x() < mapped.low_x || p->x() > mapped.high_x) {
        continue;
      }
      const Vec2 d = *p - foot_view;
      const double az = std::atan2(d.y(), d.x());
      covered.az_low = std::min(covered.az_low, az);
      covered.az_high = std::max(covered.az_high, az);
      covered.range_low = std::min(covered.range_low, d.norm());
      covered.range_high = std::max(covered.range_high, d.norm());
      covered.x_low = std::min(covered.x_low, p->x());
      covered.x_high = std::max(covered.x_high, p->x());
      covered.y_low = std::min(covered.y_low, p->y());
      covered.y_high = std::max(covered.y_high, p->y());
    }
  }
  if (!(covered.range_high > covered.range_low)) {
    throw ConfigError(
        "floor: the camera sees no floor between near_m and far_m before its horizon; tilt it down "
        "or correct its marks");
  }
  return covered;
}

// Length of floor along a direction that the pixel at `p` covers.
double depth_at(const Mapped& mapped, const Vec2& p, const Vec2& along) {
  const Vec3 a = mapped.H_px_view * p.homogeneous();
  const Vec3 b = mapped.H_px_view * Vec3(along.x(), along.y(), 0);
  const Vec2 px_per_m = (b.head<2>() - a.hnormalized() * b.z()) / a.z();
  return 1 / px_per_m.norm();
}

// Where the samples of a scan lie: on rays from the foot, at ranges.
struct Lattice {
  double az_low = 0;
  double az_step = 0;
  std::vector<double> ranges;
};

// One ray a pixel in the middle of the farthest row; samples a pixel apart along the middle ray,
// but no finer than three quarters of a cell.
Lattice lattice_of(const Mapped& mapped, const Covered& covered, FloorProjection& out) {
  const double az_middle = std::clamp(0.0, covered.az_low, covered.az_high);
  const Vec2 middle(std::cos(az_middle), std::sin(az_middle));
  const Vec2 farthest =
      out.foot_view + middle * std::min(covered.range_high, mapped.high_x - out.foot_view.x());
  const Vec2 sideways(-middle.y(), middle.x());
  Lattice lattice;
  lattice.az_low = covered.az_low;
  lattice.az_step = depth_at(mapped, farthest, sideways) / (farthest - out.foot_view).norm();
  out.first_ray_rad = lattice.az_low;
  out.ray_step_rad = lattice.az_step;
  out.rays = static_cast<int>(std::ceil((covered.az_high - covered.az_low) / lattice.az_step)) + 1;
  for (double r = covered.range_low; r <= covered.range_high;) {
    lattice.ranges.push_back(r);
    r += std::max(depth_at(mapped, out.foot_view + middle * r, middle), 0.75 * out.cell_m);
  }
  out.rows = static_cast<int>(lattice.ranges.size());
  PANOPTES_CHECK(out.rays < 32768 && out.rows < 32768, "a picture has few enough pixels");
  return lattice;
}

void fill_samples(const Mapped& mapped, const Lattice& lattice, FloorProjection& out) {
  const auto samples = static_cast<std::size_t>(out.rays) * static_cast<std::size_t>(out.rows);
  out.pixel.assign(samples, -1);
  out.range_m.assign(samples, 0);
  out.depth_m.assign(samples, 0);
  out.weight.assign(samples, 0);
  for (int ray = 0; ray < out.rays; ++ray) {
    const double az = lattice.az_low + ray * lattice.az_step;
    const Vec2 along(std::cos(az), std::sin(az));
    for (int row = 0; row < out.rows; ++row) {
      const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(out.rays) +
                            static_cast<std::size_t>(ray);
      const double r = lattice.ranges[static_cast<std::size_t>(row)];
      const Vec2 p = out.foot_view + along * r;
      out.range_m[i] = static_cast<float>(r);
      out.pixel[i] = mapped.pixel(p);
      if (out.pixel[i] >= 0) {
        const double depth = depth_at(mapped, p, along);
        out.depth_m[i] = static_cast<float>(depth);
        out.weight[i] = static_cast<std::uint8_t>(
            std::lround(FloorProjection::kFullWeight * std::min(1.0, out.cell_m / depth)));
      }
    }
  }
}

// The sample under a point of the floor; -1 where the picture does not show it.
int sample_under(const Mapped& mapped, const Lattice& lattice, const FloorProjection& out,
                 const Vec2& p) {
  if (mapped.pixel(p) < 0) {
    return -1;
  }
  const std::vector<double>& ranges = lattice.ranges;
  const Vec2 d = p - out.foot_view;
  const int ray =
      static_cast<int>(std::lround((std::atan2(d.y(), d.x()) - lattice.az_low) / lattice.az_step));
  const double range = d.norm();
  int row =
      static_cast<int>(std::lower_bound(ranges.begin(), ranges.end(), range) - ranges.begin());
  row = std::min(row, out.rows - 1);
  if (row > 0 && range - ranges[static_cast<std::size_t>(row) - 1] <
                     ranges[static_cast<std::size_t>(row)] - range) {
    --row;
  }
  const int i = row * out.rays + std::clamp(ray, 0, out.rays - 1);
  return out.pixel[static_cast<std::size_t>(i)] < 0 ? -1 : i;
}

// The raster of cells, and the outline of what is mapped.
void fill_cells(const Mapped& mapped, const Covered& covered, const Lattice& lattice,
                FloorProjection& out) {
  const double cell_m = out.cell_m;
  const double column_low = std::floor(covered.x_low / cell_m);
  const double row_low = std::floor(covered.y_low / cell_m);
  out.origin_view = cell_m * Vec2(column_low, row_low);
  out.cell_columns = static_cast<int>(std::ceil(covered.x_high / cell_m) - column_low);
  out.cell_rows = static_cast<int>(std::ceil(covered.y_high / cell_m) - row_low);
  out.sample.assign(
      static_cast<std::size_t>(out.cell_columns) * static_cast<std::size_t>(out.cell_rows), -1);
  std::vector<Vec2> corners;
  double nearest_ahead = std::numeric_limits<double>::infinity();
  for (int r = 0; r < out.cell_rows; ++r) {
    int first = -1;
    int last = -1;
    for (int column = 0; column < out.cell_columns; ++column) {
      const Vec2 p = out.origin_view + cell_m * Vec2(column + 0.5, r + 0.5);
      const int i = sample_under(mapped, lattice, out, p);
      if (i < 0) {
        continue;
      }
      out.sample[static_cast<std::size_t>(r) * static_cast<std::size_t>(out.cell_columns) +
                 static_cast<std::size_t>(column)] = i;
      first = first < 0 ? column : first;
      last = column;
      if (std::abs(p.y()) <= 0.1) {
        nearest_ahead = std::min(nearest_ahead, p.x() - cell_m / 2);
      }
    }
    if (first >= 0) {
      for (const int column : {first, last + 1}) {
        corners.push_back(out.origin_view + cell_m * Vec2(column, r));
        corners.push_back(out.origin_view + cell_m * Vec2(column, r + 1));
      }
    }
  }
  if (corners.empty()) {
    throw ConfigError("floor: no cell of the floor between near_m and far_m lies in the picture");
  }
  out.outline_view = convex_hull(corners);
  out.front_m = std::isfinite(nearest_ahead) ? nearest_ahead : covered.x_low;
}

}  // namespace

FloorProjection project_floor(const RigCamera& camera, const Body& body, double cell_m) {
  if (!camera.floor) {
    throw ConfigError("floor: a floor camera needs to say which part of its picture is mapped");
  }
  const Intrinsics& k = camera.intrinsics;
  PANOPTES_CHECK(k.fx_px > 0 && k.fy_px > 0 && cell_m > 0, "a floor camera has a focal length");
  const double heading_rad = floor_heading_rad(camera.T_body_camera);
  const Mapped mapped = mapped_by(camera, body, heading_rad);
  FloorProjection out;
  out.T_body_view = {0, 0, heading_rad};
  out.H_view_px = mapped.H_view_px;
  out.cell_m = cell_m;
  const Vec3 c = camera_of(mapped.H_view_px, k);
  out.foot_view = c.head<2>();
  out.height_m = std::abs(c.z());
  const Covered covered = covered_by(mapped, out.foot_view);
  const Lattice lattice = lattice_of(mapped, covered, out);
  fill_samples(mapped, lattice, out);
  fill_cells(mapped, covered, lattice, out);
  out.blind_zone_m = out.front_m - body.radius_m;
  return out;
}

}  // namespace panoptes
