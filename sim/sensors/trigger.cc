// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/trigger.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

constexpr double kWithoutCameras_hz = 15;
// Trigger times of one camera keep their order whatever the jitter.
constexpr double kMostJitter = 0.4;

/// The name and the group of a camera; null when no group names it.
const std::pair<const std::string, TriggerGroup>* group_of(const TriggerOptions& options,
                                                           const std::string& camera) {
  for (const auto& entry : options.groups) {
    const std::vector<std::string>& members = entry.second.cameras;
    if (std::find(members.begin(), members.end(), camera) != members.end()) {
      return &entry;
    }
  }
  return nullptr;
}

}  // namespace

void bind(Fields& f, TriggerGroup& o) {
  f.needed("cameras", o.cameras);
  f.require(!f.present("cameras") || !o.cameras.empty(), "cameras",
            "must name at least one camera");
  f("offset_s", o.offset_s, between(0, 60));
  f("period_error", o.period_error, between(-0.1, 0.1));
  f("jitter_s", o.jitter_s, between(0, 1));
  f("drops", o.drops, between(0, 1));
}

void bind(Fields& f, TriggerOptions& o) {
  f("latency_s", o.latency_s, between(0, 10));
  f("groups", o.groups);
}

std::vector<KeyFault> trigger_faults(const TriggerOptions& options, const Rig& rig) {
  std::vector<std::string> known;
  for (const auto& [name, camera] : rig.cameras) {
    known.push_back(name);
  }
  std::vector<KeyFault> faults;
  std::map<std::string, std::string> named_by;
  for (const auto& [name, group] : options.groups) {
    const std::string key = "groups." + name + ".cameras";
    for (const std::string& camera : group.cameras) {
      if (!rig.cameras.contains(camera)) {
        const std::string near = nearest_word(camera, known);
        faults.push_back(
            {key, "the rig has no camera " + camera +
                      (near.empty() ? "; name one of the rig's" : "; did you mean " + near + "?")});
        continue;
      }
      const auto [other, is_new] = named_by.emplace(camera, name);
      if (!is_new) {
        faults.push_back({key, camera + " is in the group " + other->second +
                                   " already; a camera has one clock"});
      }
    }
  }
  return faults;
}

Trigger::Trigger(const TriggerOptions& options, const Rig& rig, const Rng& rng) {
  PANOPTES_CHECK(trigger_faults(options, rig).empty(), "the groups and the rig go together");
  const auto clock_of = [&](const std::string& camera, double rate_hz, const std::string& name,
                            const TriggerGroup& group) {
    double shortest_s = 1 / rate_hz;
    for (const std::string& other : group.cameras) {
      shortest_s = std::min(shortest_s, 1 / rig.cameras.at(other).rate_hz);
    }
    return Clock{camera,
                 rate_hz,
                 group,
                 shortest_s,
                 rng.fork("jitter").fork(name),
                 rng.fork("drops").fork(camera)};
  };
  for (const auto& [camera, properties] : rig.cameras) {
    if (properties.rate_hz == 0) {
      continue;
    }
    const auto* const group = group_of(options, camera);
    clocks_.push_back(group == nullptr
                          ? clock_of(camera, properties.rate_hz, "", {})
                          : clock_of(camera, properties.rate_hz, group->first, group->second));
    if (clocks_.back().rate_hz > clocks_[lead_].rate_hz) {
      lead_ = clocks_.size() - 1;
    }
  }
  if (clocks_.empty()) {
    TriggerGroup nothing_taken;
    nothing_taken.drops = 1;
    clocks_.push_back(clock_of("", kWithoutCameras_hz, "", nothing_taken));
  }
  next_ = gather();
}

Time Trigger::trigger_time(const Clock& clock, std::int64_t number) {
  const double nominal_ns = static_cast<double>(number) * 1e9 / clock.rate_hz;
  std::int64_t ns = std::llround(nominal_ns * (1 + clock.group.period_error)) +
                    from_seconds(clock.group.offset_s).count();
  if (clock.group.jitter_s > 0) {
    // Drawn once for the instant, so that cameras of any rate jitter alike at one trigger pulse.
    Rng draw = clock.jitter_rng.fork(std::to_string(ns));
    const double most_s = kMostJitter * clock.shortest_period_s;
    ns += from_seconds(std::clamp(draw.normal(0, clock.group.jitter_s), -most_s, most_s)).count();
  }
  return Time(Duration(std::max<std::int64_t>(0, ns)));
}

bool Trigger::dropped(const Clock& clock, std::int64_t number) {
  return clock.group.drops > 0 &&
         clock.drop_rng.fork(std::to_string(number)).uniform() < clock.group.drops;
}

FrameSet Trigger::gather() {
  FrameSet set;
  set.stamp = trigger_time(clocks_[lead_], clocks_[lead_].next);
  for (Clock& clock : clocks_) {
    for (Time stamp = trigger_time(clock, clock.next); stamp <= set.stamp;
         stamp = trigger_time(clock, clock.next)) {
      if (dropped(clock, clock.next)) {
        set.pictures.erase(clock.camera);
      } else {
        set.pictures[clock.camera] = {stamp, clock.next};
      }
      ++clock.next;
    }
  }
  return set;
}

Duration Trigger::period() const { return Duration(std::llround(1e9 / clocks_[lead_].rate_hz)); }

void Trigger::advance() { next_ = gather(); }

}  // namespace panoptes::sim
