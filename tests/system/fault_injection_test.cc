// SPDX-License-Identifier: BSD-3-Clause
// Memory that runs out, bugs, signals and full disks at random instants of every phase of explore,
// record, trials and serve: the status is right, and what was done can be read.
// More of them, by others' dice:
//   PANOPTES_FAULT_TRIALS=200 PANOPTES_FAULT_SEED=7 system_test --gtest_filter='FaultInjection.*'
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/io/csv.h"
#include "core/io/dataset.h"
#include "core/io/file.h"
#include "core/io/graph_file.h"
#include "core/io/keyframe_files.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

struct Trial {
  std::string command;  ///< explore, record, trials, serve
  std::string inside;   ///< whose process it happens in: of trials, a run's or its own
  std::string kind;     ///< memory, bug, TERM, HUP, INT2, disk
  std::string after;
  long count = 0;
  long room_bytes = 0;

  std::string text() const {
    return command + " " + inside + " " + kind +
           (kind == "disk" ? " " + std::to_string(room_bytes) + " bytes"
                           : "@" + after + "+" + std::to_string(count));
  }
};

// The end of the name of a file that is made when a phase begins.
std::vector<std::string> phases(const std::string& command) {
  if (command == "serve") {
    return {"start", "metrics.json", "mission.yaml"};
  }
  if (command == "trials") {
    return {"start", "trials.csv", "metrics.json"};
  }
  return {"start",   "steps.csv",    "mission.yaml", "trajectory.tum",
          "map.pgm", "metrics.json", "map.png"};
}

int index(Rng& rng, std::size_t count) { return rng.index(static_cast<int>(count)); }

// Number i goes through commands and kinds in turn; phase and instant are drawn.
Trial drawn(int i, Rng& rng) {
  const std::array<const char*, 4> commands = {"explore", "record", "trials", "serve"};
  const std::array<const char*, 6> kinds = {"memory", "TERM", "disk", "bug", "HUP", "INT2"};
  Trial trial;
  trial.command = commands[static_cast<std::size_t>(i) % commands.size()];
  trial.kind = kinds[static_cast<std::size_t>(i / 4) % kinds.size()];
  trial.inside = trial.command == "trials" && index(rng, 2) == 0 ? "explore" : trial.command;
  const std::vector<std::string> all = phases(trial.inside);
  trial.after = all[static_cast<std::size_t>(index(rng, all.size()))];
  const double most = trial.after == "start" || trial.after == "mission.yaml" ? 5.5 : 3.5;
  trial.count = std::lround(std::pow(10.0, rng.uniform(0, most)));
  trial.room_bytes = std::lround(std::pow(10.0, rng.uniform(2.5, 6.3)));
  return trial;
}

class FaultInjection : public SystemTest {
 protected:
  Said run(const Trial& trial) const {
    std::vector<std::string> words{trial.command, kOffice, "--quiet", "--out", "run"};
    const std::vector<std::string> more =
        trial.command == "trials"
            ? std::vector<std::string>{"--seeds", "1", "--duration", "0.5", "--set", "require=[]"}
        : trial.command == "serve"
            ? std::vector<std::string>{"--port", "0", "--duration", "0.5"}
            : std::vector<std::string>{"--duration", "0.7", "--set", "require=[]"};
    words.insert(words.end(), more.begin(), more.end());
    Fate fate;
    fate.program = PANOPTES_FAULTY_PROGRAM;
    fate.environment["PANOPTES_FAULT_IN"] = trial.inside;
    fate.environment["PANOPTES_FAULT_MARK"] = (folder_ / "mark").string();
    if (trial.kind == "disk") {
      fate.environment["PANOPTES_DISK_BYTES"] = std::to_string(trial.room_bytes);
    } else {
      fate.environment["PANOPTES_FAULT"] =
          trial.kind + "@" + trial.after + "+" + std::to_string(trial.count);
    }
    return panoptes(words, fate);
  }

  // Every file under its name is whole, and there is none under another.
  void expect_readable(const fs::path& folder, const std::string& told) const {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      EXPECT_FALSE(name.ends_with(".part")) << entry.path();
      if (!entry.is_regular_file()) {
        continue;
      }
      try {
        if (name == "metrics.json") {
          EXPECT_TRUE(nlohmann::json::parse(read_file(entry.path())).contains("outcome"));
        } else if (name == "steps.csv" || name == "loops.csv" || name == "exploration.csv" ||
                   name == "trials.csv") {
          read_csv(entry.path());
        } else if (name.ends_with(".tum")) {
          read_tum(entry.path());
        } else if (name == "graph.g2o" && fs::file_size(entry.path()) > 0) {
          read_graph(entry.path());
        } else if (name == "map.yaml" && fs::exists(folder / "map.pgm")) {
          read_map_server(entry.path());
        }
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
      }
    }
    const bool recorded = fs::exists(folder / "mav0") && fs::exists(folder / "metrics.json") &&
                          metrics("run").value("frames", 0) > 0;
    if (recorded && told.find("nothing is recorded") == std::string::npos) {
      try {
        read_dataset(folder);
      } catch (const std::exception& error) {
        ADD_FAILURE() << error.what();
      }
    }
  }

  void judge(const Trial& trial) {
    SCOPED_TRACE(trial.text());
    fs::remove_all(folder_ / "work" / "run");
    fs::remove(folder_ / "mark");
    const Said said = run(trial);
    SCOPED_TRACE("status " + std::to_string(said.status) + ": " + said.err);
    const fs::path folder = folder_ / "work" / "run";
    const bool happened = fs::exists(folder_ / "mark");
    const bool signalled = trial.kind == "TERM" || trial.kind == "HUP" || trial.kind == "INT2";
    const bool inner = trial.inside != trial.command;  // the run broke, trials have failed
    const bool there = fs::exists(folder / "metrics.json");
    const bool begun = fs::exists(folder) && !fs::is_empty(folder);
    if (!happened) {
      EXPECT_EQ(said.status, 0);
    } else if (inner) {
      EXPECT_THAT(said.status, testing::AnyOf(0, 1));
    } else if (signalled) {
      // Before there is anything to keep, or when all is kept, a signal ends it as any other
      // program; one that comes when the drive is over finds a run that has come to its end.
      const bool over = said.status == 0 && there && metrics("run")["outcome"] == "completed";
      EXPECT_TRUE(said.status == 130 || (said.status == -1 && there == begun) || over)
          << "begun: " << begun;
    } else {
      EXPECT_EQ(said.status, trial.kind == "bug" ? 4 : 3);
      EXPECT_NE(said.err, "");
    }
    if (fs::exists(folder)) {
      expect_readable(folder, said.err);
    }
    if (begun && trial.kind != "disk") {
      EXPECT_TRUE(there) << "no metrics.json";
    }
    if (there && happened && !inner && trial.command != "trials") {
      const std::string outcome = metrics("run").value("outcome", "");
      if (signalled) {
        EXPECT_THAT(outcome, testing::AnyOf("interrupted", "completed"));
      } else if (said.err.find("metrics.json: cannot") == std::string::npos) {
        EXPECT_THAT(outcome, testing::AnyOf("failed", "interrupted"));
        EXPECT_TRUE(metrics("run").contains("fault"));
      }
    }
    happened_ += happened ? 1 : 0;
  }

  int happened_ = 0;
};

int number_from(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atoi(text);
}

TEST_F(FaultInjection, AtRandomInstantsOfEveryPhase) {
  const int trials = number_from("PANOPTES_FAULT_TRIALS", 20);
  const auto seed = static_cast<std::uint64_t>(number_from("PANOPTES_FAULT_SEED", 1));
  for (int i = 0; i < trials; ++i) {
    Rng rng = Rng(seed).fork(std::to_string(i));
    judge(drawn(i, rng));
  }
  std::printf("%d of %d faults happened before the program was done\n", happened_, trials);
  EXPECT_GT(2 * happened_, trials);
}

}  // namespace
}  // namespace panoptes
