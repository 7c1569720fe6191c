// SPDX-License-Identifier: BSD-3-Clause
// Driving by hand, over a terminal of the test's own.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "core/io/csv.h"
#include "core/io/file.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

/// A terminal with somebody before it, who starts once the program has said what its keys do.
class Terminal {
 public:
  explicit Terminal(std::function<void(Terminal&)> somebody)
      : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    EXPECT_EQ(::grantpt(master_), 0);
    EXPECT_EQ(::unlockpt(master_), 0);
    slave_ = ::open(::ptsname(master_), O_RDWR | O_NOCTTY | O_CLOEXEC);
    before_ = modes();
    reader_ = std::jthread([this](const std::stop_token& stop) { read(stop); });
    somebody_ = std::jthread([this, somebody = std::move(somebody)](const std::stop_token& stop) {
      while (!stop.stop_requested() && shown().find("end; Ctrl-C") == std::string::npos) {
        std::this_thread::sleep_for(5ms);
      }
      somebody(*this);
    });
  }
  ~Terminal() {
    somebody_ = {};
    reader_ = {};
    hang_up();
    ::close(slave_);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  int slave() const { return slave_; }

  void type(const std::string& keys) const {
    EXPECT_EQ(::write(master_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  /// As terminals do it: again and again.
  void hold(const std::string& key, std::chrono::milliseconds time) const {
    for (auto held = 0ms; held < time; held += 50ms) {
      type(key);
      std::this_thread::sleep_for(50ms);
    }
  }
  /// The window is closed.
  void hang_up() {
    reader_ = {};
    ::close(master_);
    master_ = -1;
  }

  std::string shown() {
    const std::lock_guard lock(mutex_);
    return shown_;
  }
  bool as_before() const {
    const termios now = modes();
    return now.c_lflag == before_.c_lflag && now.c_iflag == before_.c_iflag &&
           now.c_cc[VSUSP] == before_.c_cc[VSUSP] && now.c_cc[VQUIT] == before_.c_cc[VQUIT];
  }
  bool echoes() const { return (modes().c_lflag & ECHO) != 0; }

 private:
  termios modes() const {
    termios modes{};
    EXPECT_EQ(::tcgetattr(slave_, &modes), 0);
    return modes;
  }
  void read(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      pollfd asked{master_, POLLIN, 0};
      char bytes[256];
      if (::poll(&asked, 1, 20) == 1) {
        const ssize_t count = ::read(master_, bytes, sizeof bytes);
        const std::lock_guard lock(mutex_);
        shown_.append(bytes, count > 0 ? static_cast<std::size_t>(count) : 0);
      }
    }
  }

  std::atomic<int> master_;
  int slave_ = -1;
  termios before_{};
  std::mutex mutex_;
  std::string shown_;
  std::jthread reader_;
  std::jthread somebody_;
};

class TeleopRun : public SystemTest {
 protected:
  // Looks down an aisle that is free for 2.5 m.
  Said drive(const std::string& command, const std::vector<std::string>& more, Terminal& terminal,
             Fate fate = {}) const {
    std::vector<std::string> words{
        command,      kOffice, "--out",
        "t",          "--set", "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}",
        "--duration", "20"};
    words.insert(words.end(), more.begin(), more.end());
    fate.terminal = terminal.slave();
    return panoptes(words, fate);
  }
};

TEST_F(TeleopRun, KeysDriveAndNothingMovesWithoutThem) {
  bool echoed = true;
  Terminal terminal([&](Terminal& t) {
    echoed = t.echoes();
    t.hold("w", 1500ms);
    std::this_thread::sleep_for(1500ms);
    t.hold("\x1b[D", 600ms);
    t.type("q");
  });
  const Said said = drive("teleop", {}, terminal);
  EXPECT_EQ(said.status, 0) << said.out << terminal.shown();
  EXPECT_FALSE(echoed);
  EXPECT_TRUE(terminal.as_before());
  EXPECT_THAT(terminal.shown(), HasSubstr("deg/s (keys 0.30, 43), at "));
  EXPECT_THAT(terminal.shown(), testing::Not(HasSubstr("www")));

  const nlohmann::json figures = metrics("t");
  EXPECT_EQ(figures["command"], "teleop");
  EXPECT_EQ(figures["outcome"], "completed");
  EXPECT_EQ(figures["collisions"], 0);
  EXPECT_GT(figures["keyframes"], 0);  // the navigator maps along
  EXPECT_TRUE(fs::exists(folder_ / "work/t/map.pgm"));
  // one and a half seconds of the wall and half a second more, at 0.3 m/s; a busy computer's
  // simulated seconds are fewer, but never more
  EXPECT_GT(figures["distance_m"], 0);
  EXPECT_LT(figures["distance_m"], 0.75);
  EXPECT_LE(figures["real_time_factor"], 1.05);

  const CsvTable steps = read_csv(folder_ / "work/t/steps.csv");
  const std::size_t v = steps.column("command_v_mps");
  const std::size_t w = steps.column("command_w_radps");
  bool drove = false;
  bool stood = false;
  bool turned = false;
  for (const auto& row : steps.rows) {
    EXPECT_EQ(row[steps.column("why")], "by hand");
    drove = drove || std::stod(row[v]) > 0;
    stood = stood || (drove && std::stod(row[v]) == 0);
    turned = turned || (stood && std::stod(row[w]) > 0);
  }
  EXPECT_TRUE(drove && stood && turned);
}

TEST_F(TeleopRun, CtrlCEndsItAndGivesTheTerminalBack) {
  Terminal terminal([](Terminal& t) {
    t.hold("w", 500ms);
    t.type("\x03");
  });
  const Said said = drive("explore", {"--set", "drive=teleop"}, terminal);
  EXPECT_EQ(said.status, 130) << said.out << terminal.shown();
  EXPECT_TRUE(terminal.as_before());
  EXPECT_EQ(metrics("t")["outcome"], "interrupted");
  EXPECT_EQ(metrics("t")["command"], "explore");
}

TEST_F(TeleopRun, ItGivesTheTerminalBackWhereItDies) {
  Terminal terminal([](Terminal&) {});
  Fate fate;
  fate.signal = SIGABRT;
  fate.signal_when = "t/mission.yaml";
  EXPECT_EQ(drive("teleop", {}, terminal, fate).status, -1);
  EXPECT_TRUE(terminal.as_before());
}

TEST_F(TeleopRun, AClosedWindowEndsIt) {
  Terminal terminal([](Terminal& t) {
    t.hold("w", 500ms);
    t.hang_up();
  });
  const Said said = drive("teleop", {}, terminal);
  EXPECT_EQ(said.status, 0) << said.out;
  EXPECT_EQ(metrics("t")["outcome"], "completed");
  EXPECT_LT(metrics("t")["run_s"], 10);
}

TEST_F(TeleopRun, ARobotWithoutCamerasIsDrivenToo) {
  Terminal terminal([](Terminal& t) {
    t.hold("w", 1000ms);
    t.type("q");
  });
  const Said said = drive("teleop", {"--set", "rig={cameras: {}}"}, terminal);
  EXPECT_EQ(said.status, 0) << said.out << terminal.shown();
  EXPECT_GT(metrics("t")["distance_m"], 0);
  EXPECT_EQ(metrics("t")["keyframes"], 0);
}

TEST_F(TeleopRun, ARecordedDriveComesOutAgainBitForBit) {
  Terminal terminal([](Terminal& t) {
    t.hold("w", 1000ms);
    t.hold("a", 500ms);
    t.type("q");
  });
  const Said said = drive("record", {"--set", "drive=teleop", "--set", "require=[]"}, terminal);
  ASSERT_EQ(said.status, 0) << said.out << terminal.shown();
  const Said again = panoptes({"explore", "t", "--quiet", "--out", "again"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_FALSE(metrics("again").contains("replay")) << metrics("again")["replay"];
  EXPECT_EQ(read_file(folder_ / "work/again/steps.csv"), read_file(folder_ / "work/t/steps.csv"));
  const Said driven = panoptes({"teleop", "t", "--out", "driven"});
  EXPECT_EQ(driven.status, 2);
  EXPECT_THAT(driven.err, HasSubstr("t: platform: a recording cannot be driven; "));
}

TEST_F(TeleopRun, WithoutTerminalAndGamepadItIsRefused) {
  const Said said = panoptes({"teleop", kOffice, "--out", "t"});
  EXPECT_EQ(said.status, 3);
  EXPECT_EQ(said.err,
            "teleop: nobody can drive: stdin is no terminal and no gamepad is plugged in; run it "
            "in the foreground of a terminal, or plug one in (panoptes doctor lists them)\n");
  EXPECT_FALSE(fs::exists(folder_ / "work/t"));
}

}  // namespace
}  // namespace panoptes
