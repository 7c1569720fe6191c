// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/calib/map_alignment.h"
#include "core/calib/similarity.h"

namespace panoptes {

/// How all maps lie in the first one, by alignments of pairs of them.
struct AlignedMaps {
  struct Rejected {
    std::size_t alignment = 0;  ///< of those given
    std::string why;            ///< in words, with the cameras' names
  };
  std::vector<std::optional<Similarity>> S_first_map;  ///< empty of one that nothing leads to
  std::vector<bool> is_believed;                       ///< by alignment
  std::vector<Rejected> rejected;
  std::vector<std::size_t> doubtful;  ///< alignments of no cycle: nothing else says the same
};

/// The thesis's way (4.3.5): from the first map to the one that has most in common with it, from
/// there to the one of the others that has most in common with that, and so on.
AlignedMaps chained(std::size_t maps, const std::vector<MapAlignment>& alignments,
                    const std::vector<std::string>& names);

/// Alignments as a graph: round a cycle they must lead back to where it began, as far as they are
/// known and maps are straight. Of those that break cycles, the one that breaks most and closes
/// fewest is rejected, and so on until all that are left close; of several alike, the one that
/// fewest points agree on. The first map is then joined with the others over those that most points
/// agree on.
AlignedMaps checked_by_cycles(std::size_t maps, const std::vector<MapAlignment>& alignments,
                              const std::vector<std::string>& names);

}  // namespace panoptes
