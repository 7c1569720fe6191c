// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/turning.h"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace panoptes {
namespace {

Vec3 axis_of_turns(const std::vector<StampedCamera>& path) {
  Mat3 sum = Mat3::Zero();
  for (const StampedCamera& at : path) {
    const Eigen::Quaterniond q =
        at.T_map_camera.rotation * path.front().T_map_camera.rotation.conjugate();
    const Vec3 sine = 2 * q.w() * q.vec();  // sin(angle) * axis
    sum += sine * sine.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(sum).eigenvectors().col(2);
}

}  // namespace

Turning Turning::reversed() const {
  Turning out{-axis_map, angle_rad};
  for (double& angle : out.angle_rad) {
    angle = -angle;
  }
  return out;
}

Turning turning_of(const std::vector<StampedCamera>& path) {
  Turning out;
  out.axis_map = axis_of_turns(path);
  for (const StampedCamera& at : path) {
    const Eigen::Quaterniond q =
        at.T_map_camera.rotation * path.front().T_map_camera.rotation.conjugate();
    const double angle = 2 * std::atan2(q.vec().dot(out.axis_map), q.w());
    const double before = out.angle_rad.empty() ? 0 : out.angle_rad.back();
    out.angle_rad.push_back(before + std::remainder(angle - before, 2 * std::numbers::pi));
  }
  return out;
}

}  // namespace panoptes
