// SPDX-License-Identifier: BSD-3-Clause
// What it costs to plan and to merge many runs: trials_study FOLDER [RUNS [FIGURES]]
// (100000 and 200). Runs are not made: each has the files that `--keep metrics` leaves of one, with
// so many figures. Says the CPU time of planning and of merging, and the peak of the memory. FOLDER
// must not be there.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <sys/resource.h>

#include "apps/batch/manifest.h"
#include "apps/trials/run_trials.h"
#include "core/config/sha256.h"
#include "core/io/file.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

double cpu_s() {
  rusage use{};
  ::getrusage(RUSAGE_SELF, &use);
  return static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
}

double peak_memory_mb() {
  rusage use{};
  ::getrusage(RUSAGE_SELF, &use);
  return static_cast<double>(use.ru_maxrss) / 1024;
}

std::string settings(const std::string& setting, const std::string& seed) {
  return "name: stub\nset: " + setting + "\nseed: " + seed + "\n";
}

void leave_run(const fs::path& folder, const Trial& trial, const std::string& inputs, int figures) {
  const std::string seed = std::to_string(trial.seed);
  fs::create_directories(folder);
  std::string json =
      R"({"schema": "panoptes.metrics/1", "outcome": "completed", "run_s": 60, "wall_s": 1)";
  for (int k = 0; k < figures; ++k) {
    json += fmt::format(R"(, "figure_{}": {{"mean": {}}})", k,
                        static_cast<double>((trial.seed * 7919 + static_cast<unsigned>(k)) % 1000));
  }
  const auto leave = [&](const char* name, const std::string& text) {
    std::FILE* file =
        std::fopen((folder / name).c_str(), "w");  // brought to no disk: they are many
    std::fwrite(text.data(), 1, text.size(), file);
    std::fclose(file);
  };
  leave("metrics.json", json + "}\n");
  leave("mission.yaml", settings(trial.point->set.front(), seed));
  leave("inputs.sha256", inputs);
}

int study(const fs::path& folder, int runs, int figures) {
  constexpr int kPoints = 100;
  TrialsOptions options;
  options.missions = {"stub.yaml"};
  options.out_dir = folder;
  options.quiet = true;
  options.version = "0";
  Vary vary{"a", {}};
  for (int k = 0; k < kPoints; ++k) {
    vary.values.push_back(std::to_string(k));
  }
  options.vary = {vary};
  for (int seed = 1; seed <= runs / kPoints; ++seed) {
    options.seeds.push_back(static_cast<std::uint64_t>(seed));
  }
  options.resolve = [](const std::string&, const std::string&,
                       const std::vector<std::string>& set) {
    return ResolvedMission{"stub", settings(set.front(), set.back().substr(5)), {}, 60};
  };
  const std::string program = sha256(read_file(options.program));
  fs::create_directories(folder);

  double from_s = cpu_s();
  {
    const std::vector<Trial> trials = plan_trials(options);
    write_manifest(options, program, trials);
    std::printf("%zu runs planned: %.1f CPU s, peak %.0f MB\n", trials.size(), cpu_s() - from_s,
                peak_memory_mb());
    const std::string inputs = program + "  /proc/self/exe\n";
    for (const Trial& trial : trials) {
      leave_run(folder_of(trial, folder), trial, inputs, figures);
    }
  }
  from_s = cpu_s();
  TrialsOptions merged;
  merged.out_dir = folder;
  merged.version = options.version;
  const int status = merge_trials(merged);
  std::printf("merged: %.1f CPU s, peak %.0f MB\n", cpu_s() - from_s, peak_memory_mb());
  return status;
}

}  // namespace
}  // namespace panoptes

int main(int argc, char** argv) {
  if (argc < 2 || std::filesystem::exists(argv[1])) {
    std::fprintf(stderr, "trials_study FOLDER [RUNS [FIGURES]]; FOLDER must not be there\n");
    return 2;
  }
  return panoptes::study(argv[1], argc > 2 ? std::atoi(argv[2]) : 100'000,
                         argc > 3 ? std::atoi(argv[3]) : 200);
}
