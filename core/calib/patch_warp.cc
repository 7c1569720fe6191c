// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/patch_warp.h"

#include <cmath>

#include <Eigen/LU>

#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

// A point looks too different from where it is seen so much larger or smaller, or from so far
// aside.
constexpr double kMostScale = 2;
constexpr double kLeastCosine = 0.6;

}  // namespace

std::optional<Mat2> source_by_px(const PointFromBoth& point, const Intrinsics& lens_now,
                                 const Eigen::Matrix<double, 3, 2>& first_direction_by_px) {
  if (point.from_first.dot(point.from_now) <
      kLeastCosine * point.from_first.norm() * point.from_now.norm()) {
    return std::nullopt;
  }
  const Mat2 px_by_source = project_with_jacobian(lens_now, point.p_now).px_by_point *
                            point.R_now_first * (point.from_first.norm() * first_direction_by_px);
  const double larger = std::sqrt(std::abs(px_by_source.determinant()));
  if (!(larger < kMostScale && larger > 1 / kMostScale)) {
    return std::nullopt;
  }
  return px_by_source.inverse();
}

}  // namespace panoptes
