// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/map/fusion.h"

namespace panoptes {

/// The grids without the floor behind what any of them found to stand: a wall above a skirting
/// board of the floor's colour is found from near by, and hides what was seen there from elsewhere,
/// before and after. A place counts that two sightings agree on and no body has been. Takes
/// milliseconds a grid.
std::vector<PlacedGrid> without_shadows(std::span<const PlacedGrid> grids);

}  // namespace panoptes
