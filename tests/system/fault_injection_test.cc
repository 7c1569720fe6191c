// SPDX-License-Identifier: BSD-3-Clause
// Memory that runs out, bugs, signals and full disks at random instants of every phase of explore,
// record, trials and serve: the status is right, and what was done can be read. A robot that is
// driven over a real wire, with a watchdog of its own that would let it go on for a minute, stands
// at once, and stays so.
// More of them, by others' dice:
//   PANOPTES_FAULT_TRIALS=200 PANOPTES_FAULT_SEED=7 system_test --gtest_filter='FaultInjection.*'
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <sys/stat.h>

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
#include "tests/system/terminal.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct Trial {
  std::string command;  ///< explore, record, trials, serve, teleop
  std::string wire;     ///< pty or tcp: to a robot at its end, which somebody drives
  std::string inside;   ///< whose process it happens in: of trials, a run's or its own
  std::string kind;     ///< memory, bug, TERM, HUP, INT2, disk; on a wire end, INT3 as well
  std::string after;
  long count = 0;
  long room_bytes = 0;

  std::string text() const {
    return command + " " + (wire.empty() ? "" : "over " + wire + " ") + inside + " " + kind +
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

Trial drawn_on_wire(int i, Rng& rng) {
  const std::array<const char*, 8> kinds = {"memory", "TERM", "end",  "bug",
                                            "INT3",   "disk", "INT2", "HUP"};
  Trial trial;
  trial.command = trial.inside = index(rng, 2) == 0 ? "teleop" : "record";
  trial.wire = index(rng, 2) == 0 ? "pty" : "tcp";
  trial.kind = kinds[static_cast<std::size_t>(i) % kinds.size()];
  // The loop makes some 10^3 allocations a second; it moves from the first of them on.
  trial.after = index(rng, 8) == 0 ? "start" : "steps.csv";
  trial.count = std::lround(std::pow(10.0, rng.uniform(2, 3.5)));
  trial.room_bytes = std::lround(std::pow(10.0, rng.uniform(2.5, 4.3)));
  return trial;
}

// Number i goes through commands and kinds in turn, every third on a wire; phase and instant are
// drawn.
Trial drawn(int i, Rng& rng) {
  if (i % 3 == 2) {
    return drawn_on_wire(i / 3, rng);
  }
  const int k = i - i / 3;
  const std::array<const char*, 4> commands = {"explore", "record", "trials", "serve"};
  const std::array<const char*, 6> kinds = {"memory", "TERM", "disk", "bug", "HUP", "INT2"};
  Trial trial;
  trial.command = commands[static_cast<std::size_t>(k) % commands.size()];
  trial.kind = kinds[static_cast<std::size_t>(k / 4) % kinds.size()];
  trial.inside = trial.command == "trials" && index(rng, 2) == 0 ? "explore" : trial.command;
  const std::vector<std::string> all = phases(trial.inside);
  trial.after = all[static_cast<std::size_t>(index(rng, all.size()))];
  const double most = trial.after == "start" || trial.after == "mission.yaml" ? 5.5 : 3.5;
  trial.count = std::lround(std::pow(10.0, rng.uniform(0, most)));
  trial.room_bytes = std::lround(std::pow(10.0, rng.uniform(2.5, 6.3)));
  return trial;
}

using WallTime = std::chrono::system_clock::time_point;

// A command is good for 0.4 s, and is looked after at every report, each 0.1 s: by then the robot
// is told to stop, whatever keeps whoever drives from telling it. From 0.3 m/s it brakes at
// 0.6 m/s2. The truth tells of a velocity one of its periods of 1/15 s later.
constexpr auto kToldWithin = 500ms;
constexpr auto kBrakesWithin = 500ms;
constexpr auto kTruthCycle = 67ms;
constexpr auto kStaysFor = 300ms;
constexpr double kRest_mps = 1e-3;  // its way is written in micrometres

class FaultInjection : public SystemTest {
 protected:
  void TearDown() override {
    if (served_.valid()) {
      write("enough", "");
      EXPECT_EQ(served_.get().status, 130);
    }
    SystemTest::TearDown();
  }

  Said run_on_wire(const Trial& trial, const Fate& given) {
    if (!served_.valid()) {
      serve();
    }
    Fate fate = given;
    std::atomic<bool> ended = false;
    Terminal terminal([&ended](Terminal& t) {  // in a circle, and the keys are held to the end
      while (!ended) {
        t.hold("wa", 50ms);
      }
    });
    fate.terminal = terminal.slave();
    const std::string base = trial.wire == "pty" ? "serial:" + path("pioneer") : tcp_;
    const std::string mission =
        write("wired.yaml", "platform: {kind: pioneer, base: \"" + base +
                                "\"}\n"
                                "robot: " +
                                kScenes + "robots/pioneer3dx.yaml\ndrive: teleop\n");
    Said said = panoptes({trial.command, mission, "--duration", "2.5", "--out", "run"}, fate);
    ended = true;
    said.err = terminal.shown();
    return said;
  }

  // One robot for all trials.
  void serve() {
    const std::string mission =
        write("hall.yaml",
              "platform:\n"
              "  kind: pioneer\n"
              "  base: standin:pty\n"
              "  controller: {watchdog_ms: 60000}\n"
              "  standin:\n"
              "    rig: {cameras: {}}\n"
              "    robot: " +
                  kScenes +
                  "robots/pioneer3dx.yaml\n"
                  "    platform:\n"
                  "      kind: simulated\n"
                  "      world: {name: hall, generate: {office: {size_m: [12, 12], desks: 0}}}\n"
                  "      start: {x_m: 6, y_m: 6, theta_deg: 0}\n"
                  "drive: none\n");
    Fate fate;
    fate.signal = SIGTERM;
    fate.signal_when = "enough";
    fate.out = path("served");
    served_ = std::async(std::launch::async, [this, mission, fate] {
      return panoptes(
          {"serve", mission, "--link", path("pioneer"), "--port", "0", "--quiet", "--out", "hall"},
          fate);
    });
    std::string told;
    while (told.find('\n') == std::string::npos &&
           served_.wait_for(20ms) == std::future_status::timeout) {
      told = fs::exists(fate.out) ? read_file(fate.out) : "";
    }
    tcp_ = told.substr(told.find("tcp:"), told.find('\n') - told.find("tcp:"));
  }

  // What the served robot truly did.
  std::vector<TumPose> trajectory_of_served() const {
    std::string text = read_file(folder_ / "work" / "hall" / "ground_truth.tum");
    text.resize(text.rfind('\n') + 1);  // it is being written
    return parse_tum("ground_truth.tum", text);
  }

  // From the fault on, when its mark was made.
  void expect_at_rest() {
    struct stat mark {};
    ASSERT_EQ(::stat(path("mark").c_str(), &mark), 0);
    const WallTime happened(std::chrono::seconds(mark.st_mtim.tv_sec) +
                            std::chrono::nanoseconds(mark.st_mtim.tv_nsec));
    const auto rests = kToldWithin + kBrakesWithin + kTruthCycle;
    constexpr auto kWritten = 200ms;  // the truth, after it happened
    std::this_thread::sleep_until(happened + rests + kStaysFor + kWritten);
    const std::chrono::nanoseconds start(metrics("hall")["start_unix_ns"].get<std::int64_t>());
    double before_mps = 0;
    Duration rolled{};
    const std::vector<TumPose> trajectory = trajectory_of_served();
    for (std::size_t i = 1; i < trajectory.size(); ++i) {
      const Duration after =
          trajectory[i].stamp.time_since_epoch() + start - happened.time_since_epoch();
      const double mps =
          (floor_pose(trajectory[i]).position() - floor_pose(trajectory[i - 1]).position()).norm() /
          to_seconds(trajectory[i].stamp - trajectory[i - 1].stamp);
      if (after <= Duration::zero()) {
        before_mps = mps;
      } else if (mps > kRest_mps) {
        rolled = after;
      }
    }
    ASSERT_GE(trajectory.back().stamp.time_since_epoch() + start,
              (happened + rests + kStaysFor).time_since_epoch());
    EXPECT_LE(to_seconds(rolled), to_seconds(rests)) << "it went " << before_mps << " m/s";
    moved_ += before_mps > kRest_mps ? 1 : 0;
    longest_s_ = std::max(longest_s_, to_seconds(rolled));
  }

  Said run(const Trial& trial) {
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
    if (!trial.wire.empty()) {
      return run_on_wire(trial, fate);
    }
    std::vector<std::string> words{trial.command, kOffice, "--quiet", "--out", "run"};
    const std::vector<std::string> more =
        trial.command == "trials"
            ? std::vector<std::string>{"--seeds", "1", "--duration", "0.5", "--set", "require=[]"}
        : trial.command == "serve"
            ? std::vector<std::string>{"--port", "0", "--duration", "0.5"}
            : std::vector<std::string>{"--duration", "0.7", "--set", "require=[]"};
    words.insert(words.end(), more.begin(), more.end());
    return panoptes(words, fate);
  }

  // Every file under its name is whole, and there is none under another.
  void expect_readable(const fs::path& folder, const Trial& trial, const std::string& told) const {
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
    const bool pictures = trial.wire.empty();  // nothing sees on a wire
    if (recorded && pictures && told.find("nothing is recorded") == std::string::npos) {
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
    // Nothing is done in order any more, but that the robot is told to stop.
    const bool at_once = trial.kind == "end" || trial.kind == "INT3";
    if (happened && !trial.wire.empty()) {
      expect_at_rest();
      ++wired_;
    }
    happened_ += happened ? 1 : 0;
    if (happened && at_once) {
      EXPECT_EQ(said.status, trial.kind == "end" ? 4 : -1);
      return;
    }
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
      expect_readable(folder, trial, said.err);
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
  }

  std::future<Said> served_;
  std::string tcp_;
  int happened_ = 0;
  int wired_ = 0;  // of these, on a wire,
  int moved_ = 0;  // with a robot that moved
  double longest_s_ = 0;
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
  std::printf("%d of %d on a wire happened while the robot moved, which stood %.2f s later\n",
              moved_, wired_, longest_s_);
  EXPECT_GT(2 * happened_, trials);
  EXPECT_GT(2 * moved_, wired_);
}

}  // namespace
}  // namespace panoptes
