// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/lens_parameters.h"

#include <array>
#include <cmath>

#include <Eigen/LU>

#include "core/base/check.h"
#include "core/camera/brown_conrady.h"

namespace panoptes {
namespace {

constexpr int kPinhole = 4;  // fx, fy, cx, cy

std::vector<double> coefficients(const NoDistortion&) { return {}; }
std::vector<double> coefficients(const BrownConrady& o) { return {o.k1, o.k2, o.p1, o.p2, o.k3}; }
std::vector<double> coefficients(const Equidistant& o) { return {o.k1, o.k2, o.k3, o.k4}; }

NoDistortion with(const NoDistortion&, const double*) { return {}; }
BrownConrady with(const BrownConrady&, const double* k) { return {k[0], k[1], k[2], k[3], k[4]}; }
Equidistant with(const Equidistant&, const double* k) { return {k[0], k[1], k[2], k[3]}; }

std::vector<std::string> names(const NoDistortion&) { return {}; }
std::vector<std::string> names(const BrownConrady&) { return {"k1", "k2", "p1", "p2", "k3"}; }
std::vector<std::string> names(const Equidistant&) { return {"k1", "k2", "k3", "k4"}; }

/// Normalised picture coordinates, where a pinhole draws x / z and y / z, with their derivatives.
struct Drawn {
  Vec2 at = Vec2::Zero();
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 5> by_coefficients;
};

Drawn drawn(const NoDistortion&, const Vec3& p) {
  Drawn d;
  d.at = p.head<2>() / p.z();
  d.by_point << 1 / p.z(), 0, -d.at.x() / p.z(), 0, 1 / p.z(), -d.at.y() / p.z();
  d.by_coefficients.resize(2, 0);
  return d;
}

Drawn drawn(const BrownConrady& o, const Vec3& p) {
  const Drawn straight = drawn(NoDistortion{}, p);
  const double x = straight.at.x();
  const double y = straight.at.y();
  const double r2 = x * x + y * y;
  Drawn d;
  d.at = bent(o, straight.at);
  d.by_point = bent_jacobian(o, straight.at) * straight.by_point;
  d.by_coefficients.resize(2, 5);
  d.by_coefficients << x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x, x * r2 * r2 * r2,  //
      y * r2, y * r2 * r2, r2 + 2 * y * y, 2 * x * y, y * r2 * r2 * r2;
  return d;
}

Drawn drawn(const Equidistant& o, const Vec3& p) {
  Drawn d;
  d.by_point.setZero();
  d.by_coefficients.setZero(2, 4);
  const double across = std::hypot(p.x(), p.y());
  if (across == 0) {
    PANOPTES_CHECK(p.z() > 0, "what lies right behind a fisheye is drawn at no one place");
    d.by_point(0, 0) = 1 / p.z();
    d.by_point(1, 1) = 1 / p.z();
    return d;
  }
  const double theta = std::atan2(across, p.z());
  const double u = theta * theta;
  const double r = theta * (1 + u * (o.k1 + u * (o.k2 + u * (o.k3 + u * o.k4))));
  const double slope = 1 + u * (3 * o.k1 + u * (5 * o.k2 + u * (7 * o.k3 + u * 9 * o.k4)));
  const Vec2 outward = p.head<2>() / across;
  d.at = r * outward;
  const double norm2 = p.squaredNorm();
  Eigen::RowVector3d theta_by_point;
  theta_by_point << p.z() * outward.x() / norm2, p.z() * outward.y() / norm2, -across / norm2;
  d.by_point = outward * (slope * theta_by_point);
  d.by_point.leftCols<2>() +=
      r / across * (Eigen::Matrix2d::Identity() - outward * outward.transpose());
  double power = theta;
  for (int i = 0; i < 4; ++i) {
    power *= u;
    d.by_coefficients.col(i) = power * outward;
  }
  return d;
}

}  // namespace

Eigen::VectorXd lens_parameters(const Intrinsics& lens) {
  const std::vector<double> k =
      std::visit([](const auto& o) { return coefficients(o); }, lens.distortion);
  Eigen::VectorXd all(kPinhole + k.size());
  all << lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px,
      Eigen::Map<const Eigen::VectorXd>(k.data(), static_cast<Eigen::Index>(k.size()));
  return all;
}

Intrinsics with_parameters(Intrinsics lens, const Eigen::VectorXd& parameters) {
  PANOPTES_CHECK(parameters.size() == lens_parameters(lens).size(),
                 "a lens has as many parameters as its model");
  lens.fx_px = parameters[0];
  lens.fy_px = parameters[1];
  lens.cx_px = parameters[2];
  lens.cy_px = parameters[3];
  lens.distortion = std::visit(
      [&parameters](const auto& o) { return Distortion(with(o, parameters.data() + kPinhole)); },
      lens.distortion);
  return lens;
}

std::vector<std::string> lens_parameter_names(const Intrinsics& lens) {
  std::vector<std::string> all{"fx_px", "fy_px", "cx_px", "cy_px"};
  for (std::string& name : std::visit([](const auto& o) { return names(o); }, lens.distortion)) {
    all.push_back(std::move(name));
  }
  return all;
}

Projection project_with_jacobian(const Intrinsics& lens, const Vec3& p_camera) {
  const Drawn d =
      std::visit([&p_camera](const auto& o) { return drawn(o, p_camera); }, lens.distortion);
  const Vec2 f_px(lens.fx_px, lens.fy_px);
  Projection out;
  out.px = Vec2(lens.cx_px, lens.cy_px) + f_px.cwiseProduct(d.at);
  out.px_by_point = f_px.asDiagonal() * d.by_point;
  out.px_by_lens.setZero(2, kPinhole + d.by_coefficients.cols());
  out.px_by_lens(0, 0) = d.at.x();
  out.px_by_lens(1, 1) = d.at.y();
  out.px_by_lens(0, 2) = 1;
  out.px_by_lens(1, 3) = 1;
  out.px_by_lens.rightCols(d.by_coefficients.cols()) = f_px.asDiagonal() * d.by_coefficients;
  return out;
}

std::optional<Eigen::Matrix<double, 3, 2>> direction_by_px(const Intrinsics& lens,
                                                           const Vec3& direction) {
  const Vec3 across = direction.unitOrthogonal();
  Eigen::Matrix<double, 3, 2> basis;
  basis << across, direction.cross(across);
  const Mat2 px_by_basis = project_with_jacobian(lens, direction).px_by_point * basis;
  if (std::abs(px_by_basis.determinant()) < 1e-6) {
    return std::nullopt;
  }
  return basis * px_by_basis.inverse();
}

}  // namespace panoptes
