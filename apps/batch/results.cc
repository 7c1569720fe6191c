// SPDX-License-Identifier: BSD-3-Clause
#include "apps/batch/results.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/config/inputs.h"
#include "core/config/sha256.h"
#include "core/io/file.h"

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

/// Judges it by what it says.
void judge(const Json& metrics, Trial& trial) {
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
  if (!trial.point->limits.empty()) {
    const std::map<std::string, double> figures = trial.figures.by_name();
    for (const Limit& limit : trial.point->limits) {
      const std::string broken = broken_by(limit, figures);
      trial.required.emplace_back(limit.text, broken.empty());
      if (!broken.empty()) {
        trial.broken.push_back(broken);
      }
    }
  }
  trial.status = trial.outcome == "completed" && trial.broken.empty() ? TrialStatus::kPassed
                                                                      : TrialStatus::kFailed;
}

/// The last thing a broken run said.
std::string last_words(const std::filesystem::path& folder) {
  std::string text = text_of(folder / kLogFile).value_or("");
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) {
    text.pop_back();
  }
  const auto line = text.rfind('\n');
  return line == std::string::npos ? text : text.substr(line + 1);
}

}  // namespace

bool has_settings_of(const Trial& trial, const std::filesystem::path& folder) {
  const auto text = text_of(folder / "mission.yaml");
  return text && sha256(*text) == trial.settings_sha256;
}

const std::string& Results::hash_now(const std::string& file) {
  auto [at, is_new] = hashes_.try_emplace(file);
  if (is_new) {
    if (const auto bytes = text_of(file)) {
      at->second = sha256(*bytes);
    }
  }
  return at->second;
}

bool Results::take_metrics(Trial& trial, const std::filesystem::path& folder) {
  const auto text = text_of(folder / "metrics.json");
  if (!text) {
    return false;
  }
  try {
    const Json metrics = Json::parse(*text);
    if (!metrics.is_object() || !metrics.contains("outcome") || !metrics["outcome"].is_string()) {
      return false;
    }
    trial.outcome = metrics["outcome"].get<std::string>();
    trial.cut_short = metrics.contains("fault");
    trial.wall_s = metrics.value("wall_s", 0.0);
    std::vector<std::pair<std::string, double>> figures;
    flatten(metrics, "", figures);
    trial.figures = rows_.row(figures);
    judge(metrics, trial);
  } catch (const Json::exception&) {
    return false;
  }
  return true;
}

void Results::take(Trial& trial) {
  const std::filesystem::path folder = folder_of(trial, options_.out_dir);
  if (const auto ended = text_of(folder / kEndFile)) {
    trial.status = TrialStatus::kBroken;
    trial.outcome = *ended;
    trial.figures = {};
  } else if (!has_settings_of(trial, folder) || !take_metrics(trial, folder) ||
             trial.outcome == "interrupted") {
    trial.status = TrialStatus::kWaiting;
  }
  if (trial.status == TrialStatus::kWaiting) {
    trial.figures = {};
  }
}

bool Results::take_finished(Trial& trial) {
  take(trial);
  if (trial.status == TrialStatus::kBroken || trial.outcome == "device_lost" || trial.cut_short) {
    trial.status = TrialStatus::kWaiting;
    trial.figures = {};
  }
  return is_done(trial);
}

void Results::check_what_is_there(const Trial& trial) {
  const std::filesystem::path folder = folder_of(trial, options_.out_dir);
  const auto refuse = [&](const std::string& what) {
    throw ConfigError(folder.string() + ": holds " + what + "; name another folder with --out");
  };
  std::error_code ignored;
  if (std::filesystem::exists(folder / "mission.yaml", ignored) &&
      !std::filesystem::exists(folder / kEndFile, ignored) && !has_settings_of(trial, folder)) {
    refuse("a run with other settings or of another version");
  }
  if (trial.status == TrialStatus::kPassed || trial.status == TrialStatus::kFailed) {
    if (const std::string what = changed_since(trial); !what.empty()) {
      refuse(what);
    }
  }
}

// What of all that a finished run was made of is another now; empty when nothing is.
std::string Results::changed_since(const Trial& trial) {
  const std::filesystem::path file = folder_of(trial, options_.out_dir) / kInputsFile;
  const auto listing = text_of(file);
  if (!listing) {
    return "a run that does not say what it was made of (" + file.string() + " is missing)";
  }
  const std::map<std::string, std::string> made_of = parse_inputs(*listing);
  const std::string& program = hash_now(options_.program);
  if (std::none_of(made_of.begin(), made_of.end(),
                   [&](const auto& input) { return input.second == program; })) {
    return "a run of another program";
  }
  for (const auto& [name, hash] : made_of) {
    if (hash_now(name) != hash) {
      return "a run of before " + name + " changed";
    }
  }
  for (const auto& [name, hash] : trial.point->inputs) {
    if (!made_of.contains(name)) {
      return "a run that did not read " + name;
    }
  }
  return {};
}

void Results::check_made_of(const std::string& program_sha256, const TrialPoint& point) {
  if (hash_now(options_.program) != program_sha256) {
    throw ConfigError((options_.out_dir / "manifest.jsonl").string() +
                      ": was planned by another program; run that one, or name another folder "
                      "with --out");
  }
  for (const auto& [name, hash] : point.inputs) {
    if (hash_now(name) != hash) {
      throw ConfigError(name + ": has changed since " +
                        (options_.out_dir / "manifest.jsonl").string() +
                        " was planned; put it back, or name another folder with --out");
    }
  }
}

std::vector<std::string> faults(const Trial& trial, const TrialsOptions& options) {
  if (trial.status == TrialStatus::kBroken) {
    const std::string words = last_words(folder_of(trial, options.out_dir));
    return {trial.outcome + (words.empty() ? "" : ": " + words)};
  }
  std::vector<std::string> all = trial.broken;
  if (trial.outcome != "completed") {
    all.insert(all.begin(), "outcome is " + trial.outcome);
  }
  return all;
}

}  // namespace panoptes
