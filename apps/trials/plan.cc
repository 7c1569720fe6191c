// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/plan.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"

namespace panoptes {
namespace {

std::string as_folder(std::string text) {
  for (char& c : text) {
    if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < ' ') {
      c = '_';
    }
  }
  constexpr std::size_t kLongest = 200;  // a file name holds 255 bytes
  return text.substr(0, kLongest);
}

/// A name of a study, as people type it in a shell.
std::string without_spaces(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '-');
  return as_folder(name);
}

/// Every combination of the varied values, as overrides.
std::vector<std::vector<std::string>> combinations(const std::vector<Vary>& vary) {
  std::vector<std::vector<std::string>> all{{}};
  for (const Vary& v : vary) {
    std::vector<std::vector<std::string>> longer;
    for (const auto& values : all) {
      for (const std::string& value : v.values) {
        longer.push_back(values);
        longer.back().push_back(value);
      }
    }
    all = std::move(longer);
  }
  return all;
}

// Runs that differ in their seed alone.
struct TrialCase {
  std::string mission_file;
  std::size_t mission_at = 0;  // among the missions of the command line
  std::string mission;         // its name; empty: as the file says
  std::vector<std::string> values;
  std::string setting;
  std::filesystem::path folder;  // within the mission's
  std::size_t cell = 0;
  StudySettings settings;  // without places where they are not from a study
  std::vector<Limit> limits;
};

std::vector<TrialCase> cases_of(const Study& study) {
  std::vector<TrialCase> cases;
  for (StudyCell& cell : cells_of(study)) {
    cases.push_back({std::move(cell.mission_file),
                     0,
                     std::move(cell.mission),
                     {cell.rig, cell.rung},
                     cell.rig + ", " + cell.rung,
                     std::filesystem::path(without_spaces(cell.rig)) / without_spaces(cell.rung),
                     cases.size(),
                     std::move(cell.settings),
                     std::move(cell.limits)});
  }
  return cases;
}

std::vector<TrialCase> cases_of(const TrialsOptions& options) {
  if (options.study) {
    return cases_of(*options.study);
  }
  std::vector<TrialCase> cases;
  for (std::size_t at = 0; at < options.missions.size(); ++at) {
    for (const auto& values : combinations(options.vary)) {
      TrialCase one;
      one.mission_file = options.missions[at];
      one.mission_at = at;
      one.values = values;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::string word = options.vary[i].key + "=" + values[i];
        one.settings.set.push_back(word);
        one.setting += (i > 0 ? "," : "") + word;
      }
      one.folder = as_folder(one.setting);
      cases.push_back(std::move(one));
    }
  }
  return cases;
}

Trial trial_of(const TrialsOptions& options, const TrialCase& one, std::uint64_t seed) {
  Trial trial;
  trial.mission_file = one.mission_file;
  trial.values = one.values;
  trial.setting = one.setting;
  trial.cell = one.cell;
  trial.limits = one.limits;
  trial.seed = seed;
  // of two settings of one key the later one counts: the command line's before a study's, and what
  // is varied before the command line's
  const auto& first = options.study ? one.settings.set : options.set;
  const auto& then = options.study ? options.set : one.settings.set;
  trial.set = first;
  trial.set.insert(trial.set.end(), then.begin(), then.end());
  trial.set.push_back("seed=" + std::to_string(seed));
  ResolvedMission resolved = options.resolve(one.mission_file, trial.set);
  trial.mission = one.mission.empty() ? resolved.name : one.mission;
  trial.mission_text = std::move(resolved.text);
  trial.inputs = std::move(resolved.inputs);
  trial.dir = options.out_dir / as_folder(trial.mission);
  if (!one.folder.empty()) {
    trial.dir /= one.folder;
  }
  trial.dir /= std::to_string(seed);
  return trial;
}

// What the command line says counts: of a fault there the study has no place.
StudySettings not_said_again(const StudySettings& settings, const std::vector<std::string>& set) {
  const auto key = [](const std::string& word) { return word.substr(0, word.find('=')); };
  StudySettings left;
  for (std::size_t i = 0; i < settings.places.size(); ++i) {
    if (std::none_of(set.begin(), set.end(),
                     [&](const std::string& word) { return key(word) == key(settings.set[i]); })) {
      left.set.push_back(settings.set[i]);
      left.places.push_back(settings.places[i]);
    }
  }
  return left;
}

// Everything that is wrong with the missions of a study, each thing once.
class StudyFaults {
 public:
  explicit StudyFaults(const TrialsOptions& options) : options_(options) {}

  void add(const TrialCase& of, const ConfigError& error) {
    for (const std::string& line :
         with_places(not_said_again(of.settings, options_.set), error.lines())) {
      if (std::find(lines_.begin(), lines_.end(), line) == lines_.end()) {
        lines_.push_back(line);
      }
    }
  }
  void tell() const {
    if (!lines_.empty()) {
      throw ConfigError(lines_);
    }
  }

 private:
  const TrialsOptions& options_;
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> varied(const TrialsOptions& options) {
  if (options.study) {
    return {"rig", "rung"};
  }
  std::vector<std::string> keys;
  for (const Vary& v : options.vary) {
    keys.push_back(v.key);
  }
  return keys;
}

bool is_done(const Trial& trial) {
  return trial.status != TrialStatus::kWaiting && trial.status != TrialStatus::kRunning;
}

std::filesystem::path inputs_file(const Trial& trial) {
  std::filesystem::path file = trial.dir;
  return file += ".sha256";
}

std::vector<Trial> plan_trials(const TrialsOptions& options) {
  std::vector<Trial> trials;
  std::map<std::string, std::size_t> missions;  // by name
  std::set<std::filesystem::path> dirs;
  StudyFaults faults(options);
  for (const TrialCase& one : cases_of(options)) {
    for (const std::uint64_t seed : options.seeds) {
      std::optional<Trial> trial;
      try {
        trial = trial_of(options, one, seed);
      } catch (const ConfigError& error) {
        if (!options.study) {
          throw;
        }
        faults.add(one, error);
        break;
      }
      if (missions.try_emplace(trial->mission, one.mission_at).first->second != one.mission_at) {
        throw ConfigError(one.mission_file + ": two missions are called " + trial->mission +
                          "; give one of them another name");
      }
      if (!dirs.insert(trial->dir).second) {
        throw ConfigError(trial->dir.string() +
                          ": two runs would go there; a seed or a value is given twice");
      }
      trials.push_back(std::move(*trial));
    }
  }
  faults.tell();
  return trials;
}

std::vector<std::uint64_t> parse_seeds(std::string_view text) {
  const auto fault = [&](const std::string& what = "must be numbers and ranges, as 1-5,101") {
    return ConfigError("--seeds " + std::string(text) + ": " + what);
  };
  std::vector<std::uint64_t> seeds;
  std::string_view rest = text;
  const auto number = [&] {
    std::uint64_t value = 0;
    const auto end = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (end.ec != std::errc()) {
      throw fault();
    }
    rest.remove_prefix(static_cast<std::size_t>(end.ptr - rest.data()));
    return value;
  };
  while (true) {
    const std::uint64_t first = number();
    std::uint64_t last = first;
    if (rest.starts_with('-')) {
      rest.remove_prefix(1);
      last = number();
    }
    constexpr std::uint64_t kMost = 100'000;  // a slip of the pen, not a study
    const std::string range = std::to_string(first) + "-" + std::to_string(last);
    if (last < first) {
      throw fault(range + " descends; write the lower number first");
    }
    if (last - first >= kMost - seeds.size()) {
      throw fault(range + " makes too many; at most " + std::to_string(kMost) + " may be given");
    }
    for (std::uint64_t i = 0; i <= last - first; ++i) {
      seeds.push_back(first + i);
    }
    if (rest.empty()) {
      return seeds;
    }
    if (!rest.starts_with(',')) {
      throw fault();
    }
    rest.remove_prefix(1);
  }
}

Vary parse_vary(std::string_view text) {
  const auto at = text.find('=');
  if (at == std::string_view::npos || at == 0 || at + 1 == text.size()) {
    throw ConfigError("--vary " + std::string(text) + ": must be key.path=value,value");
  }
  Vary vary{std::string(text.substr(0, at)), {""}};
  int depth = 0;
  for (const char c : text.substr(at + 1)) {
    depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
    if (c == ',' && depth == 0) {
      vary.values.emplace_back();
    } else {
      vary.values.back() += c;
    }
  }
  for (const std::string& value : vary.values) {
    if (value.empty()) {
      throw ConfigError("--vary " + std::string(text) + ": has an empty value");
    }
  }
  return vary;
}

void add_vary(TrialsOptions& options, const Vary& vary) {
  if (vary.key.starts_with("places.")) {
    options.set.push_back(vary.key + "=[" + joined(vary.values) + "]");
  } else {
    options.vary.push_back(vary);
  }
}

}  // namespace panoptes
