// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/pose2.h"

namespace panoptes {

/// The pose on the way between two: along the arc of a constant velocity of the body, which may
/// slide sideways. `share` 0 gives `T_a_from`, 1 gives `T_a_to`.
Pose2 on_arc(const Pose2& T_a_from, const Pose2& T_a_to, double share);

}  // namespace panoptes
