// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/study/figure_row.h"
#include "apps/study/study.h"

namespace panoptes {

/// What became of one run of a study.
struct StudyRun {
  std::size_t cell = 0;  ///< of cells_of()
  std::uint64_t seed = 0;
  bool done = false;
  bool passed = false;              ///< it came to its end, and no limit is broken
  std::vector<std::string> faults;  ///< why it is no pass
  FigureRow figures;
};

/// A row of a table in Markdown.
std::string markdown_row(const std::vector<std::string>& cells);

/// The figure that is shown in the tables of a study.
std::string shown_figure(const Study& study);

/// Tables in Markdown: a row a rig and mission, a column a rung, in each cell the position's rms
/// error in cm, or the study's figure, the largest of the seeds. Bold where a run is no pass. Rungs
/// that are tried under the same rigs share a table.
std::string study_tables(const Study& study, const std::vector<StudyRun>& runs);

/// study.md: the tables, what they show, and every limit that is broken.
std::string study_page(const Study& study, const std::vector<StudyRun>& runs);

/// study.csv: a row a run that is done, with its verdict and every figure that does not depend on
/// the computer.
void write_study_csv(const std::filesystem::path& file, const Study& study,
                     const std::vector<StudyRun>& runs);

}  // namespace panoptes
