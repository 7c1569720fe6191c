// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/camera/brown_conrady.h"
#include "core/camera/rig.h"

namespace panoptes {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kBisections = 80;  // to the last bit of a double, whatever the bracket
constexpr int kMostNewtonSteps = 50;

/// How far from the axis a lens draws what is `x` off it: x + k[0] x^3 + ... + k[3] x^9. `x` is the
/// tangent of the angle for BrownConrady, the angle for Equidistant.
struct Radial {
  std::array<double, 4> k{};
  double most = 0;  ///< of x: nothing is farther off the axis

  double at(double x) const {
    const double u = x * x;
    return x * (1 + u * (k[0] + u * (k[1] + u * (k[2] + u * k[3]))));
  }
  double slope(double x) const {
    const double u = x * x;
    return 1 + u * (3 * k[0] + u * (5 * k[1] + u * (7 * k[2] + u * 9 * k[3])));
  }
};

Radial radial_of(const BrownConrady& o) {
  return {{o.k1, o.k2, o.k3, 0}, std::tan(deg_to_rad(89))};
}

Radial radial_of(const Equidistant& o) { return {{o.k1, o.k2, o.k3, o.k4}, kPi}; }

/// Where a polynomial (lowest power first) changes its sign between 0 and `most`, in order.
std::vector<double> sign_changes(const std::vector<double>& coefficients, double most) {
  if (coefficients.size() < 2) {
    return {};
  }
  const auto value = [&coefficients](double x) {
    double sum = 0;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) {
      sum = sum * x + *c;
    }
    return sum;
  };
  std::vector<double> derivative;
  for (std::size_t i = 1; i < coefficients.size(); ++i) {
    derivative.push_back(static_cast<double>(i) * coefficients[i]);
  }
  std::vector<double> ends = sign_changes(derivative, most);  // between two it rises or falls
  ends.push_back(most);
  std::vector<double> found;
  double low = 0;
  for (const double end : ends) {
    double a = low;
    double b = end;
    low = end;
    const bool negative = value(a) < 0;
    if ((value(b) < 0) == negative) {
      continue;
    }
    for (int i = 0; i < kBisections; ++i) {
      const double middle = (a + b) / 2;
      ((value(middle) < 0) == negative ? a : b) = middle;
    }
    found.push_back(b);
  }
  return found;
}

/// The x beyond which the lens draws what is farther off the axis nearer to it again.
double turning_point(const Radial& radial) {
  const std::array<double, 4>& k = radial.k;
  const std::vector<double> turns =
      sign_changes({1, 3 * k[0], 5 * k[1], 7 * k[2], 9 * k[3]}, radial.most * radial.most);
  return turns.empty() ? radial.most : std::sqrt(turns.front());
}

/// True only where the slope is positive from 0 to x; may be false there too.
bool surely_rises(const Radial& radial, double x) {
  const double u = x * x;
  double power = 1;
  double least = 1;
  double factor = 1;
  for (const double k : radial.k) {
    power *= u;
    factor += 2;
    least += std::min(factor * k, 0.0) * power;
  }
  return least > 0;
}

std::optional<double> solved(const Radial& radial, double wanted) {
  double x = std::min(wanted, radial.most);
  for (int i = 0; i < kMostNewtonSteps; ++i) {
    const double step = (radial.at(x) - wanted) / radial.slope(x);
    x -= step;
    if (!(x >= 0) || x > radial.most) {
      break;
    }
    if (std::abs(step) <= 1e-15 * (1 + x)) {
      if (surely_rises(radial, x)) {
        return x;
      }
      break;
    }
  }
  double low = 0;
  double high = turning_point(radial);
  if (radial.at(high) < wanted) {
    return std::nullopt;
  }
  for (int i = 0; i < kBisections; ++i) {
    const double middle = (low + high) / 2;
    (radial.at(middle) < wanted ? low : high) = middle;
  }
  return (low + high) / 2;
}

// From normalised picture coordinates, where a pinhole draws x / z and y / z.

std::optional<Vec3> direction_of(const NoDistortion&, const Vec2& p) {
  return Vec3(p.x(), p.y(), 1).normalized();
}

std::optional<Vec3> direction_of(const BrownConrady& o, const Vec2& p) {
  const double wanted = p.norm();
  if (wanted == 0 && o.p1 == 0 && o.p2 == 0) {
    return Vec3::UnitZ();
  }
  const std::optional<double> r = solved(radial_of(o), wanted);
  if (!r) {
    return std::nullopt;
  }
  Vec2 q = wanted > 0 ? Vec2(p * (*r / wanted)) : Vec2(0, 0);
  if (o.p1 != 0 || o.p2 != 0) {
    double step = 1;
    for (int i = 0; i < kMostNewtonSteps && step > 1e-15 * (1 + q.norm()); ++i) {
      const Eigen::Matrix2d J = bent_jacobian(o, q);
      if (!(J.determinant() > 0)) {
        return std::nullopt;
      }
      const Vec2 move = J.inverse() * (p - bent(o, q));
      step = move.norm();
      q += move;
    }
    constexpr double kMiss = 1e-12;
    if (!((bent(o, q) - p).norm() <= kMiss * (1 + wanted))) {
      return std::nullopt;
    }
  }
  return Vec3(q.x(), q.y(), 1).normalized();
}

std::optional<Vec3> direction_of(const Equidistant& o, const Vec2& p) {
  const double wanted = p.norm();
  if (wanted == 0) {
    return Vec3::UnitZ();
  }
  const std::optional<double> theta = solved(radial_of(o), wanted);
  if (!theta) {
    return std::nullopt;
  }
  const double s = std::sin(*theta) / wanted;
  return Vec3(p.x() * s, p.y() * s, std::cos(*theta));
}

Vec2 drawn_at(const NoDistortion&, const Vec3& p) { return p.head<2>() / p.z(); }

Vec2 drawn_at(const BrownConrady& o, const Vec3& p) { return bent(o, p.head<2>() / p.z()); }

Vec2 drawn_at(const Equidistant& o, const Vec3& p) {
  const double across = std::hypot(p.x(), p.y());
  if (across == 0) {
    return {p.z() < 0 ? radial_of(o).at(kPi) : 0.0, 0.0};  // right behind: drawn all around
  }
  return p.head<2>() * (radial_of(o).at(std::atan2(across, p.z())) / across);
}

double drawn_radius(const NoDistortion&, double angle_rad) { return std::tan(angle_rad); }

double drawn_radius(const BrownConrady& o, double angle_rad) {
  const Radial radial = radial_of(o);
  return radial.at(std::min(std::tan(angle_rad), turning_point(radial)));
}

double drawn_radius(const Equidistant& o, double angle_rad) {
  const Radial radial = radial_of(o);
  return radial.at(std::min(angle_rad, turning_point(radial)));
}

/// How far off the axis the lens can see at most.
double most_angle_rad(const NoDistortion&) { return kPi / 2; }
double most_angle_rad(const BrownConrady& o) { return std::atan(turning_point(radial_of(o))); }
double most_angle_rad(const Equidistant& o) { return turning_point(radial_of(o)); }

/// Whether a point lies nearer to the axis than where the lens bends back.
bool before_turn(const Radial& radial, double x) {
  return x <= radial.most && (surely_rises(radial, x) || x <= turning_point(radial));
}
bool before_turn(const NoDistortion&, const Vec3&) { return true; }
bool before_turn(const BrownConrady& o, const Vec3& p) {
  return before_turn(radial_of(o), p.head<2>().norm() / p.z());
}
bool before_turn(const Equidistant& o, const Vec3& p) {
  return before_turn(radial_of(o), std::atan2(p.head<2>().norm(), p.z()));
}

}  // namespace

Vec2 Intrinsics::project(const Vec3& p_camera) const {
  if (is_pinhole()) {
    return {cx_px + fx_px * p_camera.x() / p_camera.z(),
            cy_px + fy_px * p_camera.y() / p_camera.z()};
  }
  const Vec2 p =
      std::visit([&p_camera](const auto& o) { return drawn_at(o, p_camera); }, distortion);
  return {cx_px + fx_px * p.x(), cy_px + fy_px * p.y()};
}

std::optional<Vec3> Intrinsics::direction(const Vec2& px) const {
  const Vec2 p((px.x() - cx_px) / fx_px, (px.y() - cy_px) / fy_px);
  return std::visit([&p](const auto& o) { return direction_of(o, p); }, distortion);
}

Vec3 Intrinsics::ray(const Vec2& px) const {
  if (is_pinhole()) {
    return {(px.x() - cx_px) / fx_px, (px.y() - cy_px) / fy_px, 1};
  }
  const std::optional<Vec3> d = direction(px);
  PANOPTES_CHECK(d && d->z() > 0, "only what is seen less than 90 degrees off the axis has a ray");
  return *d / d->z();
}

bool Intrinsics::sees(const Vec3& p_camera) const {
  if (!std::holds_alternative<Equidistant>(distortion) && !(p_camera.z() > 0)) {
    return false;
  }
  const Vec2 px = project(p_camera);
  if (!(px.x() >= -0.5 && px.y() >= -0.5 && px.x() < width_px - 0.5 && px.y() < height_px - 0.5)) {
    return false;
  }
  return std::visit([&p_camera](const auto& o) { return before_turn(o, p_camera); }, distortion);
}

Intrinsics pinhole(int width_px, int height_px, double horizontal_fov_rad) {
  return lens_of_view(width_px, height_px, horizontal_fov_rad, NoDistortion{});
}

Intrinsics lens_of_view(int width_px, int height_px, double horizontal_fov_rad,
                        const Distortion& distortion) {
  const double half = std::visit(
      [&](const auto& o) { return drawn_radius(o, horizontal_fov_rad / 2); }, distortion);
  const double f_px = width_px / (2 * half);
  return {width_px, height_px, f_px, f_px, (width_px - 1) / 2.0, (height_px - 1) / 2.0, distortion};
}

std::string lens_fault(const Intrinsics& lens) {
  if (lens.is_pinhole()) {
    return {};
  }
  const double right_px = lens.width_px - 0.5;
  const double bottom_px = lens.height_px - 0.5;
  const auto sees_nothing = [&lens](double x_px, double y_px) {
    return !lens.direction({x_px, y_px}).has_value();
  };
  bool all_seen = true;
  for (double x_px = -0.5; x_px <= right_px && all_seen; ++x_px) {
    all_seen = !sees_nothing(x_px, -0.5) && !sees_nothing(x_px, bottom_px);
  }
  for (double y_px = -0.5; y_px <= bottom_px && all_seen; ++y_px) {
    all_seen = !sees_nothing(-0.5, y_px) && !sees_nothing(right_px, y_px);
  }
  if (all_seen) {
    return {};
  }
  const double most_deg =
      rad_to_deg(std::visit([](const auto& o) { return most_angle_rad(o); }, lens.distortion));
  const bool fisheye = std::holds_alternative<Equidistant>(lens.distortion);
  if (most_deg >= (fisheye ? 180 : 89)) {
    return fmt::format(
        "draws nothing in the corners of the picture: they lie more than {:.0f} degrees off the "
        "axis; narrow the field of view",
        fisheye ? 180.0 : 89.0);
  }
  return fmt::format(
      "bends back inside the picture: what is more than {:.1f} degrees off the axis is drawn "
      "nearer to the middle again, and the corners show nothing; narrow the field of view or "
      "correct the coefficients",
      most_deg);
}

}  // namespace panoptes
