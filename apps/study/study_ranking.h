// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/study/study.h"
#include "apps/study/study_table.h"
#include "core/eval/ranking.h"

namespace panoptes {

/// Where each rig stands among those that are tried with it, in one mission under one rung.
struct StudyRanking {
  std::vector<StudyScore> scores;  ///< of the study; where it names neither scores nor
                                   ///< a figure what its tables show
  std::vector<std::vector<std::optional<Standing>>> standings;  ///< by cell, by score
  std::vector<bool> pareto;  ///< by cell: nobody is better by one score and worse by none
};

StudyRanking rank_rigs(const Study& study, const std::vector<StudyRun>& runs);

/// A table in Markdown for each mission and rung, the best rig by the first score on top. Empty
/// where the study names no scores.
std::string ranking_page(const Study& study, const std::vector<StudyRun>& runs,
                         const StudyRanking& ranking);

}  // namespace panoptes
