// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/eval/truth.h"
#include "core/geometry/body.h"
#include "core/geometry/pose2.h"
#include "sim/route.h"

namespace panoptes::sim {

/// A path along every aisle in both directions, along the middle of each, for a disc that keeps
/// clear of what `body_layer` holds. It visits places spread over all floor that the start is
/// connected to, the nearest new one next; now and then it turns back to an earlier place before it
/// goes on, so that ground driven before and new ground take turns. When it has been everywhere it
/// drives the places backwards and forwards, until it is long enough. Throws ConfigError where
/// there is nowhere to go.
std::vector<Waypoint> tour(const TourOptions& options, const TruthLayer& body_layer,
                           const Body& body, const Vec2& start_scene);

}  // namespace panoptes::sim
