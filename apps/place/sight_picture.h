// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "apps/place/placed_rig.h"

namespace panoptes {

/// The floor around the robot from above, x up the page: what each camera sees in its colour, the
/// paler the coarser; edges of what is mapped; the body, and the distance within which it stands
/// from full speed. 8-bit BGR.
cv::Mat sight_picture(const PlacedRig& placed, const PlaceOptions& options);

}  // namespace panoptes
