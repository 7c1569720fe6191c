// SPDX-License-Identifier: BSD-3-Clause
#include "core/plan/reaction.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace panoptes {
namespace {

constexpr double kMemory_s = 5;

}  // namespace

Reaction::Reaction(const Timing& platform) : platform_(platform) { measure(); }

void Reaction::decide(Time stamp) {
  if (decided_ && stamp > last_) {
    cycles_.push_back({stamp, to_seconds(stamp - last_)});
    while (to_seconds(stamp - cycles_.front().end) > kMemory_s) {
      cycles_.pop_front();
    }
    measure();
  }
  last_ = stamp;
  decided_ = true;
}

void Reaction::measure() {
  const double period_s = to_seconds(platform_.period);
  cycle_s_ = longest_s_ = period_s;
  if (!cycles_.empty()) {
    std::vector<double> lengths_s;
    for (const Cycle& cycle : cycles_) {
      lengths_s.push_back(cycle.length_s);
    }
    const auto middle = lengths_s.begin() + static_cast<std::ptrdiff_t>(lengths_s.size() / 2);
    std::nth_element(lengths_s.begin(), middle, lengths_s.end());
    cycle_s_ = *middle;
    longest_s_ = *std::max_element(lengths_s.begin(), lengths_s.end());
  }
  lag_s_ = to_seconds(platform_.worst_latency) + std::max(0.0, longest_s_ - period_s);
}

double stopping_distance_m(double speed_mps, double reaction_s, double max_accel_mps2) {
  return speed_mps * reaction_s + speed_mps * speed_mps / (2 * max_accel_mps2);
}

double speed_that_stops_mps(double distance_m, double reaction_s, double max_accel_mps2) {
  // the positive root of v^2 / 2a + v t = d, in the form that loses no digits
  const double d = std::max(0.0, distance_m);
  const double root = std::sqrt(reaction_s * reaction_s + 2 * d / max_accel_mps2) + reaction_s;
  return root > 0 ? 2 * d / root : 0.0;
}

}  // namespace panoptes
