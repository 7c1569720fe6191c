// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

#include "core/plan/path_search.h"

namespace panoptes {

/// A place to wait at, away from `blocked_map` where nothing gets on: whoever stands there may wait
/// for the robot to go. The farthest from them that is a few metres to drive; none where it is no
/// better than here.
std::optional<Vec2> place_to_make_room(const SearchOptions& search, const DrivableGrid& grid,
                                       const Vec2& here_map, std::span<const Vec2> blocked_map);

}  // namespace panoptes
