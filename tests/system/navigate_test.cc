// SPDX-License-Identifier: BSD-3-Clause
// Driving to goals in a world that nobody has described to the robot.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/csv.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

const std::vector<std::string> kStart{"--set",
                                      "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}"};

class Navigate : public SystemTest {
 protected:
  Said navigate(const std::string& goals, const std::string& out,
                std::vector<std::string> more = {}) const {
    std::vector<std::string> words{"navigate", kOffice, "--quiet", "--goals", goals, "--out", out};
    words.insert(words.end(), kStart.begin(), kStart.end());
    words.insert(words.end(), more.begin(), more.end());
    return panoptes(words);
  }
};

TEST_F(Navigate, ReachesGoalsDownTheAisleAndBack) {
  const Said said = navigate("2.6,0; -0.2,0", "run", {"--duration", "90"});
  EXPECT_EQ(said.status, 0) << said.err << said.out;
  EXPECT_THAT(said.out, StartsWith("completed (goals_done) after "));
  EXPECT_THAT(said.out, HasSubstr("\ngoal 1 (2.60, 0.00): reached after "));
  const auto m = metrics("run");
  EXPECT_EQ(m["command"], "navigate");
  EXPECT_EQ(m["end_reason"], "goals_done");
  EXPECT_EQ(m["collisions"], 0);
  EXPECT_EQ(m["requirements"][1]["pass"], nullptr) << "how much is mapped is no matter";
  ASSERT_EQ(m["goals"].size(), 2U);
  for (const auto& goal : m["goals"]) {
    EXPECT_EQ(goal["reached"], true);
    EXPECT_EQ(goal["refused"], false);
    EXPECT_LE(goal["true_error_m"], 0.15);
    EXPECT_EQ(goal["path_m"], goal["moved_m"]);
    EXPECT_NEAR(goal["shortest_m"], 2.7, 0.2);
    EXPECT_LT(goal["path_m"], 1.4 * goal["shortest_m"].get<double>());
  }
  const CsvTable steps = read_csv(folder_ / "work/run/steps.csv");
  EXPECT_EQ(steps.number(steps.rows.size() - 1, steps.column("command_v_mps")), 0);

  EXPECT_EQ(explore("run/mission.yaml", "again", {}).status, 0);
  EXPECT_EQ(metrics("again")["goals"], m["goals"]);
}

TEST_F(Navigate, FailsWhereTheTimeIsUpFirst) {
  const Said said = navigate("2.6,0", "run", {"--duration", "2"});
  EXPECT_EQ(said.status, 1) << said.out;
  const auto m = metrics("run");
  EXPECT_EQ(m["outcome"], "completed");
  EXPECT_EQ(m["end_reason"], "duration");
  EXPECT_EQ(m["requirements"].back()["require"], "end_reason == goals_done");
  EXPECT_EQ(m["requirements"].back()["pass"], false);
  EXPECT_EQ(m["goals"][0]["reached"], false);
  EXPECT_EQ(m["goals"][0]["refused"], false);
}

TEST_F(Navigate, RefusesAGoalInADeskAndStands) {
  const Said said = navigate("0.4,1.2", "run", {"--duration", "120"});
  EXPECT_EQ(said.status, 1);
  const auto m = metrics("run");
  EXPECT_EQ(m["outcome"], "goal_unreachable");
  EXPECT_EQ(m["goals"][0]["reached"], false);
  EXPECT_EQ(m["goals"][0]["refused"], true);
  EXPECT_NE(m["goals"][0]["why"], "");
  EXPECT_THAT(said.out, HasSubstr("goal 1 (0.40, 1.20): refused after "));
  EXPECT_EQ(m["collisions"], 0);
}

// Another floor begins 2 m ahead: one that is told by its motion is driven over once it is learned,
// one without any pattern is no floor that anybody could tell.
TEST_F(Navigate, TellsAFloorThatNobodyHasLearnedByItsPattern) {
  for (const bool plain : {false, true}) {
    const std::string rig = kScenes + "rigs/front-back-edges.yaml";
    const auto box = [](const std::string& at_and_size, const std::string& picture) {
      return "{" + at_and_size + ", picture: data:office/" + picture + ".png, picture_m: [2, 2]}";
    };
    write("m.yaml",
          "rig: " + rig + "\nrobot: " + kScenes +
              "robots/pioneer3dx.yaml\nplatform: {kind: simulated, start: {x_m: 0, y_m: 0, "
              "theta_deg: 0}, world: {name: floors, ambient: 0.7, boxes: [" +
              box("name: known, size_m: [3, 2.4, 0.1], at: {x_m: 0.5, y_m: 0}, z_m: -0.1",
                  "carpet_sand") +
              ", " +
              box("name: other, size_m: [2, 2.4, 0.1], at: {x_m: 3, y_m: 0}, z_m: -0.1",
                  plain ? "plain_blue" : "carpet_blue") +
              ", " + box("name: east, size_m: [0.1, 2.4, 1], at: {x_m: 4, y_m: 0}", "books_a") +
              ", " + box("name: west, size_m: [0.1, 2.4, 1], at: {x_m: -1, y_m: 0}", "books_b") +
              ", " + box("name: north, size_m: [5, 0.1, 1], at: {x_m: 1.5, y_m: 1.2}", "books_b") +
              ", " + box("name: south, size_m: [5, 0.1, 1], at: {x_m: 1.5, y_m: -1.2}", "books_a") +
              "]}}\n");
    const std::string out = plain ? "plain" : "patterned";
    const Said said = panoptes(
        {"navigate", "m.yaml", "--quiet", "--goals", "3,0", "--out", out, "--duration", "90"});
    EXPECT_EQ(said.status, plain ? 1 : 0) << said.err << said.out;
    EXPECT_EQ(metrics(out)["goals"][0]["reached"], !plain);
    EXPECT_EQ(metrics(out)["goals"][0]["refused"], plain) << said.out;
    EXPECT_EQ(metrics(out)["collisions"], 0);
  }
}

TEST_F(Navigate, RefusesARecording) {
  ASSERT_EQ(panoptes({"record", kOffice, "--quiet", "--out", "data", "--duration", "1"}).status, 0);
  const Said said = panoptes({"navigate", "data", "--goals", "1,0", "--out", "run"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err,
            "data: platform: a recording cannot be driven; give a mission with another platform, "
            "or map it again with panoptes explore\n");
  EXPECT_FALSE(fs::exists(folder_ / "work" / "run"));
}

}  // namespace
}  // namespace panoptes
