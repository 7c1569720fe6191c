// SPDX-License-Identifier: BSD-3-Clause
#include "apps/batch/slurm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int kMostTasks = 1000;
constexpr double kLeastTask_s = 60;
// Of wall time a second of a mission, on one core: at the fast end of what was measured, so that no
// task is too short.
constexpr double kWallShare = 0.3;

// As one word of a shell.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) {
    text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return text + "'";
}

struct Said {
  int status = 0;
  std::string text;  // on both streams
};

Said run(const std::string& command) {
  std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "re");
  if (pipe == nullptr) {
    throw DeviceError(command + ": cannot be started");
  }
  Said said;
  std::array<char, 4096> bytes{};
  while (const std::size_t count = std::fread(bytes.data(), 1, bytes.size(), pipe)) {
    said.text.append(bytes.data(), count);
  }
  const int status = ::pclose(pipe);
  said.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  while (!said.text.empty() && said.text.back() == '\n') {
    said.text.pop_back();
  }
  return said;
}

// The number of the job.
std::string submit(const SlurmOptions& slurm, const fs::path& script, const std::string& depends) {
  const Said said =
      run("sbatch --parsable " + slurm.words + " " + depends + " " + quoted(script.string()));
  constexpr int kNoSuchCommand = 127;
  if (said.status == kNoSuchCommand) {
    throw DeviceError(
        "sbatch is not on this machine; submit from one with Slurm's commands, or make the runs "
        "here with --jobs N");
  }
  // what it warns of comes first, the number last
  const std::string last = said.text.substr(said.text.rfind('\n') + 1);
  const std::string number = last.substr(0, last.find(';'));
  if (said.status != 0 || number.empty() ||
      number.find_first_not_of("0123456789") != std::string::npos) {
    throw DeviceError(
        "sbatch has refused " + script.string() + ": " + said.text +
        "; nothing is lost: mend it (--sbatch gives words to sbatch) and submit again "
        "with --engine slurm --resume");
  }
  return number;
}

class Submission {
 public:
  Submission(const TrialsOptions& options, const SlurmOptions& slurm)
      : options_(options),
        slurm_(slurm),
        program_(fs::exists(options.program) ? fs::canonical(options.program) : options.program),
        out_dir_(fs::absolute(options.out_dir)),
        folder_(out_dir_ / "slurm") {
    fs::create_directories(folder_);
    if (fs::exists(folder_ / "jobs.json")) {
      try {
        jobs_ = Json::parse(read_file(folder_ / "jobs.json"));
        shards_ = jobs_.at("shards").get<int>();
        if (jobs_.contains("chunk")) {
          chunk_ = jobs_["chunk"].get<int>();
        }
      } catch (const Json::exception& error) {
        throw ConfigError((folder_ / "jobs.json").string() + ": is damaged (" + error.what() +
                          "); remove " + folder_.string() + " and submit again");
      }
    }
  }

  bool was_before() const { return shards_ > 0; }
  int shards() const { return shards_; }

  /// As many as the runs need; `chunk` as it was asked for before, where it is not now.
  void choose_shards(const std::vector<Trial>& trials) {
    if (slurm_.chunk) {
      chunk_ = slurm_.chunk;
    }
    shards_ = tasks_for(trials, chunk_);
  }
  const fs::path& folder() const { return folder_; }

  // No two arrays make the same runs.
  void check_queue() const {
    if (!jobs_.contains("jobs") || jobs_["jobs"].empty()) {
      return;
    }
    std::vector<std::string> numbers;
    for (const Json& job : jobs_["jobs"]) {
      numbers.push_back(job.get<std::string>());
    }
    const Said said = run("squeue --noheader --format=%i --jobs=" + joined(numbers, ","));
    if (said.status == 0 && !said.text.empty()) {
      throw ConfigError(options_.out_dir.string() + ": job " +
                        said.text.substr(0, said.text.find('\n')) +
                        " of these trials is still in the queue; wait for it, or scancel it");
    }
  }

  std::string submit_light(const std::vector<Trial>& trials) {
    std::string lines;
    std::set<std::pair<std::map<std::string, std::string>, std::vector<std::string>>> known;
    for (const Trial& trial : trials) {
      std::vector<std::string> of_world;
      for (const std::string& word : trial.point->set) {
        if (word.find("world") != std::string::npos) {
          of_world.push_back(word);
        }
      }
      if (!known.insert({trial.point->inputs, of_world}).second) {
        continue;
      }
      const fs::path pictures = folder_ / fmt::format("light-{}", known.size());
      // wherever it is drawn from, all of a world's light is worked out
      lines += fmt::format("{} render {} --pose=0,0,0 --quiet --out {}", quoted(program_.string()),
                           quoted(trial.point->mission_file), quoted(pictures.string()));
      for (const std::string& word : set_of(trial)) {
        lines += " --set " + quoted(word);
      }
      lines += fmt::format(" && echo light of {} || failed=1\nrm -rf {}\n",
                           quoted(trial.point->mission_file), quoted(pictures.string()));
    }
    return remember(submit(slurm_, script("light", "", lines + "exit ${failed:-0}\n"), ""));
  }

  std::string submit_array(const std::vector<std::uint64_t>& tasks, const std::string& after) {
    const std::string heads = fmt::format(
        "#SBATCH --array={}\n#SBATCH --cpus-per-task={}\n#SBATCH --requeue\n"
        "#SBATCH --signal=B:TERM@60\n",
        numbers_text(tasks), options_.jobs);
    const std::string line = fmt::format(
        "exec {} trials --shard \"$SLURM_ARRAY_TASK_ID/{}\" --out {} --jobs {}{} --quiet\n",
        quoted(program_.string()), shards_, quoted(out_dir_.string()), options_.jobs,
        options_.threads ? " --threads " + std::to_string(*options_.threads) : "");
    return remember(submit(slurm_, script("shard", heads, line),
                           after.empty() ? "" : "--dependency=afterany:" + after));
  }

  fs::path merge_script() const {
    return script("merge", "",
                  fmt::format("exec {} trials --merge --out {}{}\n", quoted(program_.string()),
                              quoted(out_dir_.string()),
                              options_.junit.empty()
                                  ? ""
                                  : " --junit " + quoted(fs::absolute(options_.junit).string())));
  }

  std::string remember(const std::string& job) {
    jobs_["shards"] = shards_;
    if (chunk_) {
      jobs_["chunk"] = *chunk_;
    }
    jobs_["jobs"].push_back(job);
    write_file(folder_ / "jobs.json", jobs_.dump(2) + "\n");
    return job;
  }

 private:
  fs::path script(const std::string& name, const std::string& heads,
                  const std::string& lines) const {
    fs::path file = folder_ / (name + ".sh");
    const std::string log = name == "shard" ? "shard-%a.log" : name + ".log";
    write_file(file, fmt::format("#!/bin/bash\n#SBATCH --job-name=panoptes-{}\n"
                                 "#SBATCH --output={}\n#SBATCH --open-mode=append\n"
                                 "#SBATCH --chdir={}\n{}{}",
                                 name, (folder_ / log).string(), fs::current_path().string(), heads,
                                 lines));
    return file;
  }

  const TrialsOptions& options_;
  const SlurmOptions& slurm_;
  fs::path program_;
  fs::path out_dir_;
  fs::path folder_;
  int shards_ = 0;
  std::optional<int> chunk_;  // runs a task
  Json jobs_ = Json::object();
};

std::size_t count_due(const std::vector<Trial>& trials) {
  return static_cast<std::size_t>(std::count_if(
      trials.begin(), trials.end(), [](const Trial& trial) { return !trial.left_out; }));
}

// The shards that have a run which waits.
std::vector<std::uint64_t> shards_left(const std::vector<Trial>& trials, int shards) {
  std::vector<bool> left(static_cast<std::size_t>(shards), false);
  std::size_t i = 0;
  for (const Trial& trial : trials) {
    if (trial.left_out) {
      continue;
    }
    const std::size_t shard = i++ % left.size();
    left[shard] = left[shard] || !is_done(trial);
  }
  std::vector<std::uint64_t> numbers;
  for (std::size_t shard = 0; shard < left.size(); ++shard) {
    if (left[shard]) {
      numbers.push_back(shard + 1);
    }
  }
  return numbers;
}

}  // namespace

int tasks_for(const std::vector<Trial>& trials, const std::optional<int>& chunk) {
  double all_s = 0;
  int runs = 0;
  for (const Trial& trial : trials) {
    if (!trial.left_out) {
      all_s += kWallShare * std::max(1.0, trial.point->duration_s);
      ++runs;
    }
  }
  const int by_chunk = chunk ? (runs + *chunk - 1) / *chunk
                             : static_cast<int>(std::min<double>(runs, all_s / kLeastTask_s));
  return std::clamp(by_chunk, 1, kMostTasks);
}

int submit_to_slurm(const TrialsOptions& options, const SlurmOptions& slurm,
                    const std::vector<Trial>& trials) {
  Submission submission(options, slurm);
  if (submission.was_before() && !slurm.resume) {
    throw ConfigError(options.out_dir.string() +
                      ": was submitted before; add --resume to submit what is missing, or name "
                      "another folder with --out");
  }
  submission.check_queue();
  const bool is_first = !submission.was_before();
  submission.choose_shards(trials);  // a round of a race has runs of its own
  std::string after;
  if (is_first) {
    after = submission.submit_light(trials);
  }
  const std::vector<std::uint64_t> tasks = shards_left(trials, submission.shards());
  if (!tasks.empty()) {
    after = submission.submit_array(tasks, after);
  }
  const std::string depends = after.empty() ? "" : "--dependency=afterany:" + after;
  if (tasks.empty()) {
    std::printf("no run is missing; their tables are submitted alone; %s\n",
                submission.folder().c_str());
  } else {
    std::printf("%zu runs in %zu tasks, job %s; %s\n", count_due(trials), tasks.size(),
                after.c_str(), submission.folder().c_str());
  }
  std::fflush(stdout);
  const fs::path script = submission.merge_script();
  if (!slurm.wait) {
    const std::string merge = submission.remember(submit(slurm, script, depends));
    std::printf("job %s merges them; panoptes trials --merge --out %s shows how far they are\n",
                merge.c_str(), options.out_dir.c_str());
    return 0;
  }
  const fs::path log = submission.folder() / "merge.log";
  fs::remove(log);
  const Said said =
      run("sbatch --wait " + slurm.words + " " + depends + " " + quoted(script.string()));
  std::printf("%s\n", fs::exists(log) ? read_file(log).c_str() : said.text.c_str());
  return said.status;
}

}  // namespace panoptes
