// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "core/base/timing.h"

namespace panoptes {

/// How long a robot takes to react: what its platform states, and the cycle as it is measured
/// between the stamps of what is decided on. A cycle longer than the platform's period is a
/// decision that takes too long, or observations that are lost; it counts until it is five seconds
/// old.
class Reaction {
 public:
  explicit Reaction(const Timing& platform);

  /// A decision is made on an observation of this instant.
  void decide(Time stamp);

  /// Between two decisions: the median of those in memory.
  double cycle_s() const { return cycle_s_; }

  /// Between two decisions, at the longest of late.
  double longest_cycle_s() const { return longest_s_; }

  /// From an observation's instant until a command that is decided on it acts, at the latest.
  double lag_s() const { return lag_s_; }

  /// From an observation's instant until the command after the next acts, at the latest: what the
  /// observation does not show is answered then.
  double reaction_s() const { return lag_s_ + longest_s_; }

 private:
  struct Cycle {
    Time end;
    double length_s = 0;
  };

  void measure();

  Timing platform_;
  std::deque<Cycle> cycles_;
  Time last_{};
  bool decided_ = false;
  double cycle_s_ = 0;
  double longest_s_ = 0;
  double lag_s_ = 0;
};

/// The distance from there to standing: at full speed until it reacts, then braking evenly.
double stopping_distance_m(double speed_mps, double reaction_s, double max_accel_mps2);

/// The highest speed whose stopping distance is no longer than `distance_m`.
double speed_that_stops_mps(double distance_m, double reaction_s, double max_accel_mps2);

}  // namespace panoptes
