// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/arc.h"

#include <cmath>

namespace panoptes {
namespace {

// Of half the angle of an arc: chord over length.
double sinc(double half_rad) {
  return std::abs(half_rad) < 1e-9 ? 1.0 : std::sin(half_rad) / half_rad;
}

}  // namespace

Pose2 on_arc(const Pose2& T_a_from, const Pose2& T_a_to, double share) {
  const Pose2 T_from_to = T_a_from.inverse() * T_a_to;
  const double half_rad = T_from_to.theta_rad / 2;
  const double chords = share * sinc(share * half_rad) / sinc(half_rad);
  // the chord of the part turns with its own half of the angle
  const Vec2 p_from = chords * (Pose2{0, 0, (share - 1) * half_rad} * T_from_to.position());
  return T_a_from * Pose2{p_from.x(), p_from.y(), share * T_from_to.theta_rad};
}

}  // namespace panoptes
