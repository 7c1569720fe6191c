// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/pose2.h"

namespace panoptes {

/// cross_matrix(a) * b = a x b.
inline Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace panoptes
