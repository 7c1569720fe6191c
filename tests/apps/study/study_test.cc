// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study/study.h"

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "core/io/file.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using testing::ElementsAre;

constexpr const char* kStudy = R"(missions:
  - {name: office, mission: office.yaml, set: [a=1]}
  - {name: home, mission: home.yaml}
set: [until.duration_s=240]
rigs:
  - {name: axis, rig: axis.yaml}
  - {name: front alone, set: [b=2]}
rungs:
  - {name: none}
  - {name: 1 degree, set: ["c={d: 3}"]}
  - {name: lens, rigs: [axis]}
limits:
  - {require: loops.false == 0}
  - {require: loops.recall_same >= 0.9, rigs: [front alone], rungs: [1 degree], missions: [home]}
)";

class StudyTest : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    for (const char* name : {"office.yaml", "home.yaml", "axis.yaml"}) {
      write_file(folder_ / name, "");
    }
  }
  Study read(const std::string& text) {
    write_file(folder_ / "study.yaml", text);
    return read_study(path("study.yaml"));
  }
  /// What is wrong with it, without the folder.
  std::vector<std::string> faults(const std::string& text) {
    try {
      read(text);
    } catch (const ConfigError& error) {
      std::vector<std::string> lines = error.lines();
      for (std::string& line : lines) {
        for (std::size_t at = 0; (at = line.find(folder_.string() + "/")) != std::string::npos;) {
          line.erase(at, folder_.string().size() + 1);
        }
      }
      return lines;
    }
    return {};
  }
  /// The same of the study above with some of its words exchanged.
  std::vector<std::string> faults(const std::string& words, const std::string& by) {
    std::string text = kStudy;
    return faults(text.replace(text.find(words), words.size(), by));
  }
};

TEST_F(StudyTest, IsEveryRungUnderEveryRigInEveryMission) {
  const std::vector<StudyCell> cells = cells_of(read(kStudy));
  std::vector<std::string> names;
  names.reserve(cells.size());
  for (const StudyCell& cell : cells) {
    names.push_back(cell.mission + " " + cell.rung + " " + cell.rig);
  }
  EXPECT_THAT(
      names, ElementsAre("office none axis", "office none front alone", "office 1 degree axis",
                         "office 1 degree front alone", "office lens axis", "home none axis",
                         "home none front alone", "home 1 degree axis", "home 1 degree front alone",
                         "home lens axis"));
  EXPECT_EQ(cells[5].mission_file, path("home.yaml"));
}

TEST_F(StudyTest, SetsWhatStudyMissionRigAndRungSayInThisOrder) {
  const std::vector<StudyCell> cells = cells_of(read(kStudy));
  const std::string rig = "\"" + path("axis.yaml") + "\"";
  EXPECT_THAT(cells[2].settings.set, ElementsAre("until.duration_s=240", "a=1", "rig=" + rig,
                                                 "platform.nominal_rig=" + rig, "c={d: 3}"));
  EXPECT_THAT(cells[3].settings.set, ElementsAre("until.duration_s=240", "a=1", "b=2", "c={d: 3}"));
  EXPECT_EQ(cells[3].settings.places.back(), path("study.yaml") + ":10:28");
}

TEST_F(StudyTest, AsksOfEachRunWhatConcernsIt) {
  const std::vector<StudyCell> cells = cells_of(read(kStudy));
  for (const StudyCell& cell : cells) {
    const bool both =
        cell.mission == "home" && cell.rig == "front alone" && cell.rung == "1 degree";
    ASSERT_EQ(cell.limits.size(), both ? 2U : 1U) << cell.mission << cell.rig << cell.rung;
    EXPECT_EQ(cell.limits[0].text, "loops.false == 0");
  }
}

TEST_F(StudyTest, SaysWhereTheSettingStandsThatAMissionRefuses) {
  const StudyCell cell = cells_of(read(kStudy))[2];
  EXPECT_THAT(
      with_places(cell.settings,
                  {"--set c: unknown key", "--set c.e: c: unknown key",
                   "--set platform.nominal_rig: no such file", "office.yaml:1:1: x: y"}),
      ElementsAre(path("study.yaml") + ":10:28: c: unknown key", "--set c.e: c: unknown key",
                  path("study.yaml") + ":6:23: platform.nominal_rig: no such file",
                  "office.yaml:1:1: x: y"));
}

TEST_F(StudyTest, SaysOnceWhatIsWrongWithAllThatAStarStandsFor) {
  EXPECT_THAT(with_places({{"a.*.b=1", "a.*=2"}, {"s.yaml:1:1", "s.yaml:2:2"}},
                          {"--set a.*.b: a.x.b: unknown key", "--set a.*.b: a.y.b: unknown key",
                           "--set a.*: a: has no keys that * could stand for"}),
              ElementsAre("s.yaml:1:1: a.*.b: unknown key", "s.yaml:1:1: a.*.b: unknown key",
                          "s.yaml:2:2: a.*: a: has no keys that * could stand for"));
}

TEST_F(StudyTest, RefusesWhatIsNoStudyWithLineAndCure) {
  EXPECT_THAT(faults("set: []\n"),
              ElementsAre("study.yaml:1:1: missions: missing; it must be given",
                          "study.yaml:1:1: rigs: missing; it must be given",
                          "study.yaml:1:1: rungs: missing; it must be given"));
  EXPECT_THAT(faults("missions: []\nrigs: [{}]\nrungs: [{name: a, sets: []}]\n"),
              ElementsAre("study.yaml:1:11: missions: must have one entry at least",
                          "study.yaml:2:8: rigs[0].name: missing; it must be given",
                          "study.yaml:3:19: rungs[0].sets: unknown key; did you mean set?"));
  EXPECT_THAT(faults("mission: home.yaml", "mission: house.yaml"),
              ElementsAre("study.yaml:3:27: missions[1].mission: no such file: house.yaml"));
  EXPECT_THAT(faults("name: axis", "name: a/b"),
              ElementsAre("study.yaml:6:12: rigs[0].name: must begin with a letter or a digit, and "
                          "have none of / | *, got a/b"));
}

TEST_F(StudyTest, RefusesNamesThatNameNothingOrTwo) {
  EXPECT_THAT(faults("name: 1 degree", "name: none"),
              ElementsAre("study.yaml:10:12: rungs: two are called 'none'; give one of them "
                          "another name",
                          "study.yaml:14:70: limits.rungs: there is no '1 degree'; known: none, "
                          "none, lens"));
  EXPECT_THAT(faults("rigs: [axis]", "rigs: [axes]"),
              ElementsAre("study.yaml:11:25: rungs.rigs: there is no 'axes'; did you mean axis?"));
  EXPECT_THAT(faults("rungs: [1 degree]", "rungs: [lens]"),
              ElementsAre("study.yaml:14:15: limits: 'loops.recall_same >= 0.9' concerns no run; "
                          "no rung that it names is tried with a rig that it names"));
}

TEST_F(StudyTest, RefusesSettingsAndLimitsThatAreNone) {
  EXPECT_THAT(faults("[b=2]", "[b]"),
              ElementsAre("study.yaml:7:31: set: must be key.path=value, got b"));
  EXPECT_THAT(faults("[b=2]", "[seed=2]"),
              ElementsAre("study.yaml:7:31: set: must not say the seed; --seeds does"));
  EXPECT_THAT(faults("loops.false == 0", "loops.wrong == 0"),
              ElementsAre("study.yaml:13:15: limits[0].require: limit 'loops.wrong == 0': no run "
                          "has a figure 'loops.wrong', got loops.wrong == 0"));
  EXPECT_THAT(
      faults("set: [until", "against_first: [loops.false == 0]\nset: [until"),
      ElementsAre("study.yaml:4:16: against_first: 'loops.false == 0': must be a figure, one "
                  "of < <= > >=, and by how much it may differ"));
}

TEST_F(StudyTest, SaysWhatIsDoneWithAMission) {
  EXPECT_FALSE(calibrates(cells_of(read(kStudy)).front().command));
  std::string text = kStudy;
  text.replace(text.find("set: [a=1]"), 10, "command: calibrate --method thesis");
  const Study study = read("figure: cameras.*.rotation_error_deg\n" + text);
  EXPECT_EQ(cells_of(study).front().command, "calibrate --method thesis");
  EXPECT_TRUE(calibrates(cells_of(study).front().command));
  EXPECT_FALSE(calibrates(cells_of(study).back().command));
  EXPECT_EQ(study.figure, "cameras.*.rotation_error_deg");
  EXPECT_THAT(faults("set: [a=1]", "command: calibrat"),
              ElementsAre("study.yaml:2:51: missions[0].command: must be one of explore, "
                          "calibrate, calibrate --method thesis, calibrate --method cycles, got "
                          "calibrat"));
  EXPECT_THAT(
      faults("limits:", "figure: cameras.*.rotation_error\nlimits:"),
      ElementsAre(testing::StartsWith("study.yaml:12:9: figure: must be a figure of a run, or "
                                      "of a calibration")));
}

TEST_F(StudyTest, RefusesAHalvingThatCannotDecide) {
  const auto with = [&](const std::string& halving) {
    std::string text = kStudy;
    text.replace(text.find("rungs:"), 6, "  - {name: third}\nrungs:");
    text.replace(text.find("limits:"), 7, "halving: " + halving + "\nlimits:");
    return faults(text);
  };
  const std::string of_rungs =
      "study.yaml:12:25: rungs.rigs: must not be given beside halving, which compares rigs over "
      "all rungs";
  EXPECT_THAT(with("{least: map.coverage}"), ElementsAre(of_rungs));
  EXPECT_THAT(with("{seeds: 2}"),
              ElementsAre("study.yaml:13:10: halving.least: missing; least or most must name the "
                          "figure to compare rigs by"));
  EXPECT_THAT(with("{seeds: 2, least: map.coverage, most: map.coverage}"),
              ElementsAre("study.yaml:13:48: halving.most: must not be given beside least, got "
                          "map.coverage"));
  EXPECT_THAT(
      with("{seeds: 2, most: map.coverag}"),
      ElementsAre("study.yaml:13:27: halving.most: must be a figure of a run, as map.coverage, "
                  "got map.coverag"));
  EXPECT_THAT(
      with("{keep: 2, most: map.coverage}"),
      ElementsAre("study.yaml:12:25: rungs.rigs: must not be given beside halving, which "
                  "compares rigs over all rungs",
                  "study.yaml:13:17: halving: has nothing to drop: 2 beside the first, 2 to "
                  "be kept"));
}

TEST_F(StudyTest, RefusesScoresThatAreNone) {
  const auto with = [&](const std::string& scores) {
    return faults("limits:", "scores: " + scores + "\nlimits:");
  };
  EXPECT_THAT(with("[{most: map.coverag}]"),
              ElementsAre("study.yaml:12:17: scores[0].most: must be a figure of a run, as "
                          "map.coverage, got map.coverag"));
  EXPECT_THAT(with("[{}]"), ElementsAre(testing::HasSubstr("missing; least or most must name")));
}

TEST(StudyScore, OfManyIsTheWorst) {
  const FigureRow run = FigureRows().row({{"cameras.a.rotation_error_deg", 1},
                                          {"cameras.b.rotation_error_deg", 3},
                                          {"map.coverage", 0.5}});
  EXPECT_EQ((StudyScore{"cameras.*.rotation_error_deg", ""}.of(run)), 3);
  EXPECT_EQ((StudyScore{"", "cameras.*.rotation_error_deg"}.of(run)), 1);
  EXPECT_EQ((StudyScore{"", "map.coverage"}.of(run)), 0.5);
  EXPECT_EQ((StudyScore{"loops.*.x", ""}.of(run)), std::nullopt);
}

TEST_F(StudyTest, IsWrittenAsItIsRead) {
  std::string whole = kStudy;
  whole.replace(whole.find(", rigs: [axis]"), 14, "");
  whole.replace(whole.find("rungs:"), 6, "  - {name: third}\nrungs:");
  const std::string text =
      write_settings(read(whole + "against_first: [map.coverage >= -0.01]\n"
                                  "scores: [{least: loops.false}]\n"
                                  "halving: {seeds: 3, most: map.coverage}\n"));
  EXPECT_EQ(read(text).scores[0].least, "loops.false");
  EXPECT_EQ(read(text).halving->seeds, 3);
  EXPECT_NE(text.find("map.coverage >= -0.01"), std::string::npos);
  EXPECT_EQ(write_settings(read(text)), text);
}

}  // namespace
}  // namespace panoptes
