// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/tables.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/batch/results.h"
#include "apps/draw/pictures.h"
#include "apps/recognition/recognition_table.h"
#include "apps/report/figure_names.h"
#include "apps/study/study_ranking.h"
#include "apps/study/study_table.h"
#include "apps/trials/against_first.h"
#include "apps/trials/halving.h"
#include "apps/trials/study_pictures.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/eval/statistics.h"
#include "core/io/csv.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

std::string fixed(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

/// Every line that a run had to meet, in order: how many had to, how many did, and whether all did.
Json requirements_of(const std::vector<Trial>& trials) {
  Json lines = Json::array();
  std::map<std::string, std::pair<int, int>> met;  // and of how many
  std::vector<std::string> order;
  for (const Trial& trial : trials) {
    if (trial.left_out) {
      continue;
    }
    for (const auto& [line, pass] : trial.required) {
      auto& [passed, runs] = met[line];
      if (runs == 0) {
        order.push_back(line);
      }
      ++runs;
      passed += pass ? 1 : 0;
    }
  }
  for (const std::string& line : order) {
    const auto& [passed, runs] = met.at(line);
    lines.push_back({{"require", line}, {"runs", runs}, {"met", passed}, {"pass", passed == runs}});
  }
  return lines;
}

/// What the table shows of the figures, in which unit, and what it is.
struct Column {
  const char* head;
  const char* figure;
  double scale;
  int digits;
  const char* what;
};
constexpr Column kColumns[] = {
    {"coverage %", "map.coverage", 100, 1, "of the floor that the robot can get to: mapped"},
    {"precision %", "map.free_precision", 100, 1,
     "of what is mapped as free where a camera truly saw: floor"},
    {"leaked %", "map.leaked_share", 100, 1,
     "of all that is mapped as free: farther than 10 cm from any floor"},
    {"checkpoints cm", "checkpoints.error_mean_m", 100, 1,
     "error of position, mean of 8 places far apart"},
    {"worst cm", "checkpoints.error_max_m", 100, 1, "the largest of the 8"},
    {"ATE cm", "trajectory.ate_rmse_m", 100, 1,
     "error of all keyframes' positions, root mean square"},
    {"wheels cm", "trajectory.odometry_ate_rmse_m", 100, 1, "the same by the wheels alone"},
    {"loops", "loops.accepted", 1, 1, "closures in the graph"},
    {"false", "loops.false", 1, 2, "wrong ones of them"},
    {"collisions", "collisions", 1, 2, "contacts of a moving robot"},
    {"x real time", "real_time_factor", 1, 1, "seconds of the run a second of wall time"},
};

}  // namespace

std::string table_legend() {
  std::string text = "The table: means over the seeds +- half of their 95 % intervals, of\n";
  for (const Column& column : kColumns) {
    std::string head = column.head;
    head.resize(16, ' ');
    text += "  " + head + column.what + " (" + column.figure + ")\n";
  }
  text +=
      "Settings that are varied are compared with the first of their mission, by runs of the same "
      "seed.\n";
  return text;
}

namespace {

const char* verdict_of(const Trial& trial) {
  return trial.status == TrialStatus::kPassed   ? "pass"
         : trial.status == TrialStatus::kFailed ? "fail"
                                                : "error";
}

// A row a run: what tells it apart, `words_of` it, and these figures.
void write_rows(const TrialsOptions& options, const std::vector<Trial>& trials, const char* file,
                const std::vector<std::string>& words, const std::vector<std::string>& figures,
                const std::function<void(CsvWriter&, const Trial&)>& write_words) {
  std::vector<std::string> columns = {"mission"};
  const std::vector<std::string> keys = varied(options);
  columns.insert(columns.end(), keys.begin(), keys.end());
  columns.emplace_back("seed");
  columns.insert(columns.end(), words.begin(), words.end());
  columns.insert(columns.end(), figures.begin(), figures.end());
  CsvWriter csv(options.out_dir / file, columns);
  for (const Trial& trial : trials) {
    if (!is_done(trial)) {
      continue;
    }
    csv << trial.point->mission;
    for (const std::string& value : trial.point->values) {
      csv << value;
    }
    csv << std::to_string(trial.seed);
    write_words(csv, trial);
    for (const std::string& name : figures) {
      if (const auto value = trial.figures.find(name)) {
        csv << *value;
      } else {
        csv.skip();
      }
    }
    csv.end_row();
  }
  csv.finish();
}

}  // namespace

void write_csv(const TrialsOptions& options, const std::vector<Trial>& trials) {
  FigureNameUnion all;
  for (const Trial& trial : trials) {
    all.add(trial.figures);
  }
  std::vector<std::string> figures = all.names();
  const auto costs = std::stable_partition(figures.begin(), figures.end(),
                                           [](const std::string& name) { return !is_cost(name); });
  const std::vector<std::string> timing(costs, figures.end());
  figures.erase(costs, figures.end());
  write_rows(options, trials, "trials.csv", {"verdict", "outcome"}, figures,
             [](CsvWriter& csv, const Trial& trial) { csv << verdict_of(trial) << trial.outcome; });
  write_rows(options, trials, "timing.csv", {}, timing, [](CsvWriter&, const Trial&) {});
}

void write_junit(const TrialsOptions& options, const std::vector<Trial>& trials) {
  int failures = 0;
  int errors = 0;
  int skipped = 0;
  double all_s = 0;
  std::string cases;
  for (const Trial& trial : trials) {
    all_s += trial.wall_s;
    const std::string& setting = trial.point->setting;
    cases +=
        "  <testcase classname=\"" + xml_text(trial.point->mission) + "\" name=\"" +
        xml_text((setting.empty() ? "" : setting + " ") + "seed " + std::to_string(trial.seed)) +
        "\" time=\"" + fixed(trial.wall_s, 3) + "\"";
    if (trial.status == TrialStatus::kPassed) {
      cases += "/>\n";
      continue;
    }
    cases += ">\n";
    if (!is_done(trial) || trial.left_out) {
      ++skipped;
      cases += fmt::format("    <skipped message=\"{}\"/>\n",
                           trial.left_out ? "left out by halving" : "interrupted");
    } else {
      const bool broken = trial.status == TrialStatus::kBroken;
      ++(broken ? errors : failures);
      const std::vector<std::string> lines = faults(trial, options);
      const char* kind = broken ? "error" : "failure";
      cases += std::string("    <") + kind + " message=\"" +
               xml_text(lines.empty() ? "" : lines.front()) + "\">" +
               xml_text(joined(lines, "\n")) + "</" + kind + ">\n";
    }
    cases += "  </testcase>\n";
  }
  write_file(
      options.junit,
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"panoptes trials\" tests=\"" +
          std::to_string(trials.size()) + "\" failures=\"" + std::to_string(failures) +
          "\" errors=\"" + std::to_string(errors) + "\" skipped=\"" + std::to_string(skipped) +
          "\" time=\"" + fixed(all_s, 3) + "\">\n" + cases + "</testsuite>\n");
}

std::vector<TrialGroup> groups_of(const std::vector<Trial>& trials) {
  std::vector<TrialGroup> groups;
  for (const Trial& trial : trials) {
    if (!is_done(trial)) {
      continue;
    }
    if (groups.empty() || groups.back().point != trial.point.get()) {
      groups.push_back({trial.point.get(), {}, 0});
    }
    groups.back().runs.push_back(&trial);
    groups.back().passed += trial.status == TrialStatus::kPassed ? 1 : 0;
  }
  for (TrialGroup& group : groups) {
    std::sort(group.runs.begin(), group.runs.end(),
              [](const Trial* a, const Trial* b) { return a->seed < b->seed; });
  }
  return groups;
}

std::optional<PairedDifference> difference(const TrialGroup& group, const TrialGroup& other,
                                           const std::string& score) {
  std::vector<double> values;
  std::vector<double> others;
  auto same = other.runs.begin();
  for (const Trial* run : group.runs) {
    while (same != other.runs.end() && (*same)->seed < run->seed) {
      ++same;
    }
    if (same == other.runs.end()) {
      break;
    }
    const auto value = run->figures.find(score);
    const auto other_value = (*same)->figures.find(score);
    if ((*same)->seed == run->seed && value && other_value) {
      values.push_back(*value);
      others.push_back(*other_value);
    }
  }
  if (values.empty()) {
    return std::nullopt;
  }
  return paired_difference(values, others);
}

namespace {

std::vector<std::string> scores_of(const TrialGroup& group) {
  FigureNameUnion all;
  for (const Trial* run : group.runs) {
    all.add(run->figures);
  }
  std::vector<std::string> scores = all.names();
  std::erase_if(scores, is_cost);
  return scores;
}

std::vector<double> values_of(const TrialGroup& group, const std::string& score) {
  std::vector<double> values;
  for (const Trial* run : group.runs) {
    if (const auto value = run->figures.find(score)) {
      values.push_back(*value);
    }
  }
  return values;
}

/// Of each score, where a difference can be told at all: of two runs or more.
Json differences_json(const TrialGroup& group, const TrialGroup& other) {
  Json out = Json::object();
  for (const std::string& score : scores_of(group)) {
    const std::optional<PairedDifference> found = difference(group, other, score);
    if (found && found->mean.count > 1) {
      out[score] = {{"mean", found->mean.mean},        {"low", found->mean.low},
                    {"high", found->mean.high},        {"pairs", found->mean.count},
                    {"detectable", found->detectable}, {"shows", found->shows()}};
    }
  }
  return out;
}

std::vector<StudyRun> study_runs(const TrialsOptions& options, const std::vector<Trial>& trials) {
  std::vector<StudyRun> runs;
  for (const Trial& trial : trials) {
    if (trial.left_out && !is_done(trial)) {
      continue;
    }
    StudyRun& run = runs.emplace_back();
    run.cell = trial.point->cell;
    run.seed = trial.seed;
    run.done = is_done(trial);
    run.passed = trial.status == TrialStatus::kPassed;
    if (run.done) {
      run.figures = trial.figures;
      run.faults = run.passed ? std::vector<std::string>() : faults(trial, options);
    }
  }
  return runs;
}

/// Where a rig stands by each score, and by the first one.
void add_standings(const StudyRanking& ranking, std::size_t cell, Json& setting) {
  for (std::size_t k = 0; k < ranking.scores.size(); ++k) {
    const auto& standing = ranking.standings[cell][k];
    if (!standing) {
      continue;
    }
    Json told{{"rank", standing->rank},
              {"not_distinguishable_from_best", standing->not_distinguishable_from_best}};
    if (k == 0) {
      setting.update(told);
    }
    if (standing->detectable) {
      told["detectable"] = *standing->detectable;
    }
    setting["ranks"][ranking.scores[k].figure()] = told;
  }
  if (ranking.scores.size() > 1) {
    setting["pareto"] = static_cast<bool>(ranking.pareto[cell]);
  }
}

}  // namespace

void write_metrics(const TrialsOptions& options, const std::vector<Trial>& trials,
                   const std::vector<TrialGroup>& groups, const std::string& outcome,
                   const std::string& fault) {
  Json metrics;
  metrics["schema"] = "panoptes.metrics/1";
  metrics["command"] = "trials";
  metrics["version"] = options.version;
  std::vector<std::string> missions;
  std::vector<std::uint64_t> seeds;
  std::set<std::uint64_t> known;
  double run_s = 0;
  std::size_t missing = 0;
  for (const Trial& trial : trials) {
    if (missions.empty() || missions.back() != trial.point->mission) {
      missions.push_back(trial.point->mission);
    }
    if (known.insert(trial.seed).second) {
      seeds.push_back(trial.seed);
    }
    run_s += trial.figures.find("run_s").value_or(0);
    missing += is_done(trial) || trial.left_out ? 0 : 1;
  }
  metrics["seed"] = seeds.front();
  metrics["seeds"] = seeds;
  metrics["mission"] = missions.front();
  metrics["missions"] = missions;
  metrics["outcome"] = outcome;
  if (!fault.empty()) {
    metrics["fault"] = fault;
  }
  metrics["requirements"] = requirements_of(trials);
  std::size_t runs = 0;
  int passed = 0;
  std::optional<StudyRanking> ranking;
  if (options.study) {
    ranking = rank_rigs(*options.study, study_runs(options, trials));
  }
  const std::vector<std::string> keys = varied(options);
  Json settings = Json::array();
  const TrialGroup* first = nullptr;  // of its mission
  for (const TrialGroup& group : groups) {
    runs += group.runs.size();
    passed += group.passed;
    Json setting;
    setting["mission"] = group.point->mission;
    Json vary = Json::object();
    for (std::size_t i = 0; i < group.point->values.size(); ++i) {
      vary[keys[i]] = group.point->values[i];
    }
    setting["vary"] = vary;
    setting["runs"] = group.runs.size();
    setting["passed"] = group.passed;
    Json scores = Json::object();
    for (const std::string& name : scores_of(group)) {
      const MeanInterval m = mean_interval(values_of(group, name));
      scores[name] = {{"mean", m.mean}, {"low", m.low}, {"high", m.high}, {"count", m.count}};
    }
    setting["scores"] = scores;
    if (first != nullptr && first->point->mission == group.point->mission) {
      setting["differences"] = differences_json(group, *first);
    } else {
      first = &group;
    }
    if (ranking) {
      add_standings(*ranking, group.point->cell, setting);
    }
    if (options.study) {
      for (const RigComparison& one : compare_with_first(*options.study, groups, group)) {
        Json line{{"line", one.line}, {"pairs", one.pairs}, {"holds", one.holds}};
        if (one.pairs > 0) {
          line["mean"] = one.mean;
        }
        if (one.pairs > 1) {
          line["bound"] = one.bound;
          line["detectable"] = one.detectable;
        }
        setting["against_first"].push_back(line);
      }
    }
    settings.push_back(setting);
  }
  metrics["runs"] = runs;
  metrics["passed"] = passed;
  if (missing > 0) {
    metrics["missing"] = missing;
  }
  metrics["settings"] = settings;
  metrics["run_s"] = run_s;
  write_file(options.out_dir / "metrics.json",
             metrics.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

namespace {

using Lines = std::vector<std::vector<std::string>>;

std::string name_of(const TrialPoint& point) {
  return point.mission + (point.setting.empty() ? "" : " " + point.setting);
}

/// The first cell of a line to the left, the others to the right.
void print_aligned(const Lines& lines) {
  std::vector<std::size_t> widths(lines[0].size(), 0);
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      widths[i] = std::max(widths[i], line[i].size());
    }
  }
  for (const auto& line : lines) {
    std::string text;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string pad(widths[i] - line[i].size(), ' ');
      text += (i == 0 ? line[i] + pad : "  " + pad + line[i]);
    }
    std::printf("%s\n", text.c_str());
  }
}

std::string plus_minus(const Column& column, const MeanInterval& m) {
  return m.count > 1 ? " +- " + fixed(column.scale * (m.high - m.mean), column.digits) : "";
}

void print_means(const std::vector<TrialGroup>& groups, const std::vector<const Column*>& shown) {
  bool averaged = false;
  Lines lines{{"mission", "passed"}};
  for (const Column* column : shown) {
    lines[0].emplace_back(column->head);
  }
  for (const TrialGroup& group : groups) {
    lines.push_back({name_of(*group.point),
                     std::to_string(group.passed) + "/" + std::to_string(group.runs.size())});
    for (const Column* column : shown) {
      const std::vector<double> values = values_of(group, column->figure);
      if (values.empty()) {
        lines.back().emplace_back("-");
        continue;
      }
      const MeanInterval m = mean_interval(values);
      averaged = averaged || m.count > 1;
      lines.back().push_back(fixed(column->scale * m.mean, column->digits) +
                             plus_minus(*column, m));
    }
  }
  print_aligned(lines);
  std::printf("%spanoptes trials --help says what the columns are\n",
              averaged ? "means over the seeds +- half of their 95 % intervals; " : "");
}

std::string difference_cell(const Column& column, const std::optional<PairedDifference>& found) {
  if (!found || found->mean.count < 2) {
    return "-";
  }
  if (found->shows()) {
    return fmt::format("{:+.{}f}{}", column.scale * found->mean.mean, column.digits,
                       plus_minus(column, found->mean));
  }
  if (found->detectable == 0) {
    return "same";
  }
  return "none from " + fixed(column.scale * found->detectable, column.digits);
}

// A drive's chances are the seed's: settings are compared seed by seed.
void print_differences(const std::vector<TrialGroup>& groups,
                       const std::vector<const Column*>& shown) {
  Lines lines{{"against the first", "pairs"}};
  for (const Column* column : shown) {
    lines[0].emplace_back(column->head);
  }
  const TrialGroup* first = nullptr;  // of its mission
  for (const TrialGroup& group : groups) {
    if (first == nullptr || first->point->mission != group.point->mission) {
      first = &group;
      continue;
    }
    int pairs = 0;
    std::vector<std::string> cells;
    for (const Column* column : shown) {
      const std::optional<PairedDifference> found = difference(group, *first, column->figure);
      pairs = std::max(pairs, found ? found->mean.count : 0);
      cells.push_back(difference_cell(*column, found));
    }
    if (pairs > 1) {
      lines.push_back({name_of(*group.point), std::to_string(pairs)});
      lines.back().insert(lines.back().end(), cells.begin(), cells.end());
    }
  }
  if (lines.size() > 1) {
    std::printf("\n");
    print_aligned(lines);
    std::printf(
        "means of the differences of runs with the same seed +- half of their 95 %% intervals; "
        "none from X: none shows, and one of X would have four times out of five\n");
  }
}

}  // namespace

void print_tables(const std::vector<TrialGroup>& groups) {
  std::vector<const Column*> shown;
  for (const Column& column : kColumns) {
    if (std::any_of(groups.begin(), groups.end(),
                    [&](const TrialGroup& g) { return !values_of(g, column.figure).empty(); })) {
      shown.push_back(&column);
    }
  }
  print_means(groups, shown);
  std::erase_if(shown, [](const Column* column) {
    return std::string_view(column->figure) == "real_time_factor";  // the machine's
  });
  print_differences(groups, shown);
}

namespace {

/// What is told of a study beside its tables.
std::string study_findings(const TrialsOptions& options, const std::vector<Trial>& trials,
                           const std::vector<StudyRun>& runs) {
  return ranking_page(*options.study, runs, rank_rigs(*options.study, runs)) +
         comparison_page(*options.study, groups_of(trials)) + halving_page(*options.study, trials);
}

}  // namespace

void write_study(const TrialsOptions& options, const std::vector<Trial>& trials) {
  if (options.study) {
    const std::vector<StudyRun> runs = study_runs(options, trials);
    write_study_csv(options.out_dir / "study.csv", *options.study, runs);
    write_file(options.out_dir / "study.md",
               study_page(*options.study, runs) + study_findings(options, trials, runs));
  }
}

void report_study(const TrialsOptions& options, const std::vector<Trial>& trials) {
  const std::vector<StudyRun> runs = study_runs(options, trials);
  write_study_pictures(options, rank_rigs(*options.study, runs), trials);
  std::printf("%s%s\n%s\n", study_tables(*options.study, runs).c_str(),
              study_findings(options, trials, runs).c_str(),
              (options.out_dir / "study.md").c_str());
}

void report_recognition(const TrialsOptions& options, const std::vector<Trial>& trials) {
  std::vector<std::string> columns = {"mission"};
  const std::vector<std::string> keys = varied(options);
  columns.insert(columns.end(), keys.begin(), keys.end());
  columns.insert(columns.end(), {"seed", "histogram", "distance", "pictures", "recall",
                                 "recall_same", "recall_opposite"});
  std::vector<RecognitionWorld> worlds;  // a mission under one combination of the other settings
  std::optional<CsvWriter> csv;
  for (const Trial& trial : trials) {
    const std::filesystem::path file = folder_of(trial, options.out_dir) / "places.csv";
    if (!is_done(trial) || !std::filesystem::exists(file)) {
      continue;
    }
    const std::vector<RecognitionRow> rows = read_recognition_rows(file);
    if (!csv) {
      csv.emplace(options.out_dir / "places.csv", columns);
    }
    for (const RecognitionRow& row : rows) {
      *csv << trial.point->mission;
      for (const std::string& value : trial.point->values) {
        *csv << value;
      }
      *csv << std::to_string(trial.seed) << row.histogram << row.distance << row.pictures;
      for (const auto& recall : {row.recall(), row.recall_same(), row.recall_opposite()}) {
        if (recall) {
          *csv << *recall;
        } else {
          csv->skip();
        }
      }
      csv->end_row();
    }
    const std::string name = name_of(*trial.point);
    if (worlds.empty() || worlds.back().name != name) {
      worlds.push_back({name, {}});
    }
    add_rows(worlds.back(), rows);
  }
  if (!csv) {
    return;
  }
  csv->finish();
  write_file(options.out_dir / "places.png", png(draw_recognition_table(worlds)));
  std::printf("\n");
  for (const std::string& line : recognition_table(worlds)) {
    std::printf("%s\n", line.c_str());
  }
  std::printf("%s\n", (options.out_dir / "places.png").c_str());
}

}  // namespace panoptes
