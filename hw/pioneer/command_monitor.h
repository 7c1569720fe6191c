// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "core/base/time.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "hw/base.h"

namespace panoptes::hw {

/// Whether a robot that is commanded to stop, to slow down or to turn otherwise does so. It may go
/// at any velocity between rest and what was commanded within the link's latency; beyond that it
/// must come back at a quarter of its deceleration at least, within half a second. It may be slower
/// than commanded: wheels may slip or be held.
class CommandMonitor {
 public:
  explicit CommandMonitor(const Body& body) : body_(body) {}

  /// A command takes so long to be heard, and what it did to be seen.
  void allow(Duration latency) { latency_ = latency; }

  void commanded(Time at, const Twist2& twist_body);

  /// What the robot reports of an instant; true where it does not follow the command.
  bool disobeys(Time at, const Twist2& twist_body);

  bool doubtful() const { return speed_.since || turn_.since; }  ///< by the last report
  void forget();  ///< its doubts; earlier commands explain reports that come late

 private:
  /// Of one of the two velocities.
  struct Doubt {
    std::optional<Time> since;
    double is = 0;  // the velocity then
    Time last;
    double is_last = 0;
    bool above = false;  // the command, or below
  };

  static bool persists(Doubt& doubt, Time at, double is, double beyond, double accel);

  Body body_;
  Duration latency_{};
  std::deque<CommandedTwist> commanded_;
  Doubt speed_;
  Doubt turn_;
};

}  // namespace panoptes::hw
