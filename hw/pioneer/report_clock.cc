// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/report_clock.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace panoptes::hw {
namespace {

constexpr double kSlopeFrom_s = 30;   // arrivals that tell how long a cycle truly is,
constexpr double kOffsetFrom_s = 10;  // and when they leave: a wrong count is forgotten by then
constexpr double kSlopeAtMost = 0.2;  // of a cycle: a server that keeps its time badly
constexpr std::int64_t kFewest = 30;  // arrivals, for a slope
constexpr double kSteep = 4;          // rising by so many times what they scatter
constexpr double kRound = 0.3;        // of a cycle, by which a report may seem to come early
constexpr double kOnTime = 0.15;      // of a cycle
constexpr std::size_t kShifted = 8;   // arrivals, all of them late by about as many cycles:
constexpr double kAlike = 0.4;        // of a cycle
constexpr Duration kLeastApart = std::chrono::milliseconds(1);

}  // namespace

double ReportClock::arrival_s(Time arrival) const { return to_seconds(arrival - *first_); }

double ReportClock::cycle_s() const { return to_seconds(cycle_) + slope_s_; }

double ReportClock::offset_s(const Arrival& one) const {
  return one.beyond_s - slope_s_ * static_cast<double>(one.number);
}

double ReportClock::line_s(std::int64_t number) const {
  return lowest_s_ + cycle_s() * static_cast<double>(number);
}

double ReportClock::lateness(const Arrival& one) const {
  return (offset_s(one) - lowest_s_) / cycle_s();
}

std::int64_t ReportClock::since(double last_s) const {
  return last_number_ - static_cast<std::int64_t>(std::lround(last_s / to_seconds(cycle_)));
}

// To the highest line of the slope that no arrival of the last seconds lies below.
void ReportClock::lower() {
  const std::int64_t oldest = since(kOffsetFrom_s);
  lowest_s_ = offset_s(arrivals_.back());
  for (auto one = arrivals_.rbegin(); one != arrivals_.rend() && one->number >= oldest; ++one) {
    lowest_s_ = std::min(lowest_s_, offset_s(*one));
  }
}

ReportClock::Departure ReportClock::departure(Time arrival, const Elapsed& elapsed) const {
  if (!first_) {
    return {arrival, Duration::zero(), Duration::zero()};
  }
  const double late = (arrival_s(arrival) - line_s(last_number_)) / cycle_s();
  const double most = std::max(1.0, std::floor(late + kRound));
  // What comes whole cycles late is another report, but where some come at once after others.
  const bool others_lost = !holds_up_ && std::abs(late - std::round(late)) < kOnTime;
  const double least = std::ceil(elapsed.least_s / cycle_s() - kRound);
  const double longest = std::floor(elapsed.most_s / cycle_s() + kRound);
  const double likely = std::max(std::min(others_lost ? most : 1, longest), least);
  const auto cycles = static_cast<std::int64_t>(std::clamp(likely, 1.0, most));
  const std::int64_t number = last_number_ + cycles;
  const Arrival newest{number,
                       arrival_s(arrival) - to_seconds(cycle_) * static_cast<double>(number)};
  const double below_s = std::min(0.0, offset_s(newest) - lowest_s_);
  const Time stamp = *first_ + from_seconds(line_s(number) + below_s);
  return {std::max(stamp, last_stamp_ + kLeastApart), cycles * cycle_, arrival - last_arrival_};
}

void ReportClock::take(Time arrival, const Departure& departure) {
  const bool at_once = first_ && 2 * departure.gap < cycle_;
  if (!first_) {
    first_ = arrival;
  }
  last_number_ += departure.apart / cycle_;
  last_arrival_ = arrival;
  last_stamp_ = departure.stamp;
  const double cycles_s = to_seconds(cycle_) * static_cast<double>(last_number_);
  arrivals_.push_back({last_number_, arrival_s(arrival) - cycles_s, at_once});
  while (arrivals_.front().number < since(kSlopeFrom_s)) {
    arrivals_.pop_front();
  }
  lower();
  catch_up();
  holds_up_ = std::any_of(arrivals_.begin(), arrivals_.end(),
                          [](const Arrival& one) { return one.at_once; });
  fit();
  lower();
}

// Some were lost that seemed to be held up: what comes since is late by as many cycles, every time.
void ReportClock::catch_up() {
  if (arrivals_.size() <= kShifted) {
    return;
  }
  const auto begin = arrivals_.end() - static_cast<std::ptrdiff_t>(kShifted);
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (auto one = begin; one != arrivals_.end(); ++one) {
    least = std::min(least, lateness(*one));
    most = std::max(most, lateness(*one));
  }
  const auto cycles = static_cast<std::int64_t>(std::floor(least + kRound));
  if (cycles < 1 || most - least > kAlike) {
    return;
  }
  for (auto one = begin; one != arrivals_.end(); ++one) {
    one->number += cycles;
    one->beyond_s -= to_seconds(cycle_) * static_cast<double>(cycles);
  }
  last_number_ += cycles;
  lower();
}

// Of all lines below the arrivals the one that is nearest to them: the edge of their lower hull
// that is below their mean (Moon, Skelly, Towsley 1999). What it rises by is believed where that is
// more than the arrivals scatter, and none is held up.
void ReportClock::fit() {
  slope_s_ = 0;
  const std::int64_t span = arrivals_.back().number - arrivals_.front().number;
  if (holds_up_ || span < kFewest) {
    return;
  }
  std::vector<Arrival> hull;
  double mean = 0;
  for (const Arrival& one : arrivals_) {
    mean += static_cast<double>(one.number) / static_cast<double>(arrivals_.size());
    const auto above = [&] {
      const Arrival& from = hull[hull.size() - 2];
      const Arrival& middle = hull.back();
      return (middle.beyond_s - from.beyond_s) * static_cast<double>(one.number - from.number) >=
             (one.beyond_s - from.beyond_s) * static_cast<double>(middle.number - from.number);
    };
    while (hull.size() >= 2 && above()) {
      hull.pop_back();
    }
    hull.push_back(one);
  }
  const auto to = std::find_if(hull.begin() + 1, hull.end() - 1, [&](const Arrival& one) {
    return static_cast<double>(one.number) >= mean;
  });
  const Arrival& from = *(to - 1);
  const double slope_s =
      (to->beyond_s - from.beyond_s) / static_cast<double>(to->number - from.number);
  double scatter_s = 0;
  for (const Arrival& one : arrivals_) {
    const double line = from.beyond_s + slope_s * static_cast<double>(one.number - from.number);
    scatter_s += (one.beyond_s - line) / static_cast<double>(arrivals_.size());
  }
  if (std::abs(slope_s) * static_cast<double>(span) > kSteep * scatter_s) {
    const double most_s = kSlopeAtMost * to_seconds(cycle_);
    slope_s_ = std::clamp(slope_s, -most_s, most_s);
  }
}

}  // namespace panoptes::hw
