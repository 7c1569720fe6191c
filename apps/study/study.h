// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/study/figure_row.h"
#include "apps/study/limit.h"
#include "core/config/fields.h"

namespace panoptes {

/// Settings as `--set` takes them, `key.path=value`, each with its place in the study
/// (file:line:column). Of two of one key the later one counts.
struct StudySettings {
  std::vector<std::string> set;
  std::vector<std::string> places;
};
/// {set}
void bind(Fields& f, StudySettings& o);

/// What is tried under every rig and rung.
struct StudyMission {
  std::string name;
  std::string name_place;
  std::string file;
  std::string command = "explore";  ///< what is done with it, as calibrates() tells
  StudySettings settings;
};
void bind(Fields& f, StudyMission& o);

/// A rig that is tried: a row of the table.
struct StudyRig {
  std::string name;
  std::string name_place;
  std::string file;  ///< both what is believed and what the true cameras hang on; may be empty
  std::string file_place;
  StudySettings settings;
};
void bind(Fields& f, StudyRig& o);

/// Errors that are tried: a column of the table.
struct StudyRung {
  std::string name;
  std::string name_place;
  StudySettings settings;
  std::vector<std::string> rigs;  ///< under which it is tried; empty: all
  std::vector<std::string> rig_places;
};
void bind(Fields& f, StudyRung& o);

/// A limit, and the cells that have to hold it; of an empty list all.
struct StudyLimit {
  std::string require;
  std::string place;
  Limit limit;
  std::vector<std::string> missions;
  std::vector<std::string> mission_places;
  std::vector<std::string> rigs;
  std::vector<std::string> rig_places;
  std::vector<std::string> rungs;
  std::vector<std::string> rung_places;
};
void bind(Fields& f, StudyLimit& o);

/// What a figure may differ by from that of the first rig, under the same rung in the same mission,
/// by runs of the same seeds: `map.coverage >= -0.01` holds where the difference is surely not
/// below that (one-sided 95 %), `checkpoints.error_mean_m < 0` where the rig is surely better.
struct StudyComparison {
  std::string line;
  std::string place;
  Limit limit;
};

/// What rigs are compared by: a figure of their runs, `*` in it: the worst of several.
struct StudyScore {
  std::string least;  ///< the figure, the less the better, or
  std::string most;   ///< the more the better; one of the two

  const std::string& figure() const { return least.empty() ? most : least; }
  bool less_is_better() const { return most.empty(); }
  std::optional<double> of(const FigureRow& run) const;
};
/// {least, most}
void bind(Fields& f, StudyScore& o);

/// Not every rig is run with every seed: of those beside the first, the better half goes on to
/// twice as many seeds, until `keep` are left.
struct StudyHalving {
  int seeds = 2;  ///< of the first round
  int keep = 1;   ///< rigs that go on to the last seed
  StudyScore score;
  std::string place;
};
/// {seeds, keep, least, most}
void bind(Fields& f, StudyHalving& o);

/// A table of runs: every rung of errors under every rig in every mission, and what must hold.
struct Study {
  std::string file;
  std::vector<StudyMission> missions;
  StudySettings settings;  ///< of every run
  std::vector<StudyRig> rigs;
  std::vector<StudyRung> rungs;
  std::vector<StudyLimit> limits;
  std::vector<StudyComparison> against_first;
  std::vector<StudyScore> scores;  ///< that rank its rigs, the first one first
  std::optional<StudyHalving> halving;
  std::string
      figure;  ///< in the cells of its tables, `*`: the worst of several; empty: the default
};
void bind(Fields& f, Study& o);

/// Throws ConfigError with every fault of the file. Whether the missions can be run with these
/// settings is for whoever knows missions to say.
Study read_study(const std::string& file);

/// Whether a command of a study records missions and calibrates their rigs, by `calibrate` or
/// `calibrate --method thesis`; `explore` does not.
bool calibrates(const std::string& command);

/// One mission under one rig and one rung; every seed makes a run of it.
struct StudyCell {
  std::string mission;
  std::string rig;
  std::string rung;
  std::string mission_file;
  std::string command;
  StudySettings settings;  ///< all of them, in their order
  std::vector<Limit> limits;
};

/// In the order in which they are run: missions, in these rungs, in these rigs.
std::vector<StudyCell> cells_of(const Study& study);

/// Lines of a ConfigError about a mission read with these settings: what they say of a `--set`
/// begins with its place in the study. Of all that a `*` stands for they say the same.
std::vector<std::string> with_places(const StudySettings& settings, std::vector<std::string> lines);

}  // namespace panoptes
