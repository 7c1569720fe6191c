// SPDX-License-Identifier: BSD-3-Clause
#include "core/explore/given_up.h"

#include <algorithm>
#include <cmath>

namespace panoptes {
namespace {

// A robot of half a metre stands at most this far from what decides whether it can stand there.
constexpr double kAround_m = 0.5;
constexpr double kSample_m = 0.05;
constexpr int kSamples = static_cast<int>(2 * kAround_m / kSample_m) + 1;  // a side

// A tenth of such a robot's own area.
constexpr int kChanged = 8;

// A square of samples, turned with the place as the floor about it is.
template <class Each>
void for_each_sample(const Pose2& T_map_place, const Each& each) {
  for (int j = 0; j < kSamples; ++j) {
    for (int i = 0; i < kSamples; ++i) {
      each(i, j, T_map_place * Vec2(i * kSample_m - kAround_m, j * kSample_m - kAround_m));
    }
  }
}

std::vector<Cell> sampled(const Pose2& T_map_place, const GivenUp::Known& known) {
  std::vector<Cell> cells;
  cells.reserve(static_cast<std::size_t>(kSamples) * kSamples);
  for_each_sample(T_map_place, [&](int, int, const Vec2& p) { cells.push_back(known(p)); });
  return cells;
}

// Samples whose neighbours were none of what they are now: an edge that has moved by a sample is
// the same edge.
bool has_changed(const std::vector<Cell>& before, const std::vector<Cell>& now) {
  int changed = 0;
  for (int j = 1; j + 1 < kSamples; ++j) {
    for (int i = 1; i + 1 < kSamples; ++i) {
      const Cell cell = now[static_cast<std::size_t>(j) * kSamples + i];
      bool was_near = false;
      for (int dj = -1; dj <= 1; ++dj) {
        for (int di = -1; di <= 1; ++di) {
          was_near =
              was_near || before[static_cast<std::size_t>(j + dj) * kSamples + i + di] == cell;
        }
      }
      changed += was_near ? 0 : 1;
    }
  }
  return changed >= kChanged;
}

}  // namespace

GivenUp::GivenUp(double within_m, double for_s) : within_m_(within_m), for_s_(for_s) {}

void GivenUp::add(Time now, const Pose2& T_map_place, const Known& known,
                  std::span<const Pose2> T_map_keyframes) {
  double for_s = for_s_;
  const auto again = std::find_if(places_.begin(), places_.end(), [&](const Place& place) {
    return (place.at.p_map() - T_map_place.position()).norm() <= within_m_;
  });
  if (again != places_.end()) {
    for_s = 2 * again->for_s;
    places_.erase(again);
  }
  places_.push_back({AnchoredPose(T_map_place, T_map_keyframes), sampled(T_map_place, known),
                     now + from_seconds(for_s), for_s});
}

void GivenUp::update(Time now, const Known& known, std::span<const Pose2> T_map_keyframes) {
  for (Place& place : places_) {
    place.at.follow(T_map_keyframes);
    place.left_alone =
        place.left_alone &&
        (now < place.until || !has_changed(place.around, sampled(place.at.T_map_place(), known)));
  }
}

void GivenUp::reopen_changed(const Known& known) {
  for (Place& place : places_) {
    place.left_alone =
        place.left_alone && !has_changed(place.around, sampled(place.at.T_map_place(), known));
  }
}

bool GivenUp::try_again() {
  bool some = false;
  for (Place& place : places_) {
    if (place.left_alone && place.for_s <= for_s_) {
      place.left_alone = false;
      some = true;
    }
  }
  return some;
}

bool GivenUp::contains(const Vec2& p_map) const {
  return std::any_of(places_.begin(), places_.end(), [&](const Place& place) {
    return place.left_alone && (place.at.p_map() - p_map).norm() <= within_m_;
  });
}

std::vector<Vec2> GivenUp::places_map() const {
  std::vector<Vec2> places;
  for (const Place& place : places_) {
    if (place.left_alone) {
      places.push_back(place.at.p_map());
    }
  }
  return places;
}

}  // namespace panoptes
