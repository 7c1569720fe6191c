// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/drawn_ellipse.h"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace panoptes {

std::vector<Vec2> drawn_ellipse(const Vec2& middle, const Mat2& covariance, double sigmas) {
  const Eigen::SelfAdjointEigenSolver<Mat2> axes(covariance);
  std::vector<Vec2> line;
  constexpr int kCorners = 40;
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    line.push_back(middle + sigmas * axes.eigenvectors() *
                                axes.eigenvalues().cwiseMax(0).cwiseSqrt().cwiseProduct(
                                    Vec2(std::cos(angle), std::sin(angle))));
  }
  return line;
}

}  // namespace panoptes
