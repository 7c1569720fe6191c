// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/sweep_report.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/process/stage_clock.h"
#include "core/base/text.h"
#include "core/base/utf8.h"
#include "core/config/fields.h"
#include "core/io/csv.h"
#include "core/io/digits.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kShown = 10;

std::string number(const NamedScore& name, const std::optional<double>& value) {
  return value ? fmt::format("{:.{}f}", *value * name.scale, name.digits) : "-";
}

std::string with_unit(const NamedScore& name) {
  return name.unit.empty() ? name.key : name.key + " (" + name.unit + ")";
}

/// How many rigs hold each line, of those that can be.
std::vector<std::size_t> met_of(const PlacementStudy& study, const RigSweep& sweep) {
  std::vector<std::size_t> met(study.require.size(), sweep.ranked.size());
  for (const std::size_t i : sweep.ranked) {
    for (const std::size_t line : sweep.rigs[i].broken) {
      --met[line];
    }
  }
  return met;
}

std::size_t good_of(const RigSweep& sweep) {
  return static_cast<std::size_t>(std::count_if(
      sweep.rigs.begin(), sweep.rigs.end(), [](const SweptRig& swept) { return swept.good(); }));
}

/// Reasons why rigs cannot be, without their numbers, the most frequent first.
std::vector<std::pair<std::string, int>> refusals_of(const RigSweep& sweep) {
  std::map<std::string, std::pair<std::string, int>> by_words;
  for (const SweptRig& swept : sweep.rigs) {
    if (swept.refused.empty()) {
      continue;
    }
    std::string words = swept.refused;
    words.erase(std::remove_if(words.begin(), words.end(),
                               [](unsigned char c) { return c >= '0' && c <= '9'; }),
                words.end());
    auto& [first, count] = by_words[words];
    first = count == 0 ? swept.refused : first;
    ++count;
  }
  std::vector<std::pair<std::string, int>> all;
  for (const auto& [words, reason] : by_words) {
    all.push_back(reason);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return all;
}

std::vector<std::string> names_of(const PlacementStudy& study) {
  std::vector<std::string> names;
  for (const auto& [name, parameter] : study.parameters) {
    names.push_back(name);
  }
  return names;
}

Json best_of(const PlacementStudy& study, const RigSweep& sweep) {
  const std::vector<std::string> names = names_of(study);
  Json best = Json::array();
  for (std::size_t k = 0; k < std::min(kShown, sweep.ranked.size()); ++k) {
    const SweptRig& swept = sweep.rigs[sweep.ranked[k]];
    Json parameters = Json::object();
    for (std::size_t i = 0; i < names.size(); ++i) {
      parameters[names[i]] = as_utf8(swept.point.values[i]);
    }
    Json objectives = Json::object();
    for (const std::size_t score : sweep.objectives) {
      if (swept.scores[score]) {
        objectives[sweep.names[score].key] = *swept.scores[score];
      }
    }
    best.push_back({{"rig", sweep.ranked[k] + 1},
                    {"good", swept.good()},
                    {"pareto", swept.pareto},
                    {"parameters", parameters},
                    {"objectives", objectives}});
  }
  return best;
}

}  // namespace

std::string sweep_table(const PlacementStudy& study, const RigSweep& sweep) {
  std::string text = fmt::format(
      "{} tried, {} cannot be, {} hold what is required, {} of these are the Pareto set\n",
      counted(sweep.rigs.size(), "rig"), sweep.rigs.size() - sweep.ranked.size(), good_of(sweep),
      std::count_if(sweep.rigs.begin(), sweep.rigs.end(),
                    [](const SweptRig& swept) { return swept.pareto; }));
  const std::vector<std::size_t> met = met_of(study, sweep);
  for (std::size_t i = 0; i < met.size(); ++i) {
    text += fmt::format("  {}: {} of {}\n", study.require[i], met[i], sweep.ranked.size());
  }
  for (const auto& [reason, count] : refusals_of(sweep)) {
    text += fmt::format("  refused, {} as this one: {}\n", counted(count, "rig"), reason);
  }
  std::vector<std::vector<std::string>> rows{{"", "rig"}};
  for (const std::string& name : names_of(study)) {
    rows[0].push_back(name);
  }
  for (const std::size_t score : sweep.objectives) {
    rows[0].push_back(with_unit(sweep.names[score]));
  }
  rows[0].push_back("");
  for (std::size_t k = 0; k < std::min(kShown, sweep.ranked.size()); ++k) {
    const SweptRig& swept = sweep.rigs[sweep.ranked[k]];
    std::vector<std::string> row{std::to_string(k + 1), std::to_string(sweep.ranked[k] + 1)};
    for (const std::string& value : swept.point.values) {
      const std::optional<double> drawn = parse_number(value);
      row.push_back(drawn ? fmt::format("{:.4g}", *drawn) : value);
    }
    for (const std::size_t score : sweep.objectives) {
      row.push_back(number(sweep.names[score], swept.scores[score]));
    }
    row.push_back(!swept.good()  ? "breaks " + study.require[swept.broken.front()]
                  : swept.pareto ? "pareto"
                                 : "");
    rows.push_back(std::move(row));
  }
  std::vector<std::size_t> widths(rows[0].size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], row[i].size());
    }
  }
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool last = i + 1 == row.size();
      text += last ? row[i] : fmt::format("{:>{}}  ", row[i], widths[i]);
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  }
  return text;
}

void write_sweep_csv(const std::filesystem::path& file, const PlacementStudy& study,
                     const RigSweep& sweep) {
  std::vector<std::string> columns{"rig", "rank", "verdict", "faults", "pareto"};
  for (const std::string& name : names_of(study)) {
    columns.push_back(name);
  }
  for (const NamedScore& name : sweep.names) {
    columns.push_back(name.key);
  }
  std::vector<int> ranks(sweep.rigs.size(), 0);
  for (std::size_t k = 0; k < sweep.ranked.size(); ++k) {
    ranks[sweep.ranked[k]] = static_cast<int>(k) + 1;
  }
  CsvWriter csv(file, columns);
  for (std::size_t i = 0; i < sweep.rigs.size(); ++i) {
    const SweptRig& swept = sweep.rigs[i];
    csv << static_cast<int>(i) + 1;
    if (ranks[i] > 0) {
      csv << ranks[i];
    } else {
      csv.skip();
    }
    std::vector<std::string> faults;
    for (const std::size_t line : swept.broken) {
      faults.push_back(study.require[line]);
    }
    csv << (swept.good()            ? "good"
            : swept.refused.empty() ? "broken"
                                    : "refused")
        << (swept.refused.empty() ? joined(faults, "; ") : swept.refused) << (swept.pareto ? 1 : 0);
    for (const std::string& value : swept.point.values) {
      csv << value;
    }
    for (std::size_t k = 0; k < sweep.names.size(); ++k) {
      if (swept.refused.empty() && swept.scores[k]) {
        csv << *swept.scores[k];
      } else {
        csv.skip();
      }
    }
    csv.end_row();
  }
  csv.finish();
}

std::string sweep_metrics(const PlacementStudy& study, const RigSweep& sweep,
                          const std::string& version) {
  Json requirements = Json::array();
  const std::vector<std::size_t> met = met_of(study, sweep);
  for (std::size_t i = 0; i < met.size(); ++i) {
    requirements.push_back(
        {{"require", study.require[i]}, {"rigs", sweep.ranked.size()}, {"met", met[i]}});
  }
  const std::size_t good = good_of(sweep);
  const ProcessUse use = process_use();
  const Json metrics{{"schema", "panoptes.metrics/1"},
                     {"command", "place"},
                     {"version", version},
                     {"outcome", sweep.cut_short ? "interrupted"
                                 : good > 0      ? "completed"
                                                 : "failed"},
                     {"tried", sweep.rigs.size()},
                     {"refused", sweep.rigs.size() - sweep.ranked.size()},
                     {"good", good},
                     {"requirements", requirements},
                     {"best", best_of(study, sweep)},
                     {"wall_s", use.wall_s},
                     {"cpu_s", use.cpu_s},
                     {"peak_memory_mb", use.peak_memory_mb}};
  return metrics.dump(2) + "\n";
}

std::string best_rig_file(const PlacementStudy& study, const RigSweep& sweep) {
  const std::size_t best = sweep.ranked.front();
  const SweptRig& swept = sweep.rigs[best];
  std::string text = fmt::format("# The best of {} by {}: rig {}.\n",
                                 counted(sweep.rigs.size(), "rig"), study.file, best + 1);
  for (const std::string& setting : swept.point.settings.set) {
    text += "# " + setting + "\n";
  }
  for (const std::size_t score : sweep.objectives) {
    const NamedScore& name = sweep.names[score];
    text += fmt::format("# {}: {} {}\n", name.key, number(name, swept.scores[score]), name.unit);
  }
  for (std::size_t i = 0; i < study.require.size(); ++i) {
    const bool broken =
        std::find(swept.broken.begin(), swept.broken.end(), i) != swept.broken.end();
    text += fmt::format("# {} {}\n", broken ? "breaks" : "holds", study.require[i]);
  }
  return text + write_settings(rig_of(study, swept.point));
}

}  // namespace panoptes
