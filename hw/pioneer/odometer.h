// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/time.h"
#include "core/geometry/pose2.h"
#include "hw/pioneer/model.h"
#include "hw/pioneer/report.h"
#include "hw/pioneer/report_clock.h"

namespace panoptes::hw {

/// Turns a controller's wrapping counters into a path without steps, and believes no report that
/// the robot cannot have come to: the checksum lets words that are exchanged and errors that cancel
/// pass. Counters of 12, 15 and 16 bits are all taken modulo 4096, which divides their range, so
/// that a step is known while it is under 2048 counts.
class PioneerOdometer {
 public:
  enum class Verdict {
    kAccepted,
    kImplausible,   ///< too far from where the robot must be: not used
    kDiscontinuity  ///< accepted, but how the robot came there is not known: a new epoch
  };

  explicit PioneerOdometer(const PioneerModel& model) : model_(model) {}

  /// A report that was sent at `stamp`; `most` is the speed (both parts positive) that the robot
  /// was told to go at most since the last accepted one. It must lie within 60 mm + v dt and 5
  /// degrees + w dt of where the last accepted one's twist leads, dt being the time since it, v and
  /// w the larger of its own and `most`. The first one sets the origin. Three in a row that agree
  /// with each other but not with that begin a new epoch: the controller counts from elsewhere.
  /// Where stamps are estimates, `apart` is how long it truly was since the last accepted one, and
  /// `gap` how long it may have been, for which the counters must not have wrapped.
  Verdict add(Time stamp, const Sip& sip, const Twist2& most, Duration apart = {},
              Duration gap = {});

  /// How long it can be since the last accepted report: so that the path between them is what a
  /// body drives from the velocity of the one to that of the other, within a Pioneer's
  /// accelerations.
  ReportClock::Elapsed elapsed(const Sip& sip) const;

  /// The next report sets the origin again, and the pose stays: after a new connection, maybe to
  /// another robot.
  void restart(const PioneerModel& model);

  const Pose2& T_odom_body() const { return T_odom_body_; }
  const Twist2& twist_body() const { return twist_body_; }
  std::optional<Time> last() const { return last_; }  ///< accepted since the (re)start
  int epoch() const { return epoch_; }

 private:
  struct Counts {
    std::int64_t x = 0;
    std::int64_t y = 0;
    std::int64_t theta = 0;
  };
  struct Candidate {
    Time stamp;
    Counts counts;
    Twist2 twist_body;
  };

  static Counts continued(const Counts& from, const Sip& sip);
  Pose2 pose(const Counts& counts) const;
  bool near(const Candidate& from, const Candidate& to, double dt_s, const Twist2& most) const;
  void rebase(const Candidate& report);
  void take(const Candidate& report);

  PioneerModel model_;
  std::optional<Time> last_;
  Counts counts_;
  Pose2 T_odom_counter_;  // counter: the frame of the controller's own pose
  Pose2 T_odom_body_;
  Twist2 twist_body_;
  int epoch_ = 0;
  std::optional<Candidate> elsewhere_;  // the last report that was not believed
  int agreeing_ = 0;                    // how many such agree with each other
};

}  // namespace panoptes::hw
