// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/time.h"

namespace panoptes::hw {

/// When reports left the robot, from when they arrived. They leave once a cycle and arrive in that
/// order; whatever is between (a program that was frozen, a network) holds them up, never back. So
/// the last seconds' arrivals over the reports' numbers lie above a straight line, and the nearest
/// such line is when they left, but for what every report takes.
///
/// Their numbers are not in them. One that comes late was held up, or others before it were lost:
/// every number that it may have is weighed, by those that the last one may have had, by the
/// distance driven since, and by how late reports have been on this link so far (a hidden Markov
/// model's forward pass). The likeliest is taken for now, and later ones may show that it was
/// another.
class ReportClock {
 public:
  explicit ReportClock(Duration cycle = std::chrono::milliseconds(100));

  /// How long it can be since the last report.
  struct Elapsed {
    double least_s = 0;
    double most_s = std::numeric_limits<double>::infinity();
  };

  struct Departure {
    Time stamp;                    ///< later than the last one's, which may have been believed
    Time left;                     ///< to have left later than it did: then this is the better one
    Duration apart{};              ///< whole cycles since the last one
    Duration gap{};                ///< between the two arrivals
    std::int64_t ahead = 0;        ///< by how many numbers it is beyond the last one's next
    std::vector<double> belief{};  ///< that it is beyond by so many, from `least` on
    std::int64_t least = 0;
    std::optional<double> lost{};  ///< before it, where its distance tells
  };

  /// Of the report that arrives now, where its distance tells `elapsed`.
  Departure departure(Time arrival, const Elapsed& elapsed) const;

  /// It is believed: later ones follow it.
  void take(Time arrival, const Departure& departure);

  /// Whether some of the last half minute's reports were held up, and arrived with the next.
  bool holds_up() const { return holds_up_; }

  /// By how much longer than the fastest the slowest of the last half minute's reports took.
  Duration longest_hold() const;

  /// Whether it is known when reports leave: the last few came on time, or many have come.
  bool settled() const;

  Duration cycle() const { return cycle_; }

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
  double likely(double late) const;  // that a report is late by so many cycles
  void learn(double late);
  std::int64_t since(double last_s) const;  // the number that came then
  void believe(const Departure& departure);
  void lower();
  void fit();

  Duration cycle_;
  std::optional<Time> first_;
  Time last_arrival_;
  Time last_stamp_;
  std::int64_t last_number_ = 0;
  std::deque<Arrival> arrivals_;
  double lowest_s_ = 0;              // the line's offset,
  double end_below_s_ = 0;           // and by how much the true one is likely to be lower
  double slope_s_ = 0;               // by how much a cycle is longer than it should be
  bool holds_up_ = false;            // reports are held up here now and then
  std::vector<double> belief_{1.0};  // that the last one's number is beyond ours by so many,
  std::int64_t least_ = 0;           // from this on
  double told_ = 100;                // reports whose distance told how many were lost,
  double lost_ = 0;                  // and before how many of them some were
  std::vector<double> late_;         // how often reports were late, in parts of a cycle
};

}  // namespace panoptes::hw
