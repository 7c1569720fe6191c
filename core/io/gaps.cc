// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/gaps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace panoptes {
namespace {

constexpr double kByChance = 0.01;  // of such runs in a recording

// How many periods lie whole between the two, the first and the last left out.
std::size_t missing_between(Time from, Time to, Duration period) {
  const double periods = std::round(to_seconds(to - from) / to_seconds(period));
  return periods > 1 ? static_cast<std::size_t>(periods) - 1 : 0;
}

}  // namespace

Duration median_period(const std::vector<Time>& stamps) {
  std::vector<Duration> periods;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    periods.push_back(stamps[i] - stamps[i - 1]);
  }
  if (periods.empty()) {
    return Duration{};
  }
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  return *middle;
}

Regularity regularity(const std::vector<Time>& stamps, Time begin, Time end) {
  Regularity found;
  found.period = median_period(stamps);
  if (found.period.count() <= 0) {
    return found;
  }
  std::vector<Gap> runs;
  const auto add = [&](Time from, Time to, std::size_t next) {
    if (const std::size_t missing = missing_between(from, to, found.period); missing > 0) {
      found.missing += missing;
      runs.push_back({from, to, missing, next});
    }
  };
  // what would have come at the ends is missing too
  add(begin - found.period, stamps.front(), 0);
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    add(stamps[i - 1], stamps[i], i);
  }
  add(stamps.back(), end + found.period, stamps.size());
  const auto all = static_cast<double>(stamps.size() + found.missing);
  const double share = static_cast<double>(found.missing) / all;
  for (const Gap& run : runs) {
    if (all * std::pow(share, static_cast<double>(run.missing)) < kByChance) {
      found.gaps.push_back(run);
    }
  }
  for (Gap& gap : found.gaps) {
    gap.from = std::max(gap.from, begin);
    gap.to = std::min(gap.to, end);
  }
  return found;
}

std::string spelt(const Gap& gap, const Regularity& regularity, const std::string& what) {
  return fmt::format("no {} for {:.2f} s, from {:.2f} to {:.2f} s: {} missing, at {:.1f} a second",
                     what, to_seconds(gap.to - gap.from), to_seconds(gap.from.time_since_epoch()),
                     to_seconds(gap.to.time_since_epoch()), gap.missing, regularity.rate_hz());
}

}  // namespace panoptes
