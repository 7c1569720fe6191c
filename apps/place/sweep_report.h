// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "apps/place/rig_sweep.h"

namespace panoptes {

/// The best rigs of a study and how many hold what is required, as text for a terminal.
std::string sweep_table(const PlacementStudy& study, const RigSweep& sweep);

/// study.csv: a row a rig, with its parameters, whether it is good, why not, and every score.
void write_sweep_csv(const std::filesystem::path& file, const PlacementStudy& study,
                     const RigSweep& sweep);

/// metrics.json, as text.
std::string sweep_metrics(const PlacementStudy& study, const RigSweep& sweep,
                          const std::string& version);

/// The best rig's file, with its reasons before it.
std::string best_rig_file(const PlacementStudy& study, const RigSweep& sweep);

}  // namespace panoptes
