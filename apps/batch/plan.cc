// SPDX-License-Identifier: BSD-3-Clause
#include "apps/batch/plan.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/sha256.h"

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
  std::string command = "explore";
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
                     std::move(cell.command),
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

std::shared_ptr<TrialPoint> point_of(const TrialsOptions& options, const TrialCase& one) {
  auto point = std::make_shared<TrialPoint>();
  point->mission_file = one.mission_file;
  point->command = one.command;
  point->values = one.values;
  point->setting = one.setting;
  point->cell = one.cell;
  point->limits = one.limits;
  // of two settings of one key the later one counts: the command line's before a study's, and what
  // is varied before the command line's
  const auto& first = options.study ? one.settings.set : options.set;
  const auto& then = options.study ? options.set : one.settings.set;
  point->set = first;
  point->set.insert(point->set.end(), then.begin(), then.end());
  return point;
}

std::string seed_line(std::uint64_t seed) { return "\nseed: " + std::to_string(seed) + "\n"; }

// A mission's text, of another seed; empty where that cannot be told.
std::optional<std::string> with_seed(const std::string& text, std::uint64_t from,
                                     std::uint64_t seed) {
  const std::string line = seed_line(from);
  const auto at = text.find(line);
  if (at == std::string::npos || text.find(line, at + 1) != std::string::npos) {
    return std::nullopt;
  }
  return std::string(text).replace(at, line.size(), seed_line(seed));
}

// The runs of one case, one a seed. Some missions draw more from the seed than what the line says:
// the second one resolved tells.
std::vector<Trial> trials_of(const TrialsOptions& options, const TrialCase& one) {
  const std::shared_ptr<TrialPoint> point = point_of(options, one);
  std::vector<Trial> trials;
  ResolvedMission first;
  bool only_the_line = false;
  for (const std::uint64_t seed : options.seeds) {
    Trial& trial = trials.emplace_back();
    trial.point = point;
    trial.seed = seed;
    const std::optional<std::string> by_line =
        trials.size() > 1 ? with_seed(first.text, options.seeds.front(), seed) : std::nullopt;
    if (by_line && only_the_line) {
      trial.settings_sha256 = sha256(*by_line);
      continue;
    }
    ResolvedMission resolved = options.resolve(one.command, one.mission_file, set_of(trial));
    trial.settings_sha256 = sha256(resolved.text);
    only_the_line = trials.size() == 2 && by_line == resolved.text;
    if (trials.size() == 1) {
      first = std::move(resolved);
    }
  }
  point->mission = one.mission.empty() ? first.name : one.mission;
  point->inputs = std::move(first.inputs);
  point->duration_s = first.duration_s;
  point->folder = as_folder(point->mission);
  if (!one.folder.empty()) {
    point->folder /= one.folder;
  }
  return trials;
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

std::filesystem::path folder_of(const Trial& trial, const std::filesystem::path& out_dir) {
  return out_dir / trial.point->folder / std::to_string(trial.seed);
}

std::vector<std::string> set_of(const Trial& trial) {
  std::vector<std::string> set = trial.point->set;
  set.push_back("seed=" + std::to_string(trial.seed));
  return set;
}

std::vector<Trial> plan_trials(const TrialsOptions& options) {
  std::vector<Trial> all;
  std::map<std::string, std::size_t> missions;  // by name
  std::set<std::filesystem::path> folders;
  StudyFaults faults(options);
  for (const TrialCase& one : cases_of(options)) {
    std::vector<Trial> trials;
    try {
      trials = trials_of(options, one);
    } catch (const ConfigError& error) {
      if (!options.study) {
        throw;
      }
      faults.add(one, error);
      continue;
    }
    const std::string& mission = trials.front().point->mission;
    if (missions.try_emplace(mission, one.mission_at).first->second != one.mission_at) {
      throw ConfigError(one.mission_file + ": two missions are called " + mission +
                        "; give one of them another name");
    }
    for (const Trial& trial : trials) {
      if (!folders.insert(folder_of(trial, {})).second) {
        throw ConfigError(folder_of(trial, options.out_dir).string() +
                          ": two runs would go there; a seed or a value is given twice");
      }
    }
    std::move(trials.begin(), trials.end(), std::back_inserter(all));
  }
  faults.tell();
  return all;
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

std::string numbers_text(const std::vector<std::uint64_t>& numbers) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < numbers.size();) {
    std::size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) {
      ++last;
    }
    words.push_back(last > i ? fmt::format("{}-{}", numbers[i], numbers[last])
                             : std::to_string(numbers[i]));
    i = last + 1;
  }
  return joined(words, ",");
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

void set_limits(const Study& study, std::vector<Trial>& trials) {
  const std::vector<StudyCell> cells = cells_of(study);
  std::shared_ptr<const TrialPoint> before;
  std::shared_ptr<const TrialPoint> limited;
  for (Trial& trial : trials) {
    if (trial.point != before) {
      before = trial.point;
      auto point = std::make_shared<TrialPoint>(*before);
      if (point->cell >= cells.size()) {
        throw ConfigError(study.file + ": has fewer cells than were planned of it; plan anew");
      }
      point->limits = cells[point->cell].limits;
      limited = std::move(point);
    }
    trial.point = limited;
  }
}

Shard parse_shard(std::string_view text) {
  Shard shard;
  const auto slash = text.find('/');
  const auto number = [](std::string_view digits, int& value) {
    const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return end.ec == std::errc() && end.ptr == digits.data() + digits.size();
  };
  if (slash == std::string_view::npos || !number(text.substr(0, slash), shard.index) ||
      !number(text.substr(slash + 1), shard.count) || shard.index < 1 ||
      shard.index > shard.count) {
    throw ConfigError("--shard " + std::string(text) +
                      ": must be which of how many, as 2/8 is the second of eight");
  }
  return shard;
}

void add_vary(TrialsOptions& options, const Vary& vary) {
  if (vary.key.starts_with("places.")) {
    options.set.push_back(vary.key + "=[" + joined(vary.values) + "]");
  } else {
    options.vary.push_back(vary);
  }
}

}  // namespace panoptes
