// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "sim/world/faults.h"
#include "sim/world/load.h"

namespace panoptes::sim {

/// A person's path against what stands in the world for ever: a body's radius must be free all
/// along. What is movable may be elsewhere by then and is not looked at. `mentions` has the places
/// of the world's objects.
void check_paths(const World& world, const std::vector<PersonSettings>& people,
                 const std::vector<std::string>& mentions, Faults& faults);

}  // namespace panoptes::sim
