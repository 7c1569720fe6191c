// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/eval/truth.h"

namespace panoptes {

int collisions(const Truth& truth);                ///< while moving or told to move
int collisions_while_stopped(const Truth& truth);  ///< somebody walked into a standing robot
std::optional<double> min_clearance_m(const Truth& truth);

/// Time that lies in some 60 s, with a goal set throughout, in which the true position stayed
/// within 0.5 m of where it ended. `has_goal` is one per true pose.
double stuck_s(const std::vector<TruePose>& poses, const std::vector<bool>& has_goal);

/// Whether such 60 s are the last.
bool ends_stuck(const std::vector<TruePose>& poses, const std::vector<bool>& has_goal);

}  // namespace panoptes
