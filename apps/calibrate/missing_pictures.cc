// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/missing_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "core/base/median.h"

namespace panoptes {

std::string missing_pictures(const std::string& camera, const std::vector<Time>& stamps) {
  constexpr double kEven = 0.2;         // of the period, by which a picture may be late
  constexpr double kMostlyEven = 0.66;  // of all pictures: others stop and start
  std::vector<double> apart_s;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    apart_s.push_back(to_seconds(stamps[i] - stamps[i - 1]));
  }
  if (apart_s.size() < 2) {
    return "";
  }
  const double period_s = median(std::vector<double>(apart_s));
  std::size_t even = 0;
  long missing = 0;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < apart_s.size(); ++i) {
    even += std::abs(apart_s[i] - period_s) < kEven * period_s ? 1 : 0;
    missing += std::max(0L, std::lround(apart_s[i] / period_s) - 1);
    longest = apart_s[i] > apart_s[longest] ? i : longest;
  }
  if (missing == 0 ||
      static_cast<double>(even) < kMostlyEven * static_cast<double>(apart_s.size())) {
    return "";
  }
  return fmt::format(
      "{}: {} of {} pictures are missing, most of them in {:.1f} s from {:.1f} s on: what is "
      "followed from picture to picture may be lost there; copy the recording again, or record it "
      "so that none is dropped",
      camera, missing, missing + static_cast<long>(stamps.size()), apart_s[longest],
      to_seconds(stamps[longest] - stamps.front()));
}

}  // namespace panoptes
