// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "apps/place/placed_rig.h"

namespace panoptes {

/// The scores of one rig with what mounting errors make of them and what is better, or of two with
/// what the second one has more and which of them is the better one by it; then what single cameras
/// cost and what the bus says. Text for a terminal.
std::string score_table(const std::vector<PlacedRig>& rigs);

}  // namespace panoptes
