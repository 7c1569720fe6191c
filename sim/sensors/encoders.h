// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/config/fields.h"
#include "core/eval/truth.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"

namespace panoptes::sim {

/// By how much the true wheels are larger than the robot believes, and farther apart.
struct WheelOffset {
  double radius_percent = 0;        ///< the mean of both
  double radius_ratio_percent = 0;  ///< left against right
  double base_percent = 0;
};
void bind(Fields& f, WheelOffset& o);

/// How the true wheels differ from what the robot believes of them. All zero: ticks are the only
/// error. The defaults are a base that was calibrated on its floor. They leave a raw odometry error
/// of about a metre after ten minutes of exploring an office; see scenes/robots/pioneer3dx.yaml.
struct WheelError {
  /// Standard deviation of a wheel's travel after one metre; it grows with the square root of the
  /// distance.
  double noise_m_per_sqrt_m = 0.003;
  double diameter_difference = 0.0006;  ///< of the two wheels, relative; the seed draws its sign
  double base_error = 0.003;            ///< of the wheel base, relative; the seed draws its sign
  double turn_slip = 0.006;  ///< each turn is felt by the wheels times 1 + N(0, turn_slip)
  /// Standard deviations of what is drawn besides; the parts are those of WheelOffset.
  double sigma_radius_percent = 0.2;
  double sigma_radius_ratio_percent = 0;    ///< diameter_difference stands for it
  double sigma_base_percent = 0;            ///< base_error stands for it
  std::optional<WheelOffset> exactly = {};  ///< in place of all that is drawn of radii and base
};
void bind(Fields& f, WheelError& o);

/// The true wheels against the believed ones.
struct WheelFactors {
  std::array<double, 2> radius{1, 1};  ///< left, right
  double base = 1;
};
WheelFactors wheel_factors(const WheelError& options, const Rng& rng);
TrueWheels true_wheels(const WheelFactors& factors, const Body& believed);

/// A patch of floor on which wheels hold worse (or better) than elsewhere: a rectangle in scene.
struct Surface {
  Pose2 at;  ///< of its middle, in scene
  Vec2 size_m = Vec2::Ones();
  double slip = 0;  ///< a wheel there rolls farther than it carries the robot, by this share
  double noise_factor = 1;  ///< times noise_m_per_sqrt_m and turn_slip
};
void bind(Fields& f, Surface& o);

/// How a wheel holds on what is under it.
struct TractionFactors {
  double slip = 0;
  double noise_factor = 1;
};

/// What is under each wheel, left and right, of a body that stands there: the first surface that
/// has the wheel on it, else plain floor.
std::array<TractionFactors, 2> traction_under_wheels(const std::vector<Surface>& surfaces,
                                                     const Body& body, const Pose2& T_scene_body);

/// Counts of the two wheels since the start.
struct Ticks {
  std::int64_t left = 0;
  std::int64_t right = 0;
};

/// The wheels and their encoders: from the true motion of the body to the ticks its controller
/// counts. A turn lasts from when turning in one direction starts until it ends; its slip is drawn
/// once.
class WheelEncoders {
 public:
  WheelEncoders(const WheelError& options, const Body& believed, const Rng& rng);

  const TrueWheels& wheels() const { return wheels_; }

  /// The body moved `forward_m` and turned by `turn_rad` in one step, the wheels (left, right) on
  /// floor that holds them so.
  void roll(double forward_m, double turn_rad, const std::array<TractionFactors, 2>& traction = {});
  Ticks ticks() const;

 private:
  WheelEncoders(const WheelError& options, const WheelFactors& factors, const Body& believed,
                const Rng& rng);

  double noise_m_per_sqrt_m_;
  double turn_slip_;
  double base_m_;
  TrueWheels wheels_;
  std::array<double, 2> ticks_per_m_;     // left, right
  std::array<double, 2> rolled_ticks_{};  // not yet cut to whole ticks
  int turning_ = 0;                       // sign of the turn that is going on
  double slip_ = 0;                       // of this turn, on plain floor
  Rng noise_rng_;
  Rng slip_rng_;
};

/// Dead reckoning in `odom` from ticks, with the wheels as the robot believes them to be.
class DeadReckoning {
 public:
  explicit DeadReckoning(const Body& believed);

  void add(const Ticks& ticks, Duration step);
  Odometry odometry() const { return odometry_; }

 private:
  double m_per_tick_;
  double base_m_;
  Ticks last_;
  struct Step {
    double left_m = 0;
    double right_m = 0;
    Duration duration{};
  };
  // A single step of 1/120 s sees a handful of ticks: the velocity is taken over eight of them.
  std::array<Step, 8> recent_{};
  std::size_t next_ = 0;
  Odometry odometry_;
};

}  // namespace panoptes::sim
