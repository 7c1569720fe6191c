// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "apps/batch/plan.h"
#include "apps/study/study_ranking.h"

namespace panoptes {

/// `scores.png`, each score over the rigs, or over the rungs where these are more, with its 95 %
/// interval; of a study that names two scores or more `pareto.png`, the rigs by the first two; and
/// `maps.png`, the map of every cell's first seed, side by side as far as they were kept.
void write_study_pictures(const TrialsOptions& options, const StudyRanking& ranking,
                          const std::vector<Trial>& trials);

}  // namespace panoptes
