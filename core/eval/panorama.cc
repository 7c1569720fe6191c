// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/panorama.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/geometry/pose2.h"

namespace panoptes {

PanoramaSight panorama_sight(const RigSight& sight) {
  constexpr int kHeadings = PanoramaSight::kHeadings;
  constexpr int kBands = PanoramaSight::kBands;
  const double lowest = std::sin(deg_to_rad(-10));
  PanoramaSight out;
  out.seen.reserve(static_cast<std::size_t>(kHeadings) * kBands);
  // bands of equal solid angle, which is that of sin(elevation)
  for (int band = 0; band < kBands; ++band) {
    const double z = lowest + (band + 0.5) / kBands * (1 - lowest);
    const double level = std::sqrt(1 - z * z);
    for (int k = 0; k < kHeadings; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.5) / kHeadings;
      out.seen.push_back(
          sight.seeing_direction({level * std::cos(angle), level * std::sin(angle), z}));
    }
  }
  return out;
}

double common_share(const PanoramaSight& panorama, CameraSet cameras, int turned) {
  constexpr int kHeadings = PanoramaSight::kHeadings;
  int common = 0;
  for (int band = 0; band < PanoramaSight::kBands; ++band) {
    const auto seen = [&](int heading) {
      const int at = band * kHeadings + heading % kHeadings;
      return (panorama.seen[static_cast<std::size_t>(at)] & cameras) != 0;
    };
    for (int k = 0; k < kHeadings; ++k) {
      common += seen(k) && seen(k + turned) ? 1 : 0;
    }
  }
  return static_cast<double>(common) / static_cast<double>(panorama.seen.size());
}

OverlapSight overlap_sight(const RigSight& sight) {
  constexpr int kDirections = 4000;  // on a spiral with equal areas
  const std::size_t cameras = sight.cameras().size();
  std::vector<int> seen(cameras, 0);
  std::vector<int> both(cameras * cameras, 0);
  int any = 0;
  int twice = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections;
    const double level = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const CameraSet set =
        sight.seeing_direction({level * std::cos(angle), level * std::sin(angle), z});
    any += set != 0 ? 1 : 0;
    twice += std::popcount(set) > 1 ? 1 : 0;
    for (std::size_t a = 0; a < cameras; ++a) {
      if ((set & camera_bit(a)) == 0) {
        continue;
      }
      ++seen[a];
      for (std::size_t b = a + 1; b < cameras; ++b) {
        both[a * cameras + b] += (set & camera_bit(b)) != 0 ? 1 : 0;
      }
    }
  }
  OverlapSight out;
  out.seen_share = static_cast<double>(any) / kDirections;
  out.twice_share = static_cast<double>(twice) / kDirections;
  for (std::size_t a = 0; a < cameras; ++a) {
    for (std::size_t b = a + 1; b < cameras; ++b) {
      if (both[a * cameras + b] > 0) {
        out.overlaps.push_back(
            {a, b, static_cast<double>(both[a * cameras + b]) / std::min(seen[a], seen[b])});
      }
    }
  }
  return out;
}

}  // namespace panoptes
