// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/rig_sight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/camera/mounting_fault.h"
#include "core/camera/rectify.h"

namespace panoptes {
namespace {

constexpr double kFar_m = 1000;  // for what is farther, where a camera sits on the robot is nothing
constexpr int kColumns = 24;     // of the coarse grid of pixels
constexpr int kRows = 18;
// Of optical centres. A housing is 3 cm wide (a Flea2, thesis chapter 3).
constexpr double kClosest_m = 0.02;

double distance_from_middle(const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double length2 = d.squaredNorm();
  const double s = length2 > 0 ? std::clamp(-a.dot(d) / length2, 0.0, 1.0) : 0.0;
  return (a + s * d).norm();
}

/// The cosine of how far off the axis the picture reaches at most, with some room.
double widest_cos(const Intrinsics& lens) {
  double least = 1;
  const auto reach = [&](double u, double v) {
    const std::optional<Vec3> d = lens.direction({u, v});
    least = d ? std::min(least, d->normalized().z()) : -1.0;
  };
  constexpr int kSteps = 16;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = -0.5 + lens.width_px * static_cast<double>(i) / kSteps;
    const double v = -0.5 + lens.height_px * static_cast<double>(i) / kSteps;
    reach(u, -0.5);
    reach(u, lens.height_px - 0.5);
    reach(-0.5, v);
    reach(lens.width_px - 0.5, v);
  }
  constexpr double kRoom = 0.01;
  return std::max(-1.0, least - kRoom);
}

/// Any floor at all in the part of its picture that is mapped.
bool maps_some(const CameraSight& sight, const Body& body) {
  constexpr double kFinest_m = 0.02;
  constexpr double kStep = 0.01;  // of the distance
  constexpr int kHeadings = 120;
  const double farthest_m = 2 * (body.radius_m + sight.camera().floor->far_m);
  for (double r = body.radius_m; r <= farthest_m; r += std::max(kFinest_m, kStep * r)) {
    for (int k = 0; k < kHeadings; ++k) {
      const double angle = 2 * std::numbers::pi * k / kHeadings;
      if (sight.maps({r * std::cos(angle), r * std::sin(angle)})) {
        return true;
      }
    }
  }
  return false;
}

/// What is wrong with one camera by itself; empty when nothing is.
std::string camera_fault(const RigCamera& camera, const Body& body) {
  if (std::string fault = mounting_fault(camera.T_body_camera.translation, body); !fault.empty()) {
    return fault;
  }
  if (body.faces && inside_hull(*body.faces, camera.T_body_camera.translation)) {
    return "is mounted inside the robot's shape, of which 3 cm about it are taken for its housing; "
           "mount it outside, take what is around it out of the mesh, or correct the shape's at_m";
  }
  const CameraSight sight(camera, body);
  constexpr double kAll = 0.995;
  if (sight.hull_share() > kAll) {
    return "sees nothing but the robot's own hull; turn it outwards or mount it nearer to the edge";
  }
  if (camera.has_role("floor") && !maps_some(sight, body)) {
    return fmt::format(
        "has the role floor and sees no floor from {} to {} m before the body; tilt it down, or "
        "correct floor.near_m and floor.far_m",
        camera.floor->near_m, camera.floor->far_m);
  }
  return {};
}

}  // namespace

bool hidden_by_hull(const Body& body, const Vec3& eye_body, const Vec3& p_body) {
  const double top = body.hull_height_m;
  if (eye_body.z() >= top && p_body.z() >= top) {
    return false;
  }
  Vec2 from = eye_body.head<2>();
  Vec2 to = p_body.head<2>();
  if (eye_body.z() > top || p_body.z() > top) {
    const double s = (eye_body.z() - top) / (eye_body.z() - p_body.z());
    const Vec2 at_top = from + s * (to - from);
    (eye_body.z() > top ? from : to) = at_top;
  }
  return distance_from_middle(from, to) < body.radius_m;
}

CameraSight::CameraSight(const RigCamera& camera, const Body& body)
    : camera_(camera),
      mapped_lens_(camera.intrinsics),
      R_camera_body_(camera.T_body_camera.rotation.conjugate().toRotationMatrix()),
      body_(body),
      shadow_(body.faces ? std::make_shared<const HullShadow>(*body.faces, eye_body()) : nullptr),
      widest_cos_(widest_cos(camera.intrinsics)) {
  const double heading_rad = floor_heading_rad(camera.T_body_camera);
  heading_ = {std::cos(heading_rad), std::sin(heading_rad)};
  if (camera.has_role("floor") && !camera.intrinsics.is_pinhole()) {
    mapped_lens_ = rectified(camera.intrinsics);
  }
  int hull = 0;
  int floor = 0;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Vec2 px((column + 0.5) * camera.intrinsics.width_px / kColumns - 0.5,
                    (row + 0.5) * camera.intrinsics.height_px / kRows - 0.5);
      const std::optional<Vec3> direction = direction_body(px);
      if (!direction) {
        continue;
      }
      const bool down = direction->z() < 0;
      const double length_m = down ? std::min(kFar_m, eye_body().z() / -direction->z()) : kFar_m;
      const bool hits = hidden(eye_body() + length_m * *direction);
      hull += hits ? 1 : 0;
      floor += !hits && down ? 1 : 0;
    }
  }
  hull_share_ = static_cast<double>(hull) / (kRows * kColumns);
  floor_share_ = static_cast<double>(floor) / (kRows * kColumns);
}

Vec3 CameraSight::in_camera(const Vec3& p_body) const {
  return R_camera_body_ * (p_body - eye_body());
}

bool CameraSight::hidden(const Vec3& p_body) const {
  return shadow_ ? shadow_->hides(p_body) : hidden_by_hull(body_, eye_body(), p_body);
}

bool CameraSight::sees(const Vec3& p_body) const {
  const Vec3 p_camera = in_camera(p_body);
  return p_camera.z() >= widest_cos_ * p_camera.norm() && camera_.intrinsics.sees(p_camera) &&
         !hidden(p_body);
}

bool CameraSight::sees_direction(const Vec3& direction_body) const {
  const Vec3 d_camera = R_camera_body_ * direction_body;
  return d_camera.z() >= widest_cos_ * d_camera.norm() && camera_.intrinsics.sees(d_camera) &&
         !hidden(eye_body() + kFar_m * direction_body);
}

bool CameraSight::maps(const Vec2& p_body) const {
  if (!camera_.floor || !camera_.has_role("floor")) {
    return false;
  }
  const FloorView& view = *camera_.floor;
  const double ahead_m = p_body.dot(heading_) - body_.radius_m;
  const Vec3 p_floor(p_body.x(), p_body.y(), 0);
  if (ahead_m < view.near_m || ahead_m > view.far_m) {
    return false;
  }
  const Vec3 p_camera = in_camera(p_floor);
  if (p_camera.z() < widest_cos_ * p_camera.norm() || !mapped_lens_.sees(p_camera) ||
      hidden(p_floor)) {
    return false;
  }
  const double first_row =
      view.rows == FloorView::Rows::kLowerHalf ? camera_.intrinsics.height_px / 2 - 0.5 : -0.5;
  return mapped_lens_.project(p_camera).y() >= first_row;
}

std::optional<Vec3> CameraSight::direction_body(const Vec2& px) const {
  const std::optional<Vec3> d_camera = camera_.intrinsics.direction(px);
  if (!d_camera) {
    return std::nullopt;
  }
  return R_camera_body_.transpose() * d_camera->normalized();
}

Eigen::Matrix2d CameraSight::px_per_m(const Vec3& p_body, const Vec3& along_a,
                                      const Vec3& along_b) const {
  constexpr double kStep_m = 1e-4;
  const Vec3 p_camera = in_camera(p_body);
  const Vec2 px = camera_.intrinsics.project(p_camera);
  Eigen::Matrix2d J;
  J.col(0) = camera_.intrinsics.project(p_camera + kStep_m * (R_camera_body_ * along_a)) - px;
  J.col(1) = camera_.intrinsics.project(p_camera + kStep_m * (R_camera_body_ * along_b)) - px;
  return J / kStep_m;
}

double CameraSight::sampling_m(const Vec2& p_body) const {
  const Eigen::Matrix2d J = px_per_m({p_body.x(), p_body.y(), 0}, Vec3::UnitX(), Vec3::UnitY());
  // the smaller singular value of a 2 x 2 matrix
  const double half_sum = 0.5 * J.squaredNorm();
  const double det = std::abs(J.determinant());
  const double larger2 = half_sum + std::sqrt(std::max(0.0, half_sum * half_sum - det * det));
  return std::sqrt(larger2) / det;
}

RigSight::RigSight(const Rig& rig, const Body& body) : body_(body) {
  PANOPTES_CHECK(rig.cameras.size() <= kMostSightCameras, "a set of cameras holds 64");
  for (const auto& [name, camera] : rig.cameras) {
    const CameraSet bit = camera_bit(names_.size());
    loop_cameras_ |= camera.is_loop() ? bit : 0;
    floor_cameras_ |= camera.has_role("floor") ? bit : 0;
    names_.push_back(name);
    cameras_.emplace_back(camera, body);
  }
}

CameraSet RigSight::seeing(const Vec3& p_body) const {
  CameraSet set = 0;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    set |= cameras_[i].sees(p_body) ? camera_bit(i) : 0;
  }
  return set;
}

CameraSet RigSight::seeing_direction(const Vec3& direction_body) const {
  CameraSet set = 0;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    set |= cameras_[i].sees_direction(direction_body) ? camera_bit(i) : 0;
  }
  return set;
}

CameraSet RigSight::mapping(const Vec2& p_body) const {
  CameraSet set = 0;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    set |= cameras_[i].maps(p_body) ? camera_bit(i) : 0;
  }
  return set;
}

std::vector<std::string> placement_faults(const Rig& rig, const Body& body) {
  if (rig.cameras.empty()) {
    return {"cameras: must have one at least"};
  }
  if (rig.cameras.size() > kMostSightCameras) {
    return {
        fmt::format("cameras: must be {} at most, got {}", kMostSightCameras, rig.cameras.size())};
  }
  std::vector<std::string> faults;
  for (auto at = rig.cameras.begin(); at != rig.cameras.end(); ++at) {
    std::string fault = camera_fault(at->second, body);
    for (auto other = rig.cameras.begin(); other != at && fault.empty(); ++other) {
      const double apart_m =
          (other->second.T_body_camera.translation - at->second.T_body_camera.translation).norm();
      if (apart_m < kClosest_m) {
        fault = fmt::format(
            "has its centre {:.0f} mm from that of {}, in whose housing it would "
            "be; mount them {:.0f} mm apart or more",
            1000 * apart_m, other->first, 1000 * kClosest_m);
      }
    }
    if (!fault.empty()) {
      faults.push_back("cameras." + at->first + ": " + fault);
    }
  }
  return faults;
}

}  // namespace panoptes
