// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/results.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/inputs.h"
#include "core/config/sha256.h"
#include "core/io/csv.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

void flatten(const Json& json, const std::string& path,
             std::vector<std::pair<std::string, double>>& into) {
  for (const auto& [key, value] : json.items()) {
    std::string here = path;
    here += path.empty() ? "" : ".";
    here += key;
    if (value.is_object()) {
      flatten(value, here, into);
    } else if (value.is_number() && here != "seed") {
      into.emplace_back(here, value.get<double>());
    }
  }
}

std::optional<std::string> text_of(const std::filesystem::path& path) {
  try {
    return read_file(path);
  } catch (const ConfigError&) {
    return std::nullopt;
  }
}

/// Takes the run's figures; false when they are none.
bool take_metrics(const Json& metrics, Trial& trial) {
  if (!metrics.is_object() || !metrics.contains("outcome") || !metrics["outcome"].is_string()) {
    return false;
  }
  trial.outcome = metrics["outcome"].get<std::string>();
  trial.cut_short = metrics.contains("fault");
  trial.wall_s = metrics.value("wall_s", 0.0);
  trial.figures.clear();
  flatten(metrics, "", trial.figures);
  trial.broken.clear();
  trial.required.clear();
  for (const Json& line : metrics.value("requirements", Json::array())) {
    if (line.contains("pass") && line["pass"].is_null()) {  // not judged
      continue;
    }
    trial.required.emplace_back(line.value("require", ""), line.value("pass", false));
    if (!line.value("pass", false)) {
      trial.broken.push_back(line.value("require", ""));
      trial.broken.back() +=
          line.contains("value") ? ", it is " + line["value"].dump() : ", no such figure";
    }
  }
  const std::map<std::string, double> figures(trial.figures.begin(), trial.figures.end());
  for (const Limit& limit : trial.limits) {
    const std::string broken = broken_by(limit, figures);
    trial.required.emplace_back(limit.text, broken.empty());
    if (!broken.empty()) {
      trial.broken.push_back(broken);
    }
  }
  trial.status = trial.outcome == "completed" && trial.broken.empty() ? TrialStatus::kPassed
                                                                      : TrialStatus::kFailed;
  return true;
}

/// Files as they are now; each is read once.
class FilesNow {
 public:
  const std::string& hash(const std::string& file) {
    auto [at, is_new] = hashes_.try_emplace(file);
    if (is_new) {
      if (const auto bytes = text_of(file)) {
        at->second = sha256(*bytes);
      }
    }
    return at->second;
  }

 private:
  std::map<std::string, std::string> hashes_;
};

/// What of all that a finished run was made of is another now; empty when nothing is.
std::string changed_since(const Trial& trial, const std::filesystem::path& program, FilesNow& now) {
  const auto listing = text_of(inputs_file(trial));
  if (!listing) {
    return "a run that does not say what it was made of (" + inputs_file(trial).string() +
           " is missing)";
  }
  const std::map<std::string, std::string> made_of = parse_inputs(*listing);
  if (std::none_of(made_of.begin(), made_of.end(),
                   [&](const auto& input) { return input.second == now.hash(program); })) {
    return "a run of another program";
  }
  for (const auto& [file, hash] : made_of) {
    if (now.hash(file) != hash) {
      return "a run of before " + file + " changed";
    }
  }
  for (const auto& [file, hash] : trial.inputs) {
    if (!made_of.contains(file)) {
      return "a run that did not read " + file;
    }
  }
  return {};
}

/// The last thing a broken run said.
std::string last_words(const Trial& trial) {
  std::filesystem::path log = trial.dir;
  log += ".log";
  std::string text = text_of(log).value_or("");
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) {
    text.pop_back();
  }
  const auto line = text.rfind('\n');
  return line == std::string::npos ? text : text.substr(line + 1);
}

}  // namespace

bool take_metrics(Trial& trial) {
  const auto text = text_of(trial.dir / "metrics.json");
  if (!text) {
    return false;
  }
  try {
    return take_metrics(Json::parse(*text), trial);
  } catch (const Json::exception&) {
    return false;
  }
}

bool is_finished(Trial& trial) {
  if (text_of(trial.dir / "mission.yaml") != trial.mission_text || !take_metrics(trial) ||
      trial.outcome == "interrupted" || trial.outcome == "device_lost" || trial.cut_short) {
    trial.status = TrialStatus::kWaiting;
    return false;
  }
  return true;
}

std::vector<std::string> faults(const Trial& trial) {
  if (trial.status == TrialStatus::kBroken) {
    const std::string words = last_words(trial);
    return {trial.outcome + (words.empty() ? "" : ": " + words)};
  }
  std::vector<std::string> all = trial.broken;
  if (trial.outcome != "completed") {
    all.insert(all.begin(), "outcome is " + trial.outcome);
  }
  return all;
}

void check_what_is_there(const TrialsOptions& options, std::vector<Trial>& trials) {
  const auto refuse = [](const std::filesystem::path& where, const std::string& what) {
    throw ConfigError(where.string() + ": " + what + " name another folder with --out");
  };
  FilesNow now;
  for (Trial& trial : trials) {
    const std::optional<std::string> text = text_of(trial.dir / "mission.yaml");
    if (text && *text != trial.mission_text) {
      refuse(trial.dir, "holds a run with other settings or of another version;");
    }
    if (is_finished(trial)) {
      if (const std::string what = changed_since(trial, options.program, now); !what.empty()) {
        refuse(trial.dir, "holds " + what + ";");
      }
    }
  }
  const std::filesystem::path table = options.out_dir / "trials.csv";
  std::error_code fault;
  if (!std::filesystem::exists(table, fault)) {
    return;
  }
  CsvTable before;
  try {
    before = read_csv(table);
  } catch (const IoError& error) {
    throw ConfigError(std::string(error.what()) + "; name another folder with --out");
  }
  std::vector<std::string> head = {"mission"};
  const std::vector<std::string> keys = varied(options);
  head.insert(head.end(), keys.begin(), keys.end());
  head.emplace_back("seed");
  if (before.columns.size() < head.size() ||
      !std::equal(head.begin(), head.end(), before.columns.begin())) {
    refuse(table, "is of trials that varied other settings;");
  }
  std::set<std::vector<std::string>> planned;
  for (const Trial& trial : trials) {
    std::vector<std::string> words = {trial.mission};
    words.insert(words.end(), trial.values.begin(), trial.values.end());
    words.push_back(std::to_string(trial.seed));
    planned.insert(words);
  }
  for (const auto& row : before.rows) {
    const std::vector<std::string> words(row.begin(),
                                         row.begin() + static_cast<std::ptrdiff_t>(head.size()));
    if (!planned.contains(words)) {
      std::vector<std::string> all = words;
      all.back().insert(0, "seed ");
      refuse(table, "holds " + joined(all, " ") +
                        ", which is not among these runs; ask for it as well, or");
    }
  }
}

}  // namespace panoptes
