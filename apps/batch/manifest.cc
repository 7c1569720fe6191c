// SPDX-License-Identifier: BSD-3-Clause
#include "apps/batch/manifest.h"

#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "apps/command/process_name.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/config/sha256.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr const char* kSchema = "panoptes.manifest/1";

Json vary_json(const std::vector<Vary>& vary) {
  Json all = Json::array();
  for (const Vary& one : vary) {
    all.push_back({{"key", one.key}, {"values", one.values}});
  }
  return all;
}

Json asked_json(const TrialsOptions& options) {
  const std::string study = options.study ? options.study->file : "";
  return {{"missions", options.missions},
          {"study", study},
          {"study_sha256", study.empty() ? "" : sha256(read_file(study))},
          {"seeds", numbers_text(options.seeds)},
          {"vary", vary_json(options.vary)},
          {"set", options.set},
          {"keep", options.keep == Keep::kMetrics ? "metrics" : "all"}};
}

void take_asked(const Json& json, Manifest& manifest) {
  manifest.asked = json.dump();
  manifest.study_file = json.at("study").get<std::string>();
  manifest.study_sha256 = json.at("study_sha256").get<std::string>();
  for (const Json& one : json.at("vary")) {
    manifest.vary.push_back(
        {one.at("key").get<std::string>(), one.at("values").get<std::vector<std::string>>()});
  }
  manifest.keep = json.at("keep") == "metrics" ? Keep::kMetrics : Keep::kAll;
}

std::shared_ptr<const TrialPoint> point_of(const Json& json) {
  auto point = std::make_shared<TrialPoint>();
  point->mission_file = json.at("mission_file").get<std::string>();
  point->command = json.at("command").get<std::string>();
  point->mission = json.at("mission").get<std::string>();
  point->values = json.at("values").get<std::vector<std::string>>();
  point->setting = json.at("setting").get<std::string>();
  point->cell = json.at("cell").get<std::size_t>();
  point->set = json.at("set").get<std::vector<std::string>>();
  point->folder = json.at("folder").get<std::string>();
  point->duration_s = json.at("duration_s").get<double>();
  point->inputs = json.at("inputs").get<std::map<std::string, std::string>>();
  return point;
}

Json point_json(std::size_t number, const TrialPoint& point) {
  return {{"point", number},
          {"mission_file", point.mission_file},
          {"command", point.command},
          {"mission", point.mission},
          {"values", point.values},
          {"setting", point.setting},
          {"cell", point.cell},
          {"set", point.set},
          {"folder", point.folder.string()},
          {"duration_s", point.duration_s},
          {"inputs", point.inputs}};
}

std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

// The head, then each point before its runs.
void read_lines(std::istream& lines, Manifest& manifest) {
  std::string line;
  std::shared_ptr<const TrialPoint> point;
  std::size_t runs = 0;
  while (std::getline(lines, line)) {
    const Json json = Json::parse(line);
    if (json.contains("schema")) {
      take_asked(json.at("asked"), manifest);
      manifest.varied = json.at("varied").get<std::vector<std::string>>();
      manifest.version = json.at("version").get<std::string>();
      manifest.program_sha256 = json.at("program_sha256").get<std::string>();
      manifest.working_folder = json.at("working_folder").get<std::string>();
      runs = json.at("runs").get<std::size_t>();
      manifest.trials.reserve(runs);
    } else if (json.contains("mission")) {
      point = point_of(json);
    } else {
      Trial& trial = manifest.trials.emplace_back();
      trial.point = point;
      trial.seed = json.at("seed").get<std::uint64_t>();
      trial.settings_sha256 = json.at("settings_sha256").get<std::string>();
    }
  }
  if (runs == 0 || manifest.trials.size() != runs || !point) {
    throw ConfigError("is cut short");
  }
}

}  // namespace

fs::path manifest_file(const fs::path& out_dir) { return out_dir / "manifest.jsonl"; }

void write_manifest(const TrialsOptions& options, const std::string& program_sha256,
                    const std::vector<Trial>& trials) {
  const fs::path file = manifest_file(options.out_dir);
  fs::path mine = file;
  mine += fmt::format(".{}", process_name());
  {
    AtomicFile out(mine);
    out.append(line_of({{"schema", kSchema},
                        {"version", options.version},
                        {"program_sha256", program_sha256},
                        {"working_folder", fs::current_path().string()},
                        {"asked", asked_json(options)},
                        {"varied", varied(options)},
                        {"runs", trials.size()}}));
    std::size_t points = 0;
    const TrialPoint* point = nullptr;
    for (const Trial& trial : trials) {
      if (trial.point.get() != point) {
        point = trial.point.get();
        out.append(line_of(point_json(points++, *point)));
      }
      out.append(fmt::format("{{\"point\":{},\"seed\":{},\"settings_sha256\":\"{}\"}}\n",
                             points - 1, trial.seed, trial.settings_sha256));
    }
    out.commit();
  }
  fs::rename(mine, file);
}

Manifest read_manifest(const fs::path& out_dir) {
  const fs::path file = manifest_file(out_dir);
  std::ifstream lines(file);
  if (!lines) {
    throw ConfigError(file.string() +
                      ": cannot be read; name the missions or the study, and trials are planned");
  }
  Manifest manifest;
  try {
    read_lines(lines, manifest);
  } catch (const std::exception& error) {
    throw ConfigError(file.string() + ": is no manifest of trials, or damaged (" + error.what() +
                      "); remove it and plan anew");
  }
  return manifest;
}

void check_asked_for(const Manifest& manifest, const TrialsOptions& options) {
  if (asked_json(options).dump() != manifest.asked || manifest.version != options.version) {
    throw ConfigError(manifest_file(options.out_dir).string() +
                      ": is of other trials than these; leave the missions and settings out to go "
                      "on with those, or name another folder with --out");
  }
}

void check_holds_no_others(const TrialsOptions& options, const std::vector<Trial>& trials) {
  const fs::path file = manifest_file(options.out_dir);
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    return;
  }
  const auto refuse = [&](const std::string& what) {
    throw ConfigError(file.string() + ": " + what + " name another folder with --out");
  };
  const Manifest there = read_manifest(options.out_dir);
  if (there.varied != varied(options)) {
    refuse("is of trials that varied other settings;");
  }
  std::set<fs::path> planned;
  for (const Trial& trial : trials) {
    planned.insert(folder_of(trial, {}));
  }
  for (const Trial& trial : there.trials) {
    if (!planned.contains(folder_of(trial, {}))) {
      refuse(
          fmt::format("holds {}{}{} seed {}, which is not among these runs; ask for it as well, "
                      "or",
                      trial.point->mission, trial.point->values.empty() ? "" : " ",
                      joined(trial.point->values, " "), trial.seed));
    }
  }
}

}  // namespace panoptes
