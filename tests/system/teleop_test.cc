// SPDX-License-Identifier: BSD-3-Clause
// Driving by hand, over a terminal of the test's own.
#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/csv.h"
#include "core/io/file.h"
#include "tests/system/program.h"
#include "tests/system/terminal.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

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
