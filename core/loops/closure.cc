// SPDX-License-Identifier: BSD-3-Clause
#include "core/loops/closure.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace panoptes {
namespace {

constexpr double kOneHeading_rad = deg_to_rad(20);
constexpr std::array<std::string_view, 3> kNames{"same", "opposite", "other"};

}  // namespace

Heading heading_of(double turn_rad) {
  const double turned_rad = std::abs(wrap_angle(turn_rad));
  return turned_rad <= kOneHeading_rad                      ? Heading::kSame
         : turned_rad >= std::numbers::pi - kOneHeading_rad ? Heading::kOpposite
                                                            : Heading::kOther;
}

std::string_view name_of(Heading heading) { return kNames[static_cast<std::size_t>(heading)]; }

std::optional<Heading> heading_named(std::string_view name) {
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    if (kNames[k] == name) {
      return static_cast<Heading>(k);
    }
  }
  return std::nullopt;
}

}  // namespace panoptes
