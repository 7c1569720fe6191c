// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/plan.h"

#include <charconv>
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

}  // namespace

bool is_done(const Trial& trial) {
  return trial.status != TrialStatus::kWaiting && trial.status != TrialStatus::kRunning;
}

std::filesystem::path inputs_file(const Trial& trial) {
  std::filesystem::path file = trial.dir;
  return file += ".sha256";
}

std::vector<Trial> plan_trials(const TrialsOptions& options) {
  std::vector<Trial> trials;
  std::set<std::string> names;
  std::set<std::filesystem::path> dirs;
  for (const std::string& mission : options.missions) {
    bool first = true;
    for (const auto& values : combinations(options.vary)) {
      for (const std::uint64_t seed : options.seeds) {
        Trial trial;
        trial.mission_file = mission;
        trial.values = values;
        trial.seed = seed;
        trial.set = options.set;
        for (std::size_t i = 0; i < values.size(); ++i) {
          const std::string word = options.vary[i].key + "=" + values[i];
          trial.set.push_back(word);
          trial.setting += (i > 0 ? "," : "") + word;
        }
        trial.set.push_back("seed=" + std::to_string(seed));
        ResolvedMission resolved = options.resolve(mission, trial.set);
        trial.mission = resolved.name;
        trial.mission_text = std::move(resolved.text);
        trial.inputs = std::move(resolved.inputs);
        if (first && !names.insert(trial.mission).second) {
          throw ConfigError(mission + ": two missions are called " + trial.mission +
                            "; give one of them another name");
        }
        first = false;
        trial.dir = options.out_dir / as_folder(trial.mission);
        if (!trial.setting.empty()) {
          trial.dir /= as_folder(trial.setting);
        }
        trial.dir /= std::to_string(seed);
        if (!dirs.insert(trial.dir).second) {
          throw ConfigError(trial.dir.string() +
                            ": two runs would go there; a seed or a value is given twice");
        }
        trials.push_back(std::move(trial));
      }
    }
  }
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
