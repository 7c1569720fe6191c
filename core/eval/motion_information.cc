// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/motion_information.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace panoptes {
namespace {

constexpr int kColumns = 12;
constexpr int kRows = 9;
constexpr double kNearest_m = 0.3;  // nothing that is mapped is nearer to a camera

/// How far the box around the room is in a direction.
double wall_m(const Vec3& room_m, const Vec3& eye_body, const Vec3& direction) {
  const Vec3 low(-room_m.x() / 2, -room_m.y() / 2, 0);
  const Vec3 high(room_m.x() / 2, room_m.y() / 2, room_m.z());
  double nearest_m = room_m.norm();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] != 0) {
      const double to = direction[axis] > 0 ? high[axis] : low[axis];
      nearest_m = std::min(nearest_m, (to - eye_body[axis]) / direction[axis]);
    }
  }
  return std::max(nearest_m, kNearest_m);
}

bool shows_motion(const RigCamera& camera) {
  return camera.is_loop() ||
         std::any_of(camera.roles.begin(), camera.roles.end(),
                     [](const std::string& role) { return role.starts_with("stereo_"); });
}

Pose2 plus(const Pose2& T, const Vec3& change) {
  return {T.x_m + change.x(), T.y_m + change.y(), T.theta_rad + change.z()};
}

/// Where a point shows after the motion.
Vec2 seen_at(const CameraSight& camera, const Pose2& T_body_after, const Vec3& p_body) {
  const Vec2 p_after = T_body_after.inverse() * Vec2(p_body.head<2>());
  return camera.camera().intrinsics.project(
      camera.in_camera({p_after.x(), p_after.y(), p_body.z()}));
}

/// How the place in the picture changes with the motion.
Eigen::Matrix<double, 2, 3> by_motion(const CameraSight& camera, const Pose2& T_body_after,
                                      const Vec3& p_body) {
  constexpr double kStep = 1e-5;  // metres and radians
  Eigen::Matrix<double, 2, 3> J;
  for (int i = 0; i < 3; ++i) {
    const Vec3 step = kStep * Vec3::Unit(i);
    J.col(i) = (seen_at(camera, plus(T_body_after, step), p_body) -
                seen_at(camera, plus(T_body_after, -step), p_body)) /
               (2 * kStep);
  }
  return J;
}

/// The same with the inverse depth.
Vec2 by_inverse_depth(const CameraSight& camera, const Pose2& T_body_after, const Vec3& direction,
                      double inverse_depth) {
  const double step = 1e-4 * inverse_depth;
  const auto at = [&](double inverse) {
    return seen_at(camera, T_body_after, camera.eye_body() + direction / inverse);
  };
  return (at(inverse_depth + step) - at(inverse_depth - step)) / (2 * step);
}

}  // namespace

Mat3 MotionInformation::of(CameraSet cameras) const {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < of_camera.size(); ++i) {
    if ((cameras & camera_bit(i)) != 0) {
      sum += of_camera[i];
    }
  }
  return sum;
}

MotionSigma motion_sigma(const Mat3& information) {
  // Whatever nothing shows has this sigma, and is seen by that.
  constexpr double kUnknown = 100;  // metres and radians
  constexpr double kKnown = 1;
  const Mat3 covariance = (information + Mat3::Identity() / (kUnknown * kUnknown)).inverse();
  const auto sigma = [&](int i) -> std::optional<double> {
    const double value = std::sqrt(std::max(0.0, covariance(i, i)));
    return value < kKnown ? std::optional(value) : std::nullopt;
  };
  return {sigma(0), sigma(1), sigma(2)};
}

MotionInformation motion_information(const MotionInformationOptions& options, const RigSight& sight,
                                     const Pose2& T_body_after) {
  MotionInformation out;
  // both pictures say where a feature is
  const double variance_px2 = 2 * options.feature_sigma_px * options.feature_sigma_px;
  const double weight = static_cast<double>(options.features) / (kColumns * kRows) / variance_px2;
  for (const CameraSight& camera : sight.cameras()) {
    Mat3 information = Mat3::Zero();
    const Intrinsics& lens = camera.camera().intrinsics;
    const bool by_features = shows_motion(camera.camera());
    const bool by_floor = camera.camera().has_role("floor");
    for (int cell = 0; (by_features || by_floor) && cell < kColumns * kRows; ++cell) {
      const Vec2 px((cell % kColumns + 0.5) * lens.width_px / kColumns - 0.5,
                    (cell / kColumns + 0.5) * lens.height_px / kRows - 0.5);
      const std::optional<Vec3> direction = camera.direction_body(px);
      if (!direction) {
        continue;
      }
      const double depth_m = wall_m(options.room_m, camera.eye_body(), *direction);
      const Vec3 p_body = camera.eye_body() + depth_m * *direction;
      const Vec2 p_after = T_body_after.inverse() * Vec2(p_body.head<2>());
      if (!camera.sees(p_body) || !camera.sees({p_after.x(), p_after.y(), p_body.z()})) {
        continue;
      }
      constexpr double kOnFloor_m = 1e-6;
      const bool place_known =
          by_floor && std::abs(p_body.z()) < kOnFloor_m && camera.maps(p_body.head<2>());
      if (!place_known && !by_features) {
        continue;
      }
      const Eigen::Matrix<double, 2, 3> J = by_motion(camera, T_body_after, p_body);
      Mat2 free = Mat2::Identity();
      if (!place_known) {
        // Where depth moves the feature by less than the noise, it need not be known.
        const Vec2 d = by_inverse_depth(camera, T_body_after, *direction, 1 / depth_m);
        if (d.norm() / kNearest_m > std::sqrt(variance_px2)) {
          free -= d * d.transpose() / d.squaredNorm();
        }
      }
      information += weight * J.transpose() * free * J;
    }
    out.of_camera.push_back(information);
  }
  return out;
}

}  // namespace panoptes
