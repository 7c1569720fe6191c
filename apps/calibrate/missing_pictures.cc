// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/missing_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "core/base/median.h"

namespace panoptes {
namespace {

std::vector<double> apart(const std::vector<Time>& stamps) {
  std::vector<double> apart_s;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    apart_s.push_back(to_seconds(stamps[i] - stamps[i - 1]));
  }
  return apart_s;
}

}  // namespace

double picture_period_s(const std::vector<Time>& stamps) {
  return stamps.size() < 2 ? 0 : median(apart(stamps));
}

std::string missing_pictures(const std::string& camera, const std::vector<Time>& stamps) {
  constexpr double kEven = 0.2;         // of the period, by which a picture may be late
  constexpr double kMostlyEven = 0.66;  // of all pictures: others stop and start
  const std::vector<double> apart_s = apart(stamps);
  const double period_s = picture_period_s(stamps);
  if (apart_s.size() < 2) {
    return "";
  }
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
      "{}: {} of {} pictures are missing, the longest gap is {:.1f} s, from {:.1f} s on: what is "
      "followed from picture to picture may be lost there; copy the recording again, or record it "
      "so that none is dropped",
      camera, missing, missing + static_cast<long>(stamps.size()), apart_s[longest],
      to_seconds(stamps[longest] - stamps.front()));
}

}  // namespace panoptes
