// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "apps/study/study.h"
#include "apps/trials/tables.h"

namespace panoptes {

/// What a line of a study's `against_first` says of the runs of one rig, seed by seed.
struct RigComparison {
  std::string line;
  int pairs = 0;  ///< 0: no two runs have the figure
  double mean = 0;
  double bound = 0;  ///< that the true difference surely keeps to, 95 %; of two pairs or more
  double detectable =
      0;  ///< a true difference of this shows four times out of five that the line holds
  bool holds = false;  ///< by that bound, of two pairs or more
};

/// A line each, of one group; empty where it is of the first rig, or that one has not been run.
std::vector<RigComparison> compare_with_first(const Study& study,
                                              const std::vector<TrialGroup>& groups,
                                              const TrialGroup& group);

/// All of them in Markdown; empty where nothing is compared.
std::string comparison_page(const Study& study, const std::vector<TrialGroup>& groups);

}  // namespace panoptes
