// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/study_table.h"

#include <algorithm>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "apps/report/figure_names.h"
#include "core/base/text.h"
#include "core/io/csv.h"

namespace panoptes {
namespace {

constexpr const char* kError = "trajectory.ate_rmse_m";
constexpr const char* kByWheels = "trajectory.odometry_ate_rmse_m";
constexpr double kCm = 100;

// What the cells show of a run, and in which unit.
struct Shown {
  std::string figure;
  double scale;

  explicit Shown(const Study& study)
      : figure(shown_figure(study)), scale(figure == kError ? kCm : 1) {}
  std::optional<double> of(const StudyRun& run) const {
    const std::optional<double> largest = StudyScore{figure, {}}.of(run.figures);
    return largest ? std::optional(scale * *largest) : std::nullopt;
  }
  std::string text(double value) const {
    return figure == kError ? fmt::format("{:.1f}", value) : fmt::format("{:.3g}", value);
  }
};

// The runs of one mission under one rig and rung, as the table has them.
std::string cell_text(const Shown& shown, const std::vector<StudyCell>& cells,
                      const std::vector<StudyRun>& runs, const std::string& mission,
                      const std::string& rig, const std::string& rung) {
  std::optional<double> worst;
  bool all_passed = true;
  bool any_done = false;
  bool any_left = false;
  for (const StudyRun& run : runs) {
    const StudyCell& cell = cells[run.cell];
    if (cell.mission != mission || cell.rig != rig || cell.rung != rung) {
      continue;
    }
    any_left = any_left || !run.done;
    if (!run.done) {
      continue;
    }
    any_done = true;
    all_passed = all_passed && run.passed;
    if (const auto value = shown.of(run)) {
      worst = std::max(worst.value_or(*value), *value);
    }
  }
  if (!any_done) {
    return any_left ? "..." : "-";
  }
  const std::string text = worst ? shown.text(*worst) : "-";
  return (all_passed ? text : "**" + text + "**") + (any_left ? " ..." : "");
}

// The rungs that are tried under the same rigs, in the order of the first of each.
std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> tables_of(
    const Study& study) {
  std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> tables;
  for (const StudyRung& rung : study.rungs) {
    std::vector<std::string> rigs;
    for (const StudyRig& rig : study.rigs) {
      if (rung.rigs.empty() ||
          std::find(rung.rigs.begin(), rung.rigs.end(), rig.name) != rung.rigs.end()) {
        rigs.push_back(rig.name);
      }
    }
    const auto same = std::find_if(tables.begin(), tables.end(),
                                   [&](const auto& table) { return table.first == rigs; });
    if (same == tables.end()) {
      tables.push_back({rigs, {rung.name}});
    } else {
      same->second.push_back(rung.name);
    }
  }
  return tables;
}

// What the tables show, in words.
std::string legend(const Study& study, const std::vector<StudyRun>& runs) {
  std::set<std::uint64_t> seeds;
  std::vector<double> by_wheels_cm;
  bool any_left = false;
  for (const StudyRun& run : runs) {
    seeds.insert(run.seed);
    any_left = any_left || !run.done;
    if (const auto error_m = run.figures.find(kByWheels); run.done && error_m) {
      by_wheels_cm.push_back(kCm * *error_m);
    }
  }
  std::vector<std::string> words;
  words.reserve(seeds.size());
  for (const std::uint64_t seed : seeds) {
    words.push_back(std::to_string(seed));
  }
  const Shown shown(study);
  std::string text = fmt::format("{}`{}`{}, {} {}. ",
                                 shown.figure == kError ? "Rms error of position in cm (" : "",
                                 shown.figure, shown.figure == kError ? ")" : "",
                                 words.size() == 1        ? "of seed"
                                 : shown.figure == kError ? "the worst of the seeds"
                                                          : "the largest of the seeds",
                                 joined(words));
  if (!by_wheels_cm.empty() && shown.figure == kError) {
    const auto [least, most] = std::minmax_element(by_wheels_cm.begin(), by_wheels_cm.end());
    text += fmt::format("By the wheels alone it is {:.1f} to {:.1f}. ", *least, *most);
  }
  text += "Bold: a limit is broken, or a run did not come to a good end.";
  return text + (any_left ? " Three dots: there are runs left to do." : "") + "\n";
}

}  // namespace

std::string markdown_row(const std::vector<std::string>& cells) {
  return fmt::format("| {} |\n", joined(cells, " | "));
}

std::string shown_figure(const Study& study) {
  return study.figure.empty() ? kError : study.figure;
}

std::string study_tables(const Study& study, const std::vector<StudyRun>& runs) {
  const std::vector<StudyCell> cells = cells_of(study);
  const Shown shown(study);
  const bool several = study.missions.size() > 1;
  std::string text;
  for (const auto& [rigs, rungs] : tables_of(study)) {
    std::vector<std::string> head{"rig"};
    if (several) {
      head.emplace_back("mission");
    }
    head.insert(head.end(), rungs.begin(), rungs.end());
    text += text.empty() ? "" : "\n";
    text += markdown_row(head) + markdown_row(std::vector<std::string>(head.size(), "---"));
    for (const std::string& rig : rigs) {
      for (const StudyMission& mission : study.missions) {
        std::vector<std::string> words{rig};
        if (several) {
          words.push_back(mission.name);
        }
        for (const std::string& rung : rungs) {
          words.push_back(cell_text(shown, cells, runs, mission.name, rig, rung));
        }
        text += markdown_row(words);
      }
    }
  }
  return text;
}

std::string study_page(const Study& study, const std::vector<StudyRun>& runs) {
  const std::vector<StudyCell> cells = cells_of(study);
  std::string faults;
  for (const StudyRun& run : runs) {
    const StudyCell& cell = cells[run.cell];
    for (const std::string& fault : run.faults) {
      faults += fmt::format("- {}, {}, {}, seed {}: {}\n", cell.mission, cell.rig, cell.rung,
                            run.seed, fault);
    }
  }
  return legend(study, runs) + "\n" + study_tables(study, runs) +
         (faults.empty() ? "" : "\nNot held:\n\n" + faults);
}

void write_study_csv(const std::filesystem::path& file, const Study& study,
                     const std::vector<StudyRun>& runs) {
  FigureNameUnion all;
  for (const StudyRun& run : runs) {
    all.add(run.figures);
  }
  std::vector<std::string> figures = all.names();
  std::erase_if(figures, is_cost);
  std::vector<std::string> columns{"mission", "rig", "rung", "seed", "verdict", "faults"};
  columns.insert(columns.end(), figures.begin(), figures.end());
  const std::vector<StudyCell> cells = cells_of(study);
  CsvWriter csv(file, columns);
  for (const StudyRun& run : runs) {
    if (!run.done) {
      continue;
    }
    const StudyCell& cell = cells[run.cell];
    csv << cell.mission << cell.rig << cell.rung << std::to_string(run.seed)
        << (run.passed ? "pass" : "fail") << joined(run.faults, "; ");
    for (const std::string& name : figures) {
      if (const auto value = run.figures.find(name)) {
        csv << *value;
      } else {
        csv.skip();
      }
    }
    csv.end_row();
  }
  csv.finish();
}

}  // namespace panoptes
