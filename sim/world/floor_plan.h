// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "sim/world/load.h"
#include "sim/world/pictures.h"

namespace panoptes::sim {

/// Walls, floor and ceiling of a floor plan, three objects (the ceiling last, where it has one).
/// Throws ConfigError or IoError for a map that cannot be used.
std::vector<Object> make_floor_plan(const FloorPlanSettings& settings, Pictures& pictures);

}  // namespace panoptes::sim
