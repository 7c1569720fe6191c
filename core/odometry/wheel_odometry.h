// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "core/odometry/odometry_source.h"

namespace panoptes {

/// What the robot believes its wheels get wrong at random; what they get wrong every time is a
/// state
/// (`WheelPrior`).
struct WheelNoise {
  double step_sigma_m =
      0.004;  ///< per wheel after one metre; grows with the square root of the distance
  double slip_share = 0.01;  ///< of a turn
};
void bind(Fields& f, WheelNoise& o);

/// Covariance of a motion by the wheels taken for one arc; x, y, theta in the frame of its start.
/// Valid for the short distances between keyframes.
Mat3 wheel_covariance(const WheelNoise& noise, double wheel_base_m, const Pose2& T_from_to);

/// What the platform says of its wheels; nothing where that is no number. Where it jumps, farther
/// than the body drives or turns in that time, the counters have been set anew and the robot has
/// not: that observation is told of as a fault, and from the next on poses go on from where the
/// body was, at the speed that the wheels told last.
class WheelOdometry final : public OdometrySource {
 public:
  WheelOdometry(const WheelNoise& noise, const Body& body) : noise_(noise), body_(body) {}

  std::optional<Odometry> at(const Observation& seen) override;
  std::string fault() const override { return fault_; }
  Mat3 covariance(Time from, Time to, const Pose2& T_from_to) const override;
  WheelJacobian by_wheels(const Pose2& T_from_to) const override;

 private:
  WheelNoise noise_;
  Body body_;
  std::string fault_;
  std::optional<Pose2>
      T_told_raw_;  // what is told from what the platform says, since it jumped last
  std::optional<Odometry> last_;
  Time last_stamp_;
};

}  // namespace panoptes
