// SPDX-License-Identifier: BSD-3-Clause
#include "hw/pioneer/report_clock.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace panoptes::hw {
namespace {

constexpr double kSlopeFrom_s = 30;   // arrivals that tell how long a cycle truly is,
constexpr double kOffsetFrom_s = 10;  // and when they leave: a wrong count is forgotten by then
constexpr double kSlopeAtMost = 0.2;  // of a cycle: a server that keeps its time badly
constexpr std::int64_t kFewest = 30;  // arrivals, for a slope
constexpr double kSteep = 4;          // rising by so many times what they scatter
constexpr double kRound = 0.3;        // of a cycle, by which the time of a distance may be wrong
constexpr Duration kLeastApart = std::chrono::milliseconds(1);

// How late reports are is counted in quarters of a cycle, the last one for all that are later.
constexpr double kPart = 0.25;
constexpr std::size_t kParts = 40;
constexpr double kForget = 0.997;  // of that with every report: the last half a minute counts
constexpr double kAtFirst = 5;     // reports on time, which it begins with
constexpr double kSeldom = 1e-4;   // of any lateness that was not seen yet
constexpr double kEarly = 0.1;     // of a cycle: the line is not as exact as that
// How likely it is that none is lost before a report, or k: as often as distances have told, at
// least
constexpr double kNoneLost = 0.95;
constexpr double kOneLost = 0.03;          // and k of them by so much over k squared
constexpr double kSeldomLost = 5e-5;       // where some are held up: that is why they are late
constexpr double kUnseen = 0.1;            // of their lateness, which is of no kind seen yet, but
constexpr double kHeldUp = 1.5;            // by so many cycles in the mean
constexpr double kOnTime = 0.15;           // of a cycle
constexpr std::size_t kFewArrivals = 5;    // on time, which show a link that holds nothing up
constexpr std::size_t kManyArrivals = 40;  // of which one is likely to have been held up by little
constexpr std::size_t kNearest = 8;        // arrivals, for how far the fastest is from the end
constexpr std::size_t kNewLink = 10;  // arrivals, of which the first that are held up teach anew
constexpr double kNotItsDistance = 1e-9;  // that a report's distance tells of another time
constexpr double kHardly = 1e-6;          // what is believed less is forgotten
constexpr std::int64_t kMostLost = 100;

}  // namespace

double ReportClock::arrival_s(Time arrival) const { return to_seconds(arrival - *first_); }

double ReportClock::cycle_s() const { return to_seconds(cycle_) + slope_s_; }

double ReportClock::offset_s(const Arrival& one) const {
  return one.beyond_s - slope_s_ * static_cast<double>(one.number);
}

double ReportClock::line_s(std::int64_t number) const {
  return lowest_s_ + cycle_s() * static_cast<double>(number);
}

double ReportClock::likely(double late) const {
  const double l = std::max(0.0, late);
  // Between the middles of two parts.
  const double at = std::max(0.0, l / kPart - 0.5);
  const auto part = std::min(static_cast<std::size_t>(at), kParts - 1);
  const double share = std::min(at - static_cast<double>(part), 1.0);
  const double count = (1 - share) * late_[part] + share * late_[std::min(part + 1, kParts - 1)];
  const double seen = count / std::accumulate(late_.begin(), late_.end(), 0.0);
  const double unseen = holds_up_ ? kUnseen : 0;
  const double at_all = kPart / kHeldUp * std::exp(-l / kHeldUp);
  return ((1 - unseen) * seen + unseen * at_all) * (late < 0 ? std::exp(late / kEarly) : 1);
}

void ReportClock::learn(double late) {
  // One that comes early says that all others were later than was thought.
  const auto earlier = static_cast<std::ptrdiff_t>(std::lround(std::max(0.0, -late) / kPart));
  const std::ptrdiff_t by = std::min(earlier, static_cast<std::ptrdiff_t>(kParts));
  std::move_backward(late_.begin(), late_.end() - by, late_.end());
  std::fill(late_.begin(), late_.begin() + by, kSeldom);
  for (double& one : late_) {
    one = std::max(kForget * one, kSeldom);
  }
  const auto part = static_cast<std::size_t>(std::max(0.0, late / kPart));
  late_[std::min(part, kParts - 1)] += 1;
}

std::int64_t ReportClock::since(double last_s) const {
  return last_number_ - static_cast<std::int64_t>(std::lround(last_s / to_seconds(cycle_)));
}

// To the highest line of the slope that no arrival of the last seconds lies below. The fastest of
// them took longer than the least that is possible, by about what the next ones are apart (the end
// of a distribution from its least values: Robson, Whitlock 1964).
void ReportClock::lower() {
  const std::int64_t oldest = since(kOffsetFrom_s);
  std::vector<double> offsets;
  for (auto one = arrivals_.rbegin(); one != arrivals_.rend() && one->number >= oldest; ++one) {
    offsets.push_back(offset_s(*one));
  }
  lowest_s_ = *std::min_element(offsets.begin(), offsets.end());
  end_below_s_ = 0;
  if (offsets.size() >= kNearest) {
    std::nth_element(offsets.begin(), offsets.begin() + kNearest - 1, offsets.end());
    end_below_s_ = (offsets[kNearest - 1] - lowest_s_) / static_cast<double>(kNearest - 1);
  }
}

Duration ReportClock::longest_hold() const {
  double longest_s = 0;
  for (const Arrival& one : arrivals_) {
    longest_s = std::max(longest_s, offset_s(one) - lowest_s_);
  }
  return from_seconds(longest_s);
}

bool ReportClock::settled() const {
  if (arrivals_.size() >= kManyArrivals) {
    return true;
  }
  if (arrivals_.size() < kFewArrivals) {
    return false;
  }
  return std::all_of(arrivals_.end() - kFewArrivals, arrivals_.end(), [&](const Arrival& one) {
    return std::abs(offset_s(one) - offset_s(arrivals_.back())) < kOnTime * cycle_s();
  });
}

ReportClock::ReportClock(Duration cycle) : cycle_(cycle), late_(kParts, kSeldom) {
  late_.front() = kAtFirst;
}

ReportClock::Departure ReportClock::departure(Time arrival, const Elapsed& elapsed) const {
  if (!first_) {
    return {arrival, arrival, Duration::zero(), Duration::zero()};
  }
  const double late = (arrival_s(arrival) - line_s(last_number_ + 1)) / cycle_s();
  const auto cycles_of = [&](double s) { return s / cycle_s(); };
  const double fewest = std::ceil(cycles_of(elapsed.least_s) - kRound);
  const double most = std::floor(cycles_of(elapsed.most_s) + kRound);
  // What nobody knows yet was held up, unless it is late by whole cycles.
  const bool unknown = arrivals_.size() < kNewLink && std::abs(late - std::round(late)) >= kOnTime;
  const double one_lost = std::max(lost_ / told_, holds_up_ || unknown ? kSeldomLost : kOneLost);
  // Those for whom it comes early are there as long as no other is.
  const auto latest = static_cast<std::int64_t>(std::ceil(late + 3 * kEarly));
  const std::int64_t least = least_;
  const std::int64_t greatest = std::clamp(latest, least, least + kMostLost);
  std::vector<double> belief(static_cast<std::size_t>(greatest - least + 1), 0.0);
  for (std::int64_t to = least; to <= greatest; ++to) {
    double sum = 0;
    for (std::size_t i = 0; i < belief_.size() && least_ + static_cast<std::int64_t>(i) <= to;
         ++i) {
      const auto lost = static_cast<double>(to - least_ - static_cast<std::int64_t>(i));
      const double before = lost == 0 ? kNoneLost : one_lost / (lost * lost);
      const bool fits = lost + 1 >= fewest && lost + 1 <= most;
      sum += belief_[i] * before * (fits ? 1 : kNotItsDistance);
    }
    belief[static_cast<std::size_t>(to - least)] = sum * likely(late - static_cast<double>(to));
  }
  const auto best = std::max_element(belief.begin(), belief.end());
  const double sum = std::accumulate(belief.begin(), belief.end(), 0.0);
  std::int64_t ahead = least + (best - belief.begin());
  if (!(sum > 0)) {  // so early that nothing was lost
    belief.assign(1, 1.0);
    ahead = least;
  }
  const std::int64_t number = last_number_ + 1 + ahead;
  const Arrival newest{number,
                       arrival_s(arrival) - to_seconds(cycle_) * static_cast<double>(number)};
  const double below_s = std::min(0.0, offset_s(newest) - lowest_s_);
  const Time stamp = *first_ + from_seconds(line_s(number) + below_s - end_below_s_);
  return {std::max(stamp, last_stamp_ + kLeastApart),
          stamp,
          (1 + std::max<std::int64_t>(0, ahead)) * cycle_,
          arrival - last_arrival_,
          ahead,
          std::move(belief),
          least,
          fewest <= most && most - fewest < 1 ? std::optional(fewest - 1) : std::nullopt};
}

void ReportClock::believe(const Departure& departure) {
  last_number_ += 1 + departure.ahead;
  belief_ = departure.belief;
  least_ = departure.least - departure.ahead;  // from now on it is counted from that one
  const double most = *std::max_element(belief_.begin(), belief_.end());
  while (belief_.back() <= kHardly * most) {
    belief_.pop_back();
  }
  const auto first = std::find_if(belief_.begin(), belief_.end(),
                                  [&](double one) { return one > kHardly * most; });
  least_ += first - belief_.begin();
  belief_.erase(belief_.begin(), first);
  for (double& one : belief_) {
    one /= most;
  }
}

void ReportClock::take(Time arrival, const Departure& departure) {
  const bool at_once = arrivals_.size() > 1 && 2 * departure.gap < cycle_;
  if (!first_) {
    first_ = arrival;
  } else {
    believe(departure);
    if (departure.lost) {
      told_ = kForget * told_ + 1;
      lost_ = std::max(kForget * lost_ + (*departure.lost > 0 ? 1 : 0), kSeldomLost * told_);
    }
    learn((arrival_s(arrival) - line_s(last_number_)) / cycle_s());
  }
  last_arrival_ = arrival;
  last_stamp_ = departure.stamp;
  if (at_once && !holds_up_ && arrivals_.size() < kNewLink) {
    arrivals_.clear();
    belief_ = {1.0};
    least_ = 0;
    for (std::size_t i = 0; i < kParts; ++i) {
      const double late = (static_cast<double>(i) + 0.5) * kPart;
      late_[i] = kAtFirst * kPart / kHeldUp * std::exp(-late / kHeldUp);
    }
  }
  const double cycles_s = to_seconds(cycle_) * static_cast<double>(last_number_);
  arrivals_.push_back({last_number_, arrival_s(arrival) - cycles_s, at_once});
  while (arrivals_.front().number < since(kSlopeFrom_s)) {
    arrivals_.pop_front();
  }
  lower();
  holds_up_ = std::any_of(arrivals_.begin(), arrivals_.end(),
                          [](const Arrival& one) { return one.at_once; });
  fit();
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
