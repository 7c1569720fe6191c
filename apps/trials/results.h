// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "apps/trials/plan.h"

namespace panoptes {

/// Takes the figures that its folder holds; false when there are none that can be read.
bool take_metrics(Trial& trial);

/// Takes what it left where that is a whole run of these settings; else it waits to be run.
bool is_finished(Trial& trial);

/// Why it is no pass, a line each.
std::vector<std::string> faults(const Trial& trial);

/// Nothing that other trials have left is overwritten: what is there are the same runs, or fewer.
void check_what_is_there(const TrialsOptions& options, std::vector<Trial>& trials);

}  // namespace panoptes
