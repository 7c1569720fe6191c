// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "apps/place/rig_sweep.h"

namespace panoptes {

/// Scores rigs that are to be tried; as many come back, in their order.
using ScoreRigs = std::function<std::vector<SweptRig>(std::vector<PlacementPoint>)>;

/// What is to be as small as can be about a rig, a number for each objective.
using CostsOfRig = std::function<std::vector<double>(const SweptRig&)>;

/// Rigs bred for the Pareto set of their costs by NSGA-II (Deb et al. 2002, the one of pagmo2), in
/// the order in which they were tried, each of them once. The same for any number of jobs. Throws
/// ConfigError where the study has a single objective.
std::vector<SweptRig> bred_rigs(const PlacementStudy& study, const Nsga2Sweep& sweep,
                                const ScoreRigs& score, const CostsOfRig& costs);

}  // namespace panoptes
