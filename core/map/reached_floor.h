// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "core/geometry/pose2.h"
#include "core/map/occupancy.h"

namespace panoptes {

/// What is free and hangs together with the robot's way by passages of at least `passage_m`, with
/// the margins of it that are narrower; other free cells become unknown. Through cracks between
/// things, and past edges that hide no floor by mistake, free space leaks in fans that no way leads
/// to. A map without any of `way_map` on free floor is left as it is.
OccupancyMap reached_floor(OccupancyMap map, std::span<const Vec2> way_map, double passage_m);

}  // namespace panoptes
