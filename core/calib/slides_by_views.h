// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/calib/rig_bundle.h"
#include "core/calib/rig_costs.h"

namespace panoptes {

/// What its slides shift each point by in each view, for all that is seen, in order: by how much
/// nearer (log) and how far aside (rad, horizontally) the view is than those that are believed to
/// show the point are on the mean; each way across the mean ray, horizontally and upright.
/// `ray_start` leads from the camera to the point, of any length that grows with the distance.
/// Zero of a point that none is believed to show.
std::vector<BySlides> slides_by_views(const std::vector<RigSeen>& seen,
                                      const std::vector<Vec3>& ray_start, std::size_t points);

}  // namespace panoptes
