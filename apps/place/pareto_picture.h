// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "apps/place/rig_sweep.h"

namespace panoptes {

/// Every rig of a study by its first two objectives, what is better up and to the right: those that
/// hold what is required, those that do not, and the Pareto set. A study of one objective has it
/// over the rigs' numbers. 8-bit BGR.
cv::Mat pareto_picture(const PlacementStudy& study, const RigSweep& sweep);

}  // namespace panoptes
