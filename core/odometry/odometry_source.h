// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "core/geometry/pose2.h"
#include "core/motion/rig_correction.h"

namespace panoptes {

/// Whether it tells numbers.
inline bool is_finite(const Odometry& odometry) {
  const Pose2& T = odometry.T_odom_body;
  const Twist2& twist = odometry.twist_body;
  return std::isfinite(T.x_m) && std::isfinite(T.y_m) && std::isfinite(T.theta_rad) &&
         std::isfinite(twist.v_mps) && std::isfinite(twist.w_radps);
}

/// Where the robot's motion comes from: its wheels, say, or its pictures. A source tells poses in a
/// frame of its own, which drifts but never jumps.
class OdometrySource {
 public:
  virtual ~OdometrySource() = default;

  /// At the instant of an observation as the platform gives it (pictures not straightened, cameras
  /// not judged); each is given once, in order of time. Empty where the source tells nothing.
  virtual std::optional<Odometry> at(const Observation& seen) = 0;

  /// Why `at` told nothing, in words: "the wheels tell no number".
  virtual std::string fault() const = 0;

  /// How sure the motion `T_from_to` between two instants is that it told of, without what it gets
  /// wrong every time; x, y, theta in the frame of its start.
  virtual Mat3 covariance(Time from, Time to, const Pose2& T_from_to) const = 0;

  /// And how it changes with what it gets wrong every time: the states of wheels. Nothing for a
  /// source without wheels.
  virtual WheelJacobian by_wheels(const Pose2& /*T_from_to*/) const {
    return WheelJacobian::Zero();
  }

 protected:
  OdometrySource() = default;
  OdometrySource(const OdometrySource&) = default;
  OdometrySource& operator=(const OdometrySource&) = default;
};

}  // namespace panoptes
