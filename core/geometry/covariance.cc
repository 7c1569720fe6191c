// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/covariance.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace panoptes {

Mat3 unknown_covariance() {
  return Vec3::Constant(std::numeric_limits<double>::infinity()).asDiagonal();
}

std::optional<Mat3> inverse_of(const Mat3& covariance) {
  // the decomposition reads the lower half alone and takes what is no number for positive
  if (!covariance.allFinite() || Eigen::LLT<Mat3>(covariance).info() != Eigen::Success) {
    return std::nullopt;
  }
  const Mat3 inverse = covariance.inverse();
  return inverse.allFinite() ? std::optional(inverse) : std::nullopt;
}

double squared_sigmas(const Vec3& off, const Mat3& covariance) {
  constexpr double kUntold = std::numeric_limits<double>::infinity();
  const std::optional<Mat3> information = inverse_of(covariance);
  const double squared = information ? off.dot(*information * off) : kUntold;
  return squared >= 0 ? squared : kUntold;
}

}  // namespace panoptes
