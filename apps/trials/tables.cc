// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/tables.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "apps/draw/pictures.h"
#include "apps/recognition/recognition_table.h"
#include "apps/study/study_table.h"
#include "apps/trials/results.h"
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

void write_csv(const TrialsOptions& options, const std::vector<Trial>& trials) {
  std::vector<std::string> figures;
  std::set<std::string> known;
  for (const Trial& trial : trials) {
    for (const auto& [name, value] : trial.figures) {
      if (known.insert(name).second) {
        figures.push_back(name);
      }
    }
  }
  std::vector<std::string> columns = {"mission"};
  const std::vector<std::string> keys = varied(options);
  columns.insert(columns.end(), keys.begin(), keys.end());
  columns.insert(columns.end(), {"seed", "verdict", "outcome"});
  columns.insert(columns.end(), figures.begin(), figures.end());
  CsvWriter csv(options.out_dir / "trials.csv", columns);
  for (const Trial& trial : trials) {
    if (!is_done(trial)) {
      continue;
    }
    csv << trial.mission;
    for (const std::string& value : trial.values) {
      csv << value;
    }
    csv << std::to_string(trial.seed);
    csv << (trial.status == TrialStatus::kPassed   ? "pass"
            : trial.status == TrialStatus::kFailed ? "fail"
                                                   : "error");
    csv << trial.outcome;
    const std::map<std::string, double> own(trial.figures.begin(), trial.figures.end());
    for (const std::string& name : figures) {
      const auto value = own.find(name);
      if (value == own.end()) {
        csv.skip();
      } else {
        csv << value->second;
      }
    }
    csv.end_row();
  }
  csv.finish();
}

void write_junit(const std::filesystem::path& path, const std::vector<Trial>& trials) {
  int failures = 0;
  int errors = 0;
  int skipped = 0;
  double all_s = 0;
  std::string cases;
  for (const Trial& trial : trials) {
    all_s += trial.wall_s;
    cases += "  <testcase classname=\"" + xml_text(trial.mission) + "\" name=\"" +
             xml_text((trial.setting.empty() ? "" : trial.setting + " ") + "seed " +
                      std::to_string(trial.seed)) +
             "\" time=\"" + fixed(trial.wall_s, 3) + "\"";
    if (trial.status == TrialStatus::kPassed) {
      cases += "/>\n";
      continue;
    }
    cases += ">\n";
    if (!is_done(trial)) {
      ++skipped;
      cases += "    <skipped message=\"interrupted\"/>\n";
    } else {
      const bool broken = trial.status == TrialStatus::kBroken;
      ++(broken ? errors : failures);
      const std::vector<std::string> lines = faults(trial);
      const char* kind = broken ? "error" : "failure";
      cases += std::string("    <") + kind + " message=\"" +
               xml_text(lines.empty() ? "" : lines.front()) + "\">" +
               xml_text(joined(lines, "\n")) + "</" + kind + ">\n";
    }
    cases += "  </testcase>\n";
  }
  write_file(
      path,
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
    if (groups.empty() || groups.back().mission != trial.mission ||
        groups.back().values != trial.values) {
      groups.push_back({trial.mission, trial.values, trial.setting, 0, 0, {}, {}});
    }
    TrialGroup& group = groups.back();
    ++group.runs;
    group.passed += trial.status == TrialStatus::kPassed ? 1 : 0;
    for (const auto& [name, value] : trial.figures) {
      auto& values = group.scores[name];
      if (values.empty()) {
        group.order.push_back(name);
      }
      values[trial.seed] = value;
    }
  }
  return groups;
}

namespace {

std::vector<double> values_of(const std::map<std::uint64_t, double>& by_seed) {
  std::vector<double> values;
  for (const auto& [seed, value] : by_seed) {
    values.push_back(value);
  }
  return values;
}

/// By how much a score is larger than the other group's, by the seeds that both have.
std::optional<PairedDifference> difference(const TrialGroup& group, const TrialGroup& other,
                                           const std::string& score) {
  const auto of = group.scores.find(score);
  const auto against = other.scores.find(score);
  if (of == group.scores.end() || against == other.scores.end()) {
    return std::nullopt;
  }
  std::vector<double> values;
  std::vector<double> others;
  for (const auto& [seed, value] : of->second) {
    if (const auto same = against->second.find(seed); same != against->second.end()) {
      values.push_back(value);
      others.push_back(same->second);
    }
  }
  if (values.empty()) {
    return std::nullopt;
  }
  return paired_difference(values, others);
}

/// Of each score, where a difference can be told at all: of two runs or more.
Json differences_json(const TrialGroup& group, const TrialGroup& other) {
  Json out = Json::object();
  for (const std::string& score : group.order) {
    const std::optional<PairedDifference> found = difference(group, other, score);
    if (found && found->mean.count > 1) {
      out[score] = {{"mean", found->mean.mean},        {"low", found->mean.low},
                    {"high", found->mean.high},        {"pairs", found->mean.count},
                    {"detectable", found->detectable}, {"shows", found->shows()}};
    }
  }
  return out;
}

}  // namespace

void write_metrics(const TrialsOptions& options, const std::vector<Trial>& trials,
                   const std::vector<TrialGroup>& groups, const std::string& outcome,
                   double wall_s) {
  Json metrics;
  metrics["schema"] = "panoptes.metrics/1";
  metrics["command"] = "trials";
  metrics["version"] = options.version;
  std::vector<std::string> missions;
  double run_s = 0;
  double peak_memory_mb = 0;
  for (const Trial& trial : trials) {
    if (missions.empty() || missions.back() != trial.mission) {
      missions.push_back(trial.mission);
    }
    for (const auto& [name, value] : trial.figures) {
      run_s += name == "run_s" ? value : 0;
      peak_memory_mb = name == "peak_memory_mb" ? std::max(peak_memory_mb, value) : peak_memory_mb;
    }
  }
  metrics["seed"] = options.seeds.front();
  metrics["seeds"] = options.seeds;
  metrics["mission"] = missions.front();
  metrics["missions"] = missions;
  metrics["outcome"] = outcome;
  metrics["requirements"] = requirements_of(trials);
  int runs = 0;
  int passed = 0;
  const std::vector<std::string> keys = varied(options);
  Json settings = Json::array();
  const TrialGroup* first = nullptr;  // of its mission
  for (const TrialGroup& group : groups) {
    runs += group.runs;
    passed += group.passed;
    Json setting;
    setting["mission"] = group.mission;
    Json vary = Json::object();
    for (std::size_t i = 0; i < group.values.size(); ++i) {
      vary[keys[i]] = group.values[i];
    }
    setting["vary"] = vary;
    setting["runs"] = group.runs;
    setting["passed"] = group.passed;
    Json scores = Json::object();
    for (const std::string& name : group.order) {
      const MeanInterval m = mean_interval(values_of(group.scores.at(name)));
      scores[name] = {{"mean", m.mean}, {"low", m.low}, {"high", m.high}, {"count", m.count}};
    }
    setting["scores"] = scores;
    if (first != nullptr && first->mission == group.mission) {
      setting["differences"] = differences_json(group, *first);
    } else {
      first = &group;
    }
    settings.push_back(setting);
  }
  metrics["runs"] = runs;
  metrics["passed"] = passed;
  metrics["settings"] = settings;
  rusage use{};
  getrusage(RUSAGE_CHILDREN, &use);
  metrics["wall_s"] = wall_s;
  metrics["cpu_s"] = static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
                     1e-6 * static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
  metrics["run_s"] = run_s;
  if (wall_s > 0) {
    metrics["real_time_factor"] = run_s / wall_s;
  }
  metrics["peak_memory_mb"] = peak_memory_mb;  // of the largest run
  write_file(options.out_dir / "metrics.json",
             metrics.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

namespace {

using Lines = std::vector<std::vector<std::string>>;

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
    lines.push_back({group.mission + (group.setting.empty() ? "" : " " + group.setting),
                     std::to_string(group.passed) + "/" + std::to_string(group.runs)});
    for (const Column* column : shown) {
      const auto values = group.scores.find(column->figure);
      if (values == group.scores.end()) {
        lines.back().emplace_back("-");
        continue;
      }
      const MeanInterval m = mean_interval(values_of(values->second));
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
    if (first == nullptr || first->mission != group.mission) {
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
      lines.push_back({group.mission + " " + group.setting, std::to_string(pairs)});
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
                    [&](const TrialGroup& g) { return g.scores.contains(column.figure); })) {
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

std::vector<StudyRun> study_runs(const std::vector<Trial>& trials) {
  std::vector<StudyRun> runs;
  for (const Trial& trial : trials) {
    StudyRun& run = runs.emplace_back();
    run.cell = trial.cell;
    run.seed = trial.seed;
    run.done = is_done(trial);
    run.passed = trial.status == TrialStatus::kPassed;
    if (run.done) {
      run.figures = trial.figures;
      run.faults = run.passed ? std::vector<std::string>() : faults(trial);
    }
  }
  return runs;
}

}  // namespace

void write_study(const TrialsOptions& options, const std::vector<Trial>& trials) {
  if (options.study) {
    const std::vector<StudyRun> runs = study_runs(trials);
    write_study_csv(options.out_dir / "study.csv", *options.study, runs);
    write_file(options.out_dir / "study.md", study_page(*options.study, runs));
  }
}

void print_study(const TrialsOptions& options, const std::vector<Trial>& trials) {
  std::printf("%s\n%s\n", study_tables(*options.study, study_runs(trials)).c_str(),
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
    const std::filesystem::path file = trial.dir / "places.csv";
    if (!is_done(trial) || !std::filesystem::exists(file)) {
      continue;
    }
    const std::vector<RecognitionRow> rows = read_recognition_rows(file);
    if (!csv) {
      csv.emplace(options.out_dir / "places.csv", columns);
    }
    for (const RecognitionRow& row : rows) {
      *csv << trial.mission;
      for (const std::string& value : trial.values) {
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
    const std::string name = trial.mission + (trial.setting.empty() ? "" : " " + trial.setting);
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
