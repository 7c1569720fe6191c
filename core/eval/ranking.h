// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/eval/statistics.h"

namespace panoptes {

/// A score of one contender, by seed.
using ScoreBySeed = std::map<std::uint64_t, double>;

/// Where a contender stands among others by one score.
struct Standing {
  int rank = 0;  ///< 1 is the best; equals share a rank
  MeanInterval mean;
  /// It may be as good as the best one: by runs of the same seeds it is not shown to be worse (5 %,
  /// over all contenders together). So is the best one itself. That the best is chosen by the same
  /// runs is not corrected for: among eight that are all the same some show in one study of ten.
  bool not_distinguishable_from_best = true;
  /// A true difference from the best one of this size shows about four times out of five, whatever
  /// the other contenders do. Empty of the best one itself, of so few seeds that no size would
  /// show, and where all pairs differ by the same.
  std::optional<double> detectable;
};

/// By their means over the seeds; whoever has fewer than another ranks behind it. Each is compared
/// with the best by the seeds that both have: a paired bootstrap of the signs of their differences
/// (the wild bootstrap of Liu 1988, all signs of up to 13 pairs), whose probabilities are corrected
/// as Holm (1979) says. Empty of a contender that has no value. The same values give the same
/// standings.
std::vector<std::optional<Standing>> rank(const std::vector<ScoreBySeed>& contenders,
                                          bool less_is_better);

/// Whether one contender is better than another by some score and worse by none: whoever is
/// dominated by nobody is in the Pareto set. As many costs of both, the less the better.
bool dominates(const std::vector<double>& costs, const std::vector<double>& others);

}  // namespace panoptes
