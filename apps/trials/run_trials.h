// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "apps/trials/plan.h"

namespace panoptes {

/// Runs every mission with every combination and every seed, each as a process of its own in
/// `out_dir/<mission>/<combination>/<seed>`, prints one table and writes trials.csv, metrics.json
/// and the JUnit file. Of a study it runs every cell with every seed, prints the study's tables and
/// writes study.csv and study.md; a limit that is broken makes a run no pass. Of runs that compared
/// methods to tell places apart it prints another table, and writes places.csv, a row a run and a
/// combination, and places.png. Runs that are already there, finished with the same settings, by
/// the same program and from the same files (their hashes are beside each run), are kept; other
/// ones are never overwritten: ConfigError. Exit status: 0 when every run met its requirements, 1
/// when one did not, 130 when interrupted (SIGINT, SIGTERM and SIGHUP are passed on to the runs).
int run_trials(const TrialsOptions& options);

}  // namespace panoptes
