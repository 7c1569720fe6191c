// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/study/placement_study.h"
#include "core/camera/rig.h"

namespace panoptes {

/// One rig of a study, and how it did.
struct SweptRig {
  PlacementPoint point;
  std::string refused;                        ///< why it cannot be; empty when it can
  std::vector<std::optional<double>> scores;  ///< of the sweep's `names`; empty when refused
  std::vector<std::size_t> broken;            ///< lines of `require` that it does not hold
  bool pareto = false;  ///< good, and no good one is better in an objective and worse in none
  bool good() const { return refused.empty() && broken.empty(); }
};

struct RigSweep {
  std::vector<NamedScore> names;        ///< without values
  std::vector<std::size_t> objectives;  ///< of `names`
  std::vector<SweptRig> rigs;           ///< in the study's order
  /// Rigs that can be, the best first: those that hold every line; of these the Pareto set; then by
  /// the objectives in their order.
  std::vector<std::size_t> ranked;
  bool cut_short = false;  ///< there were more rigs to try
};

/// The rig of a point, as its file has it but for the study's settings.
Rig rig_of(const PlacementStudy& study, const PlacementPoint& point);

/// Which of them to drive: at most so many rigs, of `rigs`, the best ranked first. Of a Pareto set
/// neighbours would do much the same, so that each next one is the farthest from those taken, the
/// span of every objective in the set counting as one (as in Gonzalez, "Clustering to minimize the
/// maximum intercluster distance", 1985); then the others as they are ranked.
std::vector<std::size_t> promoted_rigs(const RigSweep& sweep, std::size_t most);

/// Scores all rigs of a study by geometry, or those that its search breeds. The same for any number
/// of jobs. `progress` is told the share that is done. Where `stop` says so the rigs are those that
/// were scored until then. Throws ConfigError where a setting makes no rig, or a score that the
/// study names is none.
RigSweep sweep_rigs(
    const PlacementStudy& study, int jobs, const std::function<void(double done)>& progress,
    const std::function<bool()>& stop = [] { return false; });

/// Throws ConfigError where a score that the study names is none, or a setting makes no rig, each
/// value of a parameter tried once. Scores nothing.
void check_placement_study(const PlacementStudy& study);

/// Whether the study names calibratability, which takes far longer than all other scores of a rig.
bool asks_calibratability(const PlacementStudy& study);

}  // namespace panoptes
