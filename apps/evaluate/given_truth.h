// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/report/finished_run.h"
#include "apps/report/run_figures.h"

namespace panoptes {

/// The truth as somebody else wrote it down, on a clock of its own.
struct GivenTruth {
  RunTruth known;
  std::int64_t start_unix_ns = 0;  ///< the wall instant of its time 0
  std::string name;                ///< for messages
};

/// Of a folder that ServedTruthWriter has written, or of a TUM trajectory of the body in any frame
/// that stays where it is. Of the latter no contacts and no layers are known, and its stamps are
/// seconds since the `start_unix_ns` of a metrics.json beside it, else since 1970. Throws
/// ConfigError, with the file and line where there is one.
GivenTruth read_given_truth(const std::filesystem::path& truth);

/// The truth on the run's clock, from its first frame set to its last step. `warnings` gets what
/// the user ought to know of how much of the run it tells. Throws ConfigError where the two clocks
/// cannot be matched, and where the truth does not reach from the first frame set to the last
/// keyframe. `run_name` is for messages.
RunTruth truth_during(const FinishedRun& run, const std::string& run_name, const GivenTruth& given,
                      std::vector<std::string>& warnings);

}  // namespace panoptes
