// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>

#include "core/base/time.h"

namespace panoptes::hw {

/// When reports left the robot, from when they arrived. They leave once a cycle and arrive in that
/// order; whatever is between (a program that was frozen, a network) holds them up, never back. So
/// the last seconds' arrivals over the reports' numbers lie above a straight line, and the nearest
/// such line is when they left, but for what every report takes.
class ReportClock {
 public:
  explicit ReportClock(Duration cycle = std::chrono::milliseconds(100)) : cycle_(cycle) {}

  struct Departure {
    Time stamp;        ///< later than the last one's
    Duration apart{};  ///< whole cycles since the last one
    Duration gap{};    ///< between the two arrivals
  };

  /// How long it can be since the last report.
  struct Elapsed {
    double least_s = 0;
    double most_s = std::numeric_limits<double>::infinity();
  };

  /// Of the report that arrives now. When it comes late, either others were lost or it was held
  /// up: where its way tells `elapsed`, that decides, and else whether it is late by whole cycles.
  Departure departure(Time arrival, const Elapsed& elapsed) const;

  /// It is believed: later ones follow it.
  void take(Time arrival, const Departure& departure);

 private:
  struct Arrival {
    std::int64_t number = 0;
    double beyond_s = 0;   // the cycles up to it
    bool at_once = false;  // after the one before: that was held up
  };

  double arrival_s(Time arrival) const;       // since the first
  double cycle_s() const;                     // as the arrivals have it
  double offset_s(const Arrival& one) const;  // of the line through it, at number 0
  double line_s(std::int64_t number) const;
  double lateness(const Arrival& one) const;  // in cycles
  std::int64_t since(double last_s) const;    // the number that came then
  void lower();
  void catch_up();
  void fit();

  Duration cycle_;
  std::optional<Time> first_;
  Time last_arrival_;
  Time last_stamp_;
  std::int64_t last_number_ = 0;
  std::deque<Arrival> arrivals_;
  double lowest_s_ = 0;    // the line's offset
  double slope_s_ = 0;     // by how much a cycle is longer than it should be
  bool holds_up_ = false;  // reports are held up here now and then
};

}  // namespace panoptes::hw
