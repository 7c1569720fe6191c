// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/place/placed_rig.h"

namespace panoptes {

/// metrics.json of rigs that were scored, as text. What a rig has not is absent.
std::string place_metrics(const std::vector<PlacedRig>& rigs, const PlaceOptions& options,
                          const std::string& version);

}  // namespace panoptes
