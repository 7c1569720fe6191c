// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/batch/plan.h"
#include "core/eval/statistics.h"

namespace panoptes {

/// What the columns of the table are, a line each, for --help.
std::string table_legend();

/// trials.csv: a row a run that is done; and timing.csv, with what each of them cost.
void write_csv(const TrialsOptions& options, const std::vector<Trial>& trials);

/// study.csv and study.md, of what is done so far; nothing where there is no study.
void write_study(const TrialsOptions& options, const std::vector<Trial>& trials);

/// The tables of study.md on stdout, and its pictures.
void report_study(const TrialsOptions& options, const std::vector<Trial>& trials);

/// The verdicts as JUnit has them.
void write_junit(const TrialsOptions& options, const std::vector<Trial>& trials);

/// The runs of one mission under one combination of settings.
struct TrialGroup {
  const TrialPoint* point = nullptr;
  std::vector<const Trial*> runs;  ///< that are done, in order of their seeds
  int passed = 0;
};
std::vector<TrialGroup> groups_of(const std::vector<Trial>& trials);

/// By how much a score of one group is larger than the other's, by the seeds that both have; empty
/// where there are none.
std::optional<PairedDifference> difference(const TrialGroup& group, const TrialGroup& other,
                                           const std::string& score);

/// metrics.json of all of them: nothing that depends on the machine, or on how they were shared
/// out.
void write_metrics(const TrialsOptions& options, const std::vector<Trial>& trials,
                   const std::vector<TrialGroup>& groups, const std::string& outcome,
                   const std::string& fault);

/// The means over the seeds on stdout, and where settings were varied by how much each differs from
/// the first of its mission.
void print_tables(const std::vector<TrialGroup>& groups);

/// What the runs found that compared methods to tell places apart, if any did.
void report_recognition(const TrialsOptions& options, const std::vector<Trial>& trials);

}  // namespace panoptes
