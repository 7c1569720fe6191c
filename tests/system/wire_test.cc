// SPDX-License-Identifier: BSD-3-Clause
// A robot at the end of a Pioneer's wire: explored with, lost, refused.
#include <chrono>
#include <future>
#include <thread>

#include <gmock/gmock.h>

#include "tests/system/program.h"

namespace panoptes {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kWire = kScenes + "missions/wire-office.yaml";

class Wire : public SystemTest {
 protected:
  Said explore_wired(const std::string& base, const std::string& out) const {
    return explore(kWire, out,
                   {"--seed", "4", "--duration", "20", "--set", "platform.base=" + base, "--set",
                    "require=[collisions == 0, outcome == completed]"});
  }
};

TEST_F(Wire, ExploresWithoutTouchingAnythingAndTheSameAgain) {
  for (const char* base : {"standin:pty", "standin:tcp"}) {
    const Said said = explore_wired(base, base + 8);
    EXPECT_EQ(said.status, 0) << said.err << said.out;
    const nlohmann::json found = metrics(base + 8);
    EXPECT_EQ(found["collisions"], 0);
    EXPECT_GT(found["distance_m"], 2);
    EXPECT_GT(found["keyframes"], 20);
    EXPECT_LT(found["trajectory"]["ate_rmse_m"], 0.1);
    const nlohmann::json& link = found["devices"]["base"];
    EXPECT_GT(link["reports"], 190);
    EXPECT_EQ(link["rejected_implausible"], 0);
    EXPECT_EQ(link["expired"], 0);
  }
  EXPECT_EQ(explore_wired("standin:pty", "again").status, 0);
  const auto once = comparable(folder_ / "work" / "pty");
  const auto twice = comparable(folder_ / "work" / "again");
  ASSERT_EQ(once.size(), twice.size());
  for (const auto& [name, text] : once) {
    EXPECT_TRUE(twice.at(name) == text) << name << " differs";
  }
}

// The server goes while somebody records: as when the cable is pulled.
TEST_F(Wire, LostIsSaidWithThePortsNameAndWhatWasDoneIsKept) {
  const std::string port = folder_ / "pioneer";
  auto served = std::async(std::launch::async, [&] {
    return panoptes(
        {"serve", kWire, "--link", port, "--duration", "7", "--quiet", "--out", "served"});
  });
  while (!std::filesystem::is_symlink(port) &&
         served.wait_for(std::chrono::milliseconds(20)) == std::future_status::timeout) {
  }
  const std::string mission = write(
      "blind.yaml", "platform: {kind: pioneer, base: \"serial:" + port + "\"}\ndrive: none\n");
  const Said said = panoptes({"record", mission, "--quiet", "--out", "lost"});
  EXPECT_EQ(said.status, 3);
  EXPECT_THAT(said.out, AllOf(HasSubstr("device_lost"), HasSubstr("serial:" + port)));
  EXPECT_EQ(served.get().status, 0);
  const nlohmann::json found = metrics("lost");
  EXPECT_EQ(found["outcome"], "device_lost");
  EXPECT_GT(found["run_s"], 1);
  EXPECT_GT(found["devices"]["base"]["reports"], 10);
  EXPECT_TRUE(found.contains("start_unix_ns"));

  const Said evaluated = panoptes({"evaluate", "lost", "--truth", "served"});
  EXPECT_EQ(evaluated.status, 3) << evaluated.err;  // as the run ended
  EXPECT_EQ(metrics("lost")["collisions"], 0);
}

TEST_F(Wire, IsRefusedBeforeAnythingMoves) {
  const auto refused = [&](const std::string& base) {
    const std::string mission =
        write("m.yaml", "platform: {kind: pioneer, base: \"" + base + "\"}\ndrive: none\n");
    return panoptes({"record", mission, "--quiet", "--out", "none"});
  };
  const Said no_port = refused("serial:/dev/ttyNONE");
  EXPECT_EQ(no_port.status, 3);
  EXPECT_THAT(no_port.err, HasSubstr("serial:/dev/ttyNONE: no such port"));
  const Said nobody = refused("tcp:127.0.0.1:1");
  EXPECT_EQ(nobody.status, 3);
  EXPECT_THAT(nobody.err, HasSubstr("tcp:127.0.0.1:1: the host refuses"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "work" / "none" / "metrics.json"));
}

}  // namespace
}  // namespace panoptes
