// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <limits>
#include <optional>

#include "core/base/time.h"
#include "core/camera/observation.h"
#include "hw/base.h"

namespace panoptes::hw {

/// How fast a base goes to a commanded velocity, and how fast it can be.
struct BaseRamp {
  double accel_mps2 = 0;
  double turn_accel_radps2 = 0;
  double max_speed_mps = std::numeric_limits<double>::infinity();
  double max_turn_radps = std::numeric_limits<double>::infinity();
};

/// The wheels' way between and a little beyond the instants of a base's reports, which come at
/// 10 Hz where pictures come at 15. Between two reports the body drives the arc of a circle that
/// joins them.
class OdometryTrack {
 public:
  explicit OdometryTrack(const BaseRamp& ramp = {}) : ramp_(ramp) {}

  /// In order of time; what is older than a few seconds is forgotten.
  void add(const WheelPose& pose);

  std::optional<Time> first() const;  ///< the instant of the oldest report that is kept
  std::optional<Time> last() const;   ///< the last report's

  /// In order of time: what the base goes towards from then on.
  void commanded(const CommandedTwist& command);

  /// How long a report is good for beyond its instant: the usual time to the next.
  Duration period() const { return period_; }

  /// At an instant between two reports, or up to one period after the last (then it is marked as
  /// extrapolated): by the commands, and by how the base's counters have followed them so far.
  /// The velocity that a controller reports is not used for it, for it is a mean of the time
  /// before. Where commands are heard late (`late`) they tell nothing of it, and the base is taken
  /// to go on as it reports that it goes. Empty before the first report, and later
  /// than a period after the last.
  std::optional<Odometry> at(Time t, bool late = false) const;

 private:
  /// The motion between two instants by the commands alone.
  struct MotionIncrement {
    Pose2 T_from_to;
    Twist2 twist_body;  // at its end
  };
  Twist2 held_within(const Twist2& twist_body) const;  // of what the base can do
  MotionIncrement by_commands(Time from, Time to, const Twist2& twist_body,
                              const Twist2& besides) const;

  BaseRamp ramp_;
  std::deque<WheelPose> poses_;
  std::deque<CommandedTwist> commands_;
  Twist2 commanded_;  // how fast the base goes at the last report, by the commands alone,
  Twist2 besides_;    // and how much faster it is by its counters
  Duration period_ = std::chrono::milliseconds(100);
};

}  // namespace panoptes::hw
