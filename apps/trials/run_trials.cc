// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/run_trials.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "apps/command/folder_lock.h"
#include "apps/draw/pictures.h"
#include "apps/mission/until.h"
#include "apps/process/fault.h"
#include "apps/process/progress.h"
#include "apps/process/stage_clock.h"
#include "apps/recognition/recognition_table.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/time.h"
#include "core/base/utf8.h"
#include "core/config/inputs.h"
#include "core/config/sha256.h"
#include "core/eval/statistics.h"
#include "core/io/csv.h"
#include "core/io/digits.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

enum class Status { kWaiting, kRunning, kPassed, kFailed, kBroken };

struct Trial {
  std::string mission_file;
  std::string mission;
  std::vector<std::string> values;  ///< of the varied settings, in their order
  std::string setting;              ///< the same as words; empty when nothing is varied
  std::uint64_t seed = 0;
  std::vector<std::string> set;  ///< all overrides
  std::filesystem::path dir;
  std::string mission_text;                   ///< what its mission.yaml will hold
  std::map<std::string, std::string> inputs;  ///< files that its mission was read from
  Status status = Status::kWaiting;
  pid_t process = -1;
  double started_s = 0;
  std::string outcome;              ///< of metrics.json; of a broken one how it ended
  bool cut_short = false;           ///< by what the machine lacked, or a bug
  std::vector<std::string> broken;  ///< requirements, with the values
  std::vector<std::pair<std::string, bool>> required;  ///< all of them, and whether they are met
  double wall_s = 0;
  std::vector<std::pair<std::string, double>> figures;  ///< numbers of the metrics by dotted path
};

/// Ends the runs that are under way, as Ctrl-C would, when trials end in an unusual way.
class Runs {
 public:
  explicit Runs(std::vector<Trial>& trials) : trials_(trials) {}
  ~Runs() {
    ask();
    for (Trial& trial : trials_) {
      if (has_process(trial)) {
        ::waitpid(trial.process, nullptr, 0);
      }
    }
  }
  Runs(const Runs&) = delete;
  Runs& operator=(const Runs&) = delete;

  /// Asks each of them to end.
  void ask() const {
    for (const Trial& trial : trials_) {
      if (has_process(trial)) {
        ::kill(trial.process, SIGINT);
      }
    }
  }

 private:
  // kill(-1) would reach every process of the user: a run that was collected has none.
  static bool has_process(const Trial& trial) {
    return trial.status == Status::kRunning && trial.process > 0;
  }

  std::vector<Trial>& trials_;
};

std::string fixed(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string as_folder(std::string text) {
  for (char& c : text) {
    if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < ' ') {
      c = '_';
    }
  }
  constexpr std::size_t kLongest = 200;  // a file name holds 255 bytes
  return text.substr(0, kLongest);
}

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
  trial.status =
      trial.outcome == "completed" && trial.broken.empty() ? Status::kPassed : Status::kFailed;
  return true;
}

/// The same of its folder; false when it holds none that can be read.
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
    trial.status = Status::kWaiting;
    return false;
  }
  return true;
}

/// What a run was made of, as it said: beside its folder.
std::filesystem::path inputs_file(const Trial& trial) {
  std::filesystem::path file = trial.dir;
  return file += ".sha256";
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

std::vector<Trial> plan(const TrialsOptions& options) {
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

/// Removes what an interrupted run has left. One that still writes there is not to be run into.
void make_room(const std::filesystem::path& dir) {
  std::filesystem::create_directories(dir);
  const auto lock = FolderLock::take(dir);
  if (!lock) {
    throw ConfigError(dir.string() + ": a run is still writing there; wait until it has ended");
  }
  std::filesystem::remove_all(dir);
}

void start(Trial& trial, const TrialsOptions& options) {
  make_room(trial.dir);
  std::filesystem::remove(inputs_file(trial));
  std::vector<std::string> words = {
      "panoptes", "explore",          trial.mission_file, "--quiet",
      "--out",    trial.dir.string(), "--inputs",         inputs_file(trial).string()};
  for (const std::string& setting : trial.set) {
    words.push_back("--set");
    words.push_back(setting);
  }
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) {
    arguments.push_back(word.data());
  }
  arguments.push_back(nullptr);
  std::string one_thread = "LP_NUM_THREADS=0";
  std::vector<char*> environment;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (options.jobs == 1 || std::strncmp(*variable, "LP_NUM_THREADS=", 15) != 0) {
      environment.push_back(*variable);
    }
  }
  if (options.jobs > 1) {  // the runs share the machine already
    environment.push_back(one_thread.data());
  }
  environment.push_back(nullptr);
  std::filesystem::path log = trial.dir;
  log += ".log";
  const int output = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (output < 0) {
    throw IoError(log.string() + ": cannot be created: " + std::strerror(errno));
  }
  const std::string program = options.program.string();
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process == 0) {  // from here to exec only what a forked process may call
    ::setpgid(0, 0);   // a terminal's Ctrl-C reaches us alone, and is passed on once
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) {
      ::_exit(1);
    }
    ::dup2(output, STDOUT_FILENO);
    ::dup2(output, STDERR_FILENO);
    ::execve(program.c_str(), arguments.data(), environment.data());
    ::_exit(127);
  }
  const int fault = errno;
  ::close(output);
  if (process < 0) {
    throw IoError(std::string("cannot start a run: ") + std::strerror(fault));
  }
  trial.process = process;
  trial.started_s = steady_s();
  trial.status = Status::kRunning;
}

/// Looks whether it has ended, and takes what it left.
void collect(Trial& trial) {
  int status = 0;
  const pid_t ended = ::waitpid(trial.process, &status, WNOHANG);
  if (ended != trial.process) {
    return;
  }
  trial.process = -1;
  trial.status = Status::kBroken;  // unless it has left figures
  const bool exited = WIFEXITED(status);
  const int code = exited ? WEXITSTATUS(status) : -1;
  if (!(code == 0 || code == 1) || !take_metrics(trial)) {
    trial.outcome = exited ? "exit status " + std::to_string(code)
                           : "ended by signal " + std::to_string(WTERMSIG(status));
  }
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

/// Why it is no pass, a line each.
std::vector<std::string> faults(const Trial& trial) {
  if (trial.status == Status::kBroken) {
    const std::string words = last_words(trial);
    return {trial.outcome + (words.empty() ? "" : ": " + words)};
  }
  std::vector<std::string> all = trial.broken;
  if (trial.outcome != "completed") {
    all.insert(all.begin(), "outcome is " + trial.outcome);
  }
  return all;
}

bool is_done(const Trial& trial) {
  return trial.status != Status::kWaiting && trial.status != Status::kRunning;
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
  for (const Vary& v : options.vary) {
    columns.push_back(v.key);
  }
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
    csv << (trial.status == Status::kPassed   ? "pass"
            : trial.status == Status::kFailed ? "fail"
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

std::string xml(std::string_view text) {
  std::string all;
  for (const char c : as_utf8(text)) {
    switch (c) {
      case '&':
        all += "&amp;";
        break;
      case '<':
        all += "&lt;";
        break;
      case '>':
        all += "&gt;";
        break;
      case '"':
        all += "&quot;";
        break;
      default:
        all += static_cast<unsigned char>(c) < ' ' && c != '\n' ? ' ' : c;
    }
  }
  return all;
}

void write_junit(const std::filesystem::path& path, const std::vector<Trial>& trials) {
  int failures = 0;
  int errors = 0;
  int skipped = 0;
  double all_s = 0;
  std::string cases;
  for (const Trial& trial : trials) {
    all_s += trial.wall_s;
    cases += "  <testcase classname=\"" + xml(trial.mission) + "\" name=\"" +
             xml((trial.setting.empty() ? "" : trial.setting + " ") + "seed " +
                 std::to_string(trial.seed)) +
             "\" time=\"" + fixed(trial.wall_s, 3) + "\"";
    if (trial.status == Status::kPassed) {
      cases += "/>\n";
      continue;
    }
    cases += ">\n";
    if (!is_done(trial)) {
      ++skipped;
      cases += "    <skipped message=\"interrupted\"/>\n";
    } else {
      const bool broken = trial.status == Status::kBroken;
      ++(broken ? errors : failures);
      const std::vector<std::string> lines = faults(trial);
      const char* kind = broken ? "error" : "failure";
      cases += std::string("    <") + kind + " message=\"" +
               xml(lines.empty() ? "" : lines.front()) + "\">" + xml(joined(lines, "\n")) + "</" +
               kind + ">\n";
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

/// The runs of one mission under one combination of settings.
struct Group {
  std::string mission;
  std::vector<std::string> values;
  std::string setting;
  int runs = 0;
  int passed = 0;
  std::vector<std::string> order;  ///< of the scores
  std::map<std::string, std::vector<double>> scores;
};

std::vector<Group> groups_of(const std::vector<Trial>& trials) {
  std::vector<Group> groups;
  for (const Trial& trial : trials) {
    if (!is_done(trial)) {
      continue;
    }
    if (groups.empty() || groups.back().mission != trial.mission ||
        groups.back().values != trial.values) {
      groups.push_back({trial.mission, trial.values, trial.setting, 0, 0, {}, {}});
    }
    Group& group = groups.back();
    ++group.runs;
    group.passed += trial.status == Status::kPassed ? 1 : 0;
    for (const auto& [name, value] : trial.figures) {
      auto& values = group.scores[name];
      if (values.empty()) {
        group.order.push_back(name);
      }
      values.push_back(value);
    }
  }
  return groups;
}

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

void write_metrics(const TrialsOptions& options, const std::vector<Trial>& trials,
                   const std::vector<Group>& groups, const std::string& outcome, double wall_s) {
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
  Json settings = Json::array();
  for (const Group& group : groups) {
    runs += group.runs;
    passed += group.passed;
    Json setting;
    setting["mission"] = group.mission;
    Json vary = Json::object();
    for (std::size_t i = 0; i < group.values.size(); ++i) {
      vary[options.vary[i].key] = group.values[i];
    }
    setting["vary"] = vary;
    setting["runs"] = group.runs;
    setting["passed"] = group.passed;
    Json scores = Json::object();
    for (const std::string& name : group.order) {
      const MeanInterval m = mean_interval(group.scores.at(name));
      scores[name] = {{"mean", m.mean}, {"low", m.low}, {"high", m.high}, {"count", m.count}};
    }
    setting["scores"] = scores;
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

void print_table(const std::vector<Group>& groups) {
  bool averaged = false;
  std::vector<std::vector<std::string>> lines{{"mission", "passed"}};
  std::vector<const Column*> shown;
  for (const Column& column : kColumns) {
    if (std::any_of(groups.begin(), groups.end(),
                    [&](const Group& g) { return g.scores.contains(column.figure); })) {
      shown.push_back(&column);
      lines[0].emplace_back(column.head);
    }
  }
  for (const Group& group : groups) {
    lines.push_back({group.mission + (group.setting.empty() ? "" : " " + group.setting),
                     std::to_string(group.passed) + "/" + std::to_string(group.runs)});
    for (const Column* column : shown) {
      const auto values = group.scores.find(column->figure);
      if (values == group.scores.end()) {
        lines.back().emplace_back("-");
        continue;
      }
      const MeanInterval m = mean_interval(values->second);
      std::string cell = fixed(column->scale * m.mean, column->digits);
      if (m.count > 1) {
        averaged = true;
        cell += " +- " + fixed(column->scale * (m.high - m.mean), column->digits);
      }
      lines.back().push_back(cell);
    }
  }
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
  std::printf("%spanoptes trials --help says what the columns are\n",
              averaged ? "means over the seeds +- half of their 95 % intervals; " : "");
}

/// What the runs found that compared ways to tell places apart, if any did.
void report_recognition(const TrialsOptions& options, const std::vector<Trial>& trials) {
  std::vector<std::string> columns = {"mission"};
  for (const Vary& v : options.vary) {
    columns.push_back(v.key);
  }
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
      csv.emplace(options.out_dir / "study.csv", columns);
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

/// `3 of 20 runs done, 1 failed, 4:10 left` on stderr: a line drawn again and again on a terminal,
/// one every 30 s elsewhere.
class TrialsProgress {
 public:
  explicit TrialsProgress(bool quiet)
      : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) != 0), shown_s_(steady_s()) {}
  ~TrialsProgress() {
    if (drawn_) {
      std::fprintf(stderr, "\r\033[K");
    }
  }
  TrialsProgress(const TrialsProgress&) = delete;
  TrialsProgress& operator=(const TrialsProgress&) = delete;

  void show(const std::vector<Trial>& trials, const std::vector<double>& took_s, int jobs) {
    constexpr double kOnTerminal_s = 0.5;
    constexpr double kElsewhere_s = 30;
    const double now_s = steady_s();
    if (quiet_ || now_s - shown_s_ < (terminal_ ? kOnTerminal_s : kElsewhere_s)) {
      return;
    }
    shown_s_ = now_s;
    int done = 0;
    int not_passed = 0;
    std::size_t waiting = 0;
    std::vector<double> running_s;
    for (const Trial& trial : trials) {
      done += is_done(trial) ? 1 : 0;
      not_passed += trial.status == Status::kFailed || trial.status == Status::kBroken ? 1 : 0;
      if (trial.status == Status::kWaiting) {
        ++waiting;
      } else if (trial.status == Status::kRunning) {
        running_s.push_back(now_s - trial.started_s);
      }
    }
    std::string line = std::to_string(done) + " of " + std::to_string(trials.size()) +
                       " runs done, " + std::to_string(not_passed) + " failed";
    if (const auto left_s = time_left_s(took_s, running_s, waiting, jobs)) {
      line += ", " + minutes_text(*left_s) + " left";
    } else if (!took_s.empty()) {
      line += ", what is left takes longer than any so far";
    }
    std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", line.c_str());
    std::fflush(stderr);
    drawn_ = terminal_;
  }

 private:
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  double shown_s_;
};

/// The verdicts' file can be written, or the user is told before anything runs.
void check_junit(const TrialsOptions& options) {
  std::string fault;
  std::error_code ignored;
  if (std::filesystem::is_directory(options.junit, ignored)) {
    fault = options.junit.string() + ": is a folder";
  } else if (!options.junit.empty()) {
    try {
      const AtomicFile probe(options.junit);
    } catch (const IoError& error) {
      fault = error.what();
    }
  }
  if (!fault.empty()) {
    if (std::filesystem::is_empty(options.out_dir, ignored)) {
      std::filesystem::remove(options.out_dir, ignored);
    }
    throw ConfigError("--junit " + fault + "; name another file");
  }
}

/// Nothing that other trials have left is overwritten: what is there are the same runs, or fewer.
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
  for (const Vary& v : options.vary) {
    head.push_back(v.key);
  }
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
      std::string all;
      for (std::size_t i = 0; i < words.size(); ++i) {
        all += (i == 0 ? "" : " ") + (i + 1 == words.size() ? "seed " : std::string()) + words[i];
      }
      refuse(table, "holds " + all + ", which is not among these runs; ask for it as well, or");
    }
  }
}

/// A folder of trials is known by its trials.csv.
FolderLock claim_trials_dir(const std::filesystem::path& out_dir) {
  std::error_code fault;
  std::filesystem::create_directories(out_dir, fault);
  if (fault || !std::filesystem::is_directory(out_dir)) {
    throw ConfigError(out_dir.string() + ": cannot be made; name another folder with --out");
  }
  std::optional<FolderLock> lock = FolderLock::take(out_dir);
  if (!lock) {
    throw ConfigError(out_dir.string() +
                      ": another panoptes is writing there; name another folder with --out");
  }
  if (!std::filesystem::is_empty(out_dir) && !std::filesystem::exists(out_dir / "trials.csv")) {
    throw ConfigError(out_dir.string() +
                      ": holds something else than trials; name another folder with --out");
  }
  if (::access(out_dir.c_str(), W_OK | X_OK) != 0) {
    throw ConfigError(out_dir.string() + ": cannot be written; name another folder with --out");
  }
  return std::move(*lock);
}

}  // namespace

std::string table_legend() {
  std::string text = "The table: means over the seeds +- half of their 95 % intervals, of\n";
  for (const Column& column : kColumns) {
    std::string head = column.head;
    head.resize(16, ' ');
    text += "  " + head + column.what + " (" + column.figure + ")\n";
  }
  return text;
}

std::vector<std::uint64_t> parse_seeds(std::string_view text) {
  const auto fault = [&] {
    return ConfigError("--seeds " + std::string(text) + ": must be numbers and ranges, as 1-5,101");
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
    if (last < first || last - first >= kMost) {
      throw fault();
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

namespace {

int run_planned(const TrialsOptions& options, std::vector<Trial>& trials, double from_s) {
  const Until until{UntilOptions()};
  for (Trial& trial : trials) {
    is_finished(trial);
  }
  write_csv(options, trials);
  std::filesystem::remove(options.out_dir / "metrics.json");  // until all of them are done

  bool interrupted = false;
  {
    const Runs under_way(trials);
    TrialsProgress progress(options.quiet);
    std::vector<double> took_s;
    int passed_on = 0;
    while (true) {
      int running = 0;
      for (Trial& trial : trials) {
        if (trial.status == Status::kRunning) {
          collect(trial);
          if (trial.status == Status::kRunning) {
            ++running;
          } else {
            took_s.push_back(steady_s() - trial.started_s);
            write_csv(options, trials);
          }
        }
      }
      const int asked = (until.interrupted() ? 1 : 0) + (until.hurried() ? 1 : 0);
      for (; passed_on < asked; ++passed_on) {
        interrupted = true;
        under_way.ask();
      }
      for (Trial& trial : trials) {
        if (!interrupted && running < options.jobs && trial.status == Status::kWaiting) {
          start(trial, options);
          ++running;
        }
      }
      if (running == 0) {
        break;
      }
      progress.show(trials, took_s, options.jobs);
      constexpr auto kLook = std::chrono::milliseconds(50);
      std::this_thread::sleep_for(kLook);
    }
  }
  if (interrupted) {  // what was cut short is run again next time
    for (Trial& trial : trials) {
      if (is_done(trial) && (trial.status == Status::kBroken || trial.outcome == "interrupted")) {
        trial.status = Status::kWaiting;
        trial.figures.clear();
      }
    }
  }
  write_csv(options, trials);
  const std::vector<Group> groups = groups_of(trials);
  const bool all_passed = std::all_of(trials.begin(), trials.end(), [](const Trial& trial) {
    return trial.status == Status::kPassed;
  });
  write_metrics(options, trials, groups,
                interrupted  ? "interrupted"
                : all_passed ? "completed"
                             : "failed",
                steady_s() - from_s);
  if (!options.junit.empty()) {
    write_junit(options.junit, trials);
  }
  if (!groups.empty()) {
    print_table(groups);
  }
  report_recognition(options, trials);
  for (const Trial& trial : trials) {
    if (trial.status == Status::kFailed || trial.status == Status::kBroken) {
      for (const std::string& fault : faults(trial)) {
        std::printf("%s: %s\n", trial.dir.c_str(), fault.c_str());
      }
    }
  }
  return interrupted ? 130 : all_passed ? 0 : 1;
}

/// That they did not come to their end, for whoever looks into the folder.
void tell_fault(const TrialsOptions& options, const std::string& fault) {
  const Json metrics{{"schema", "panoptes.metrics/1"},
                     {"command", "trials"},
                     {"version", options.version},
                     {"outcome", "failed"},
                     {"fault", as_utf8(fault)}};
  write_file(options.out_dir / "metrics.json", metrics.dump(2) + "\n");
}

}  // namespace

int run_trials(const TrialsOptions& options) {
  const double from_s = steady_s();
  std::vector<Trial> trials = plan(options);
  check_what_is_there(options, trials);
  const FolderLock lock = claim_trials_dir(options.out_dir);
  check_junit(options);
  Faults faults;
  int status = 0;
  faults.attempt([&] { status = run_planned(options, trials, from_s); });
  if (!faults.none()) {
    faults.attempt([&] { tell_fault(options, faults.text()); });
    return faults.status();
  }
  return status;
}

}  // namespace panoptes
