// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/geometry/grid2.h"

namespace panoptes {

enum class Cell : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

/// A finished or local map of the floor in some frame; unknown outside.
using OccupancyMap = Grid2<Cell>;

}  // namespace panoptes
