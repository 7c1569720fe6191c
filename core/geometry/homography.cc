// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/homography.h"

#include <cmath>

#include <Eigen/Dense>

namespace panoptes {
namespace {

// The similarity that moves points to their centroid and to a mean distance of sqrt(2); empty when
// they coincide.
std::optional<Mat3> normaliser(const std::vector<Vec2>& points) {
  Vec2 centre = Vec2::Zero();
  for (const Vec2& p : points) {
    centre += p;
  }
  centre /= static_cast<double>(points.size());
  double distance = 0;
  double size = 0;
  for (const Vec2& p : points) {
    distance += (p - centre).norm();
    size = std::max(size, p.norm());
  }
  distance /= static_cast<double>(points.size());
  if (!(distance > 1e-12 * (1 + size))) {
    return std::nullopt;
  }
  const double s = std::sqrt(2.0) / distance;
  Mat3 N;
  N << s, 0, -s * centre.x(), 0, s, -s * centre.y(), 0, 0, 1;
  return N;
}

Vec2 apply(const Mat3& H, const Vec2& p) { return (H * p.homogeneous()).hnormalized(); }

// Below this ratio of the eighth singular value to the first the eight equations do not determine
// the homography: marks a hundredth of their spread off a common line still pass.
constexpr double kRankTolerance = 1e-4;

std::optional<Mat3> solve(const std::vector<PlanePair>& pairs) {
  std::vector<Vec2> from;
  std::vector<Vec2> to;
  for (const PlanePair& pair : pairs) {
    from.push_back(pair.from);
    to.push_back(pair.to);
  }
  const std::optional<Mat3> N_from = normaliser(from);
  const std::optional<Mat3> N_to = normaliser(to);
  if (!N_from || !N_to) {
    return std::nullopt;
  }
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * static_cast<Eigen::Index>(pairs.size()), 9);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vec3 p = *N_from * from[i].homogeneous();
    const Vec2 q = apply(*N_to, to[i]);
    const auto row = 2 * static_cast<Eigen::Index>(i);
    A.block<1, 3>(row, 0) = p.transpose();
    A.block<1, 3>(row, 6) = -q.x() * p.transpose();
    A.block<1, 3>(row + 1, 3) = p.transpose();
    A.block<1, 3>(row + 1, 6) = -q.y() * p.transpose();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullV);
  if (!(svd.singularValues()(7) > kRankTolerance * svd.singularValues()(0))) {
    return std::nullopt;
  }
  const Eigen::VectorXd h = svd.matrixV().col(8);
  Mat3 H_normal;
  H_normal << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  if (std::abs(H_normal.determinant()) < kRankTolerance * kRankTolerance) {
    return std::nullopt;
  }
  Mat3 H = N_to->inverse() * H_normal * *N_from;
  // the sign for which the marks lie before the horizon
  int before = 0;
  for (const Vec2& p : from) {
    before += (H * p.homogeneous()).z() > 0 ? 1 : -1;
  }
  if (std::abs(before) != static_cast<int>(from.size())) {
    return std::nullopt;  // marks on both sides of the horizon: no camera sees that
  }
  H *= (before > 0 ? 1 : -1) / H.norm();
  return H;
}

}  // namespace

HomographyFit fit_homography(const std::vector<PlanePair>& pairs) {
  HomographyFit fit;
  if (pairs.size() < 4) {
    fit.fault = "needs at least four pairs";
    return fit;
  }
  for (const PlanePair& pair : pairs) {
    if (!pair.from.allFinite() || !pair.to.allFinite()) {
      fit.fault = "has a coordinate that is not a number";
      return fit;
    }
  }
  fit.H_to_from = solve(pairs);
  if (!fit.H_to_from) {
    fit.fault = "three or more of the points lie on one line, coincide, or lie behind the camera";
    return fit;
  }
  const auto count = static_cast<double>(pairs.size());
  double sum = 0;
  for (const PlanePair& pair : pairs) {
    sum += (apply(*fit.H_to_from, pair.from) - pair.to).squaredNorm();
  }
  fit.rms = std::sqrt(sum / count);
  if (pairs.size() >= 5) {
    double left_out = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      std::vector<PlanePair> others = pairs;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
      const std::optional<Mat3> H = solve(others);
      if (!H) {
        return fit;  // the others do not determine it: no such error can be given
      }
      left_out += (apply(*H, pairs[i].from) - pairs[i].to).squaredNorm();
    }
    fit.leave_one_out = std::sqrt(left_out / count);
  }
  return fit;
}

std::optional<Vec2> transfer(const Mat3& H, const Vec2& p) {
  const Vec3 q = H * p.homogeneous();
  if (!(q.z() > 1e-9 * H.row(2).norm())) {
    return std::nullopt;
  }
  return Vec2(q.x() / q.z(), q.y() / q.z());
}

bool clear_of_horizon(const Mat3& H, const Vec2& low, const Vec2& high) {
  // the third coordinate is linear, so its least value is at a corner
  for (const Vec2& corner : {low, high, Vec2(low.x(), high.y()), Vec2(high.x(), low.y())}) {
    if (!transfer(H, corner)) {
      return false;
    }
  }
  return true;
}

}  // namespace panoptes
