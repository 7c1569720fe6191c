// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/geometry/pose2.h"
#include "sim/world/layers.h"

namespace panoptes::sim {

inline Outline box(const std::string& object, double x_low, double y_low, double x_high,
                   double y_high) {
  return {object, {{x_low, y_low}, {x_high, y_low}, {x_high, y_high}, {x_low, y_high}}};
}

/// Four walls of 0.1 m around [0, size_m] x [0, size_m].
inline std::vector<Outline> walls(double size_m) {
  return {box("south wall", -0.1, -0.1, size_m + 0.1, 0),
          box("east wall", size_m, 0, size_m + 0.1, size_m),
          box("north wall", -0.1, size_m, size_m + 0.1, size_m + 0.1),
          box("west wall", -0.1, 0, 0, size_m)};
}

}  // namespace panoptes::sim
