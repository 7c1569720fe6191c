// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/encoders.h"

#include <cmath>
#include <numbers>

#include "core/config/geometry_fields.h"

namespace panoptes::sim {
namespace {

double tick_m(const Body& body) {
  return 2 * std::numbers::pi * body.wheel_radius_m / body.ticks_per_turn;
}

double drawn_sign(Rng rng) { return rng.uniform() < 0.5 ? -1 : 1; }

}  // namespace

void bind(Fields& f, WheelOffset& o) {
  f("radius_percent", o.radius_percent, between(-20, 20));
  f("radius_ratio_percent", o.radius_ratio_percent, between(-20, 20));
  f("base_percent", o.base_percent, between(-20, 20));
}

void bind(Fields& f, WheelError& o) {
  f("noise_m_per_sqrt_m", o.noise_m_per_sqrt_m, between(0, 0.1));
  f("diameter_difference", o.diameter_difference, between(0, 0.2));
  f("base_error", o.base_error, between(0, 0.2));
  f("turn_slip", o.turn_slip, between(0, 0.2));
  f("sigma_radius_percent", o.sigma_radius_percent, between(0, 5));
  f("sigma_radius_ratio_percent", o.sigma_radius_ratio_percent, between(0, 5));
  f("sigma_base_percent", o.sigma_base_percent, between(0, 5));
  f("exactly", o.exactly);
}

void bind(Fields& f, Surface& o) {
  f.needed("at", o.at);
  f("size_m", o.size_m, positive);
  f("slip", o.slip, between(-0.5, 0.5));
  f("noise_factor", o.noise_factor, between(0, 100));
}

std::array<TractionFactors, 2> traction_under_wheels(const std::vector<Surface>& surfaces,
                                                     const Body& body, const Pose2& T_scene_body) {
  std::array<TractionFactors, 2> traction;
  const std::array<Vec2, 2> wheels_body{Vec2(0, body.wheel_base_m / 2),
                                        Vec2(0, -body.wheel_base_m / 2)};
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec2 wheel_scene = T_scene_body * wheels_body[i];
    for (const Surface& surface : surfaces) {
      const Vec2 off = surface.at.inverse() * wheel_scene;
      if ((off.array().abs() <= surface.size_m.array() / 2).all()) {
        traction[i] = {surface.slip, surface.noise_factor};
        break;
      }
    }
  }
  return traction;
}

WheelFactors wheel_factors(const WheelError& options, const Rng& rng) {
  WheelOffset offset;
  double left_larger = 0;
  double base_larger = 0;
  if (options.exactly) {
    offset = *options.exactly;
  } else {
    left_larger = drawn_sign(rng.fork("wheel-diameters")) * options.diameter_difference / 2;
    base_larger = drawn_sign(rng.fork("wheel-base")) * options.base_error;
    Rng draw = rng.fork("wheel-sizes");
    offset.radius_percent = draw.normal(0, options.sigma_radius_percent);
    offset.radius_ratio_percent = draw.normal(0, options.sigma_radius_ratio_percent);
    offset.base_percent = draw.normal(0, options.sigma_base_percent);
  }
  // The two differ by the ratio, and their mean is left alone.
  const double ratio = offset.radius_ratio_percent / 100;
  left_larger += ratio / (2 + ratio);
  const double both = 1 + offset.radius_percent / 100;
  return {{(1 + left_larger) * both, (1 - left_larger) * both},
          1 + base_larger + offset.base_percent / 100};
}

TrueWheels true_wheels(const WheelFactors& factors, const Body& believed) {
  return {believed.wheel_radius_m * factors.radius[0], believed.wheel_radius_m * factors.radius[1],
          believed.wheel_base_m * factors.base};
}

WheelEncoders::WheelEncoders(const WheelError& options, const Body& believed, const Rng& rng)
    : WheelEncoders(options, wheel_factors(options, rng), believed, rng) {}

WheelEncoders::WheelEncoders(const WheelError& options, const WheelFactors& factors,
                             const Body& believed, const Rng& rng)
    : noise_m_per_sqrt_m_(options.noise_m_per_sqrt_m),
      turn_slip_(options.turn_slip),
      base_m_(believed.wheel_base_m * factors.base),
      wheels_(true_wheels(factors, believed)),
      ticks_per_m_{1 / (tick_m(believed) * factors.radius[0]),
                   1 / (tick_m(believed) * factors.radius[1])},
      noise_rng_(rng.fork("wheel-noise")),
      slip_rng_(rng.fork("wheel-slip")) {}

void WheelEncoders::roll(double forward_m, double turn_rad,
                         const std::array<TractionFactors, 2>& traction) {
  const int turning = turn_rad > 0 ? 1 : turn_rad < 0 ? -1 : 0;
  if (turning != turning_ && turning != 0) {
    slip_ = slip_rng_.normal(0, turn_slip_);
  }
  turning_ = turning;
  for (std::size_t i = 0; i < 2; ++i) {
    const double half_m = turn_rad * (1 + slip_ * traction[i].noise_factor) * base_m_ / 2;
    const double distance_m =
        (i == 0 ? forward_m - half_m : forward_m + half_m) * (1 + traction[i].slip);
    if (distance_m != 0) {
      const double noise_m = noise_rng_.normal(
          0, noise_m_per_sqrt_m_ * traction[i].noise_factor * std::sqrt(std::abs(distance_m)));
      rolled_ticks_[i] += (distance_m + noise_m) * ticks_per_m_[i];
    }
  }
}

Ticks WheelEncoders::ticks() const {
  return {static_cast<std::int64_t>(std::floor(rolled_ticks_[0])),
          static_cast<std::int64_t>(std::floor(rolled_ticks_[1]))};
}

DeadReckoning::DeadReckoning(const Body& believed)
    : m_per_tick_(tick_m(believed)), base_m_(believed.wheel_base_m) {}

void DeadReckoning::add(const Ticks& ticks, Duration step) {
  const double left_m = m_per_tick_ * static_cast<double>(ticks.left - last_.left);
  const double right_m = m_per_tick_ * static_cast<double>(ticks.right - last_.right);
  last_ = ticks;
  const Twist2 motion{(left_m + right_m) / 2, (right_m - left_m) / base_m_};
  odometry_.T_odom_body = odometry_.T_odom_body * exp_twist(motion, 1);

  recent_[next_] = {left_m, right_m, step};
  next_ = (next_ + 1) % recent_.size();
  Step sum;
  for (const Step& one : recent_) {
    sum.left_m += one.left_m;
    sum.right_m += one.right_m;
    sum.duration += one.duration;
  }
  const double seconds = to_seconds(sum.duration);
  odometry_.twist_body = {(sum.left_m + sum.right_m) / 2 / seconds,
                          (sum.right_m - sum.left_m) / base_m_ / seconds};
}

}  // namespace panoptes::sim
