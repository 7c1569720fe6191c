// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "apps/report/finished_run.h"
#include "apps/report/recorder.h"
#include "apps/report/run_figures.h"
#include "core/io/csv.h"

namespace panoptes {

/// A run as it is read from the directory that it left.
struct SavedRun {
  std::filesystem::path folder;
  FinishedRun run;
  CsvTable loops;            ///< loops.csv
  std::string metrics_json;  ///< as it was
};

/// Throws ConfigError, with the file and line where there is one, for what is missing or wrong.
SavedRun read_run(const std::filesystem::path& folder);

/// Reports the run again with this truth: every figure and file that needs it, and can be known
/// from what the run left, is found anew, and metrics.json is replaced last. What an earlier truth
/// said is gone; what is known of how the run itself ended stays as `evaluated`.
RunReport report_with(const SavedRun& left, const RunTruth& truth);

}  // namespace panoptes
