// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "apps/batch/plan.h"
#include "apps/batch/slurm.h"

namespace panoptes {

/// Plans every mission with every combination and every seed (`out_dir/manifest.jsonl`), runs each
/// as a process of its own in `out_dir/<mission>/<combination>/<seed>`, prints one table and writes
/// trials.csv, timing.csv, metrics.json and the JUnit file. Of a study it runs every cell with
/// every seed, prints the study's tables and writes study.csv and study.md; a limit that is broken
/// makes a run no pass. Of runs that compared methods to tell places apart it prints another table,
/// and writes places.csv, a row a run and a combination, and places.png. Runs that are already
/// there, finished with the same settings, by the same program and from the same files (their
/// hashes are beside each run), are kept; other ones are never overwritten: ConfigError. Exit
/// status: 0 when every run met its requirements, 1 when one did not, 130 when interrupted (SIGINT,
/// SIGTERM and SIGHUP are passed on to the runs).
///
/// Options without missions and study are of the manifest that is in `out_dir`; so for those below.
int run_trials(TrialsOptions options);

/// Makes one shard of the runs, and no table. Others may make the other ones, or this one, at the
/// same time. Exit status: 0 when all of its runs came to an end, 1 when one broke, 130.
int run_shard(TrialsOptions options, const Shard& shard);

/// Tables and verdict of the runs that are there, and which are missing. The same bytes as
/// run_trials() leaves. Exit status: 0 when all are there and met their requirements, else 1.
int merge_trials(TrialsOptions options);

/// See submit_to_slurm(). With `wait`, one round of a race after the other.
int submit_trials(TrialsOptions options, SlurmOptions slurm);

}  // namespace panoptes
