// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace panoptes {

/// So many in a row are missing that chance does not explain it.
struct Gap {
  Time from;  ///< what came last before it, or the beginning
  Time to;    ///< what came first after it, or the end
  std::size_t missing = 0;
  std::size_t next = 0;  ///< the index of what came first after it; the count of all at the end
};

/// How regularly something comes, by its stamps alone.
struct Regularity {
  Duration period{};  ///< the median; 0 where fewer than two came
  std::size_t missing = 0;
  std::vector<Gap> gaps;

  double rate_hz() const { return period.count() > 0 ? 1 / to_seconds(period) : 0; }
};

/// From one to the next; 0 of fewer than two.
Duration median_period(const std::vector<Time>& stamps);

/// Of stamps in the order of time, within a recording that goes on from `begin` to `end`. Where a
/// share p of all N is missing, single ones drawn by chance, N p^k runs of k are expected: a run is
/// a gap where that is below 0.01, one recording in a hundred.
Regularity regularity(const std::vector<Time>& stamps, Time begin, Time end);

/// A gap in words: what is missing, for how long, and how often it comes else.
std::string spelt(const Gap& gap, const Regularity& regularity, const std::string& what);

}  // namespace panoptes
