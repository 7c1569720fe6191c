// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace panoptes {

using Duration = std::chrono::nanoseconds;

/// The platform's clock: counts from the start of the run and moves only when the robot is
/// observed. It has no now(); only a robot knows what time it is.
struct RunClock {
  using duration = Duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<RunClock>;
  static constexpr bool is_steady = true;
};

/// An instant of a run, in int64 nanoseconds since its start.
using Time = RunClock::time_point;

constexpr double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }
constexpr double to_seconds(Time t) { return to_seconds(t.time_since_epoch()); }
inline Duration from_seconds(double s) { return Duration(std::llround(s * 1e9)); }
inline Time time_at(double s) { return Time(from_seconds(s)); }

}  // namespace panoptes
