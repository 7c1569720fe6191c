// SPDX-License-Identifier: BSD-3-Clause
// Recorded runs: the same again bit for bit, mapped with other settings, killed, spoilt.
#include <csignal>

#include <gmock/gmock.h>

#include "core/io/csv.h"
#include "core/io/dataset.h"
#include "core/io/file.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;
using testing::StartsWith;

const std::vector<std::string> kShort{"--seed", "3", "--duration", "8", "--set", "require=[]"};
// Of pictures that are stamped as their frame sets are.
const std::vector<std::string> kExactClocks{"--set", "platform.clock_error.sigma_s=0"};
constexpr int kFrames = 121;  // at 15 Hz, the first at 0 and the last at 8 s

// Everything that can go wrong with a frame set: late, jittered, missing, of other rates, and waits
// too short for the next.
const std::vector<std::string> kHard{
    "--set",
    "frame_deadline_s=0.03",
    "--set",
    "rig.cameras.back.rate_hz=10",
    "--set",
    "platform.trigger={latency_s: 0.02, groups: {a: {cameras: [front], offset_s: 0.01, jitter_s: "
    "0.002, drops: 0.2}}}"};

class Replay : public SystemTest {
 protected:
  Said record(const std::string& out, std::vector<std::string> more, const Fate& fate = {}) const {
    more.insert(more.begin(), {"record", kOffice, "--quiet", "--out", out});
    return panoptes(more, fate);
  }

  Said replay(const std::string& dataset, const std::string& out,
              const std::vector<std::string>& more = {}) const {
    return explore(dataset, out, more);
  }

  // Of two runs all that both must have, but for the settings that tell where the robot came from.
  void expect_same(const std::string& a, const std::string& b) const {
    const auto files_a = comparable(folder_ / "work" / a);
    const auto files_b = comparable(folder_ / "work" / b);
    EXPECT_GE(files_a.size(), 14U);
    for (const auto& [name, text] : files_a) {
      if (name == "mission.yaml") {
        continue;
      }
      ASSERT_TRUE(files_b.contains(name)) << name;
      if (name == "metrics.json") {
        auto of_a = nlohmann::json::parse(text);
        auto of_b = nlohmann::json::parse(files_b.at(name));
        of_a.erase("command");
        of_b.erase("command");
        EXPECT_EQ(of_a, of_b);
      } else {
        EXPECT_TRUE(files_b.at(name) == text) << name << " differs";
      }
    }
  }

  std::vector<std::string> with(std::vector<std::string> words,
                                const std::vector<std::string>& more) const {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

TEST_F(Replay, GivesEveryStepOfTheLiveRunBitForBit) {
  EXPECT_EQ(explore(kOffice, "live", kShort).status, 0);
  EXPECT_EQ(record("data", kShort).status, 0);
  const Said said = replay("data", "again");
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(said.err, "");
  expect_same("live", "data");
  expect_same("live", "again");
  EXPECT_EQ(metrics("again")["frames"], kFrames);
  EXPECT_EQ(metrics("again")["end_reason"], "duration");
  EXPECT_FALSE(metrics("again").contains("replay"));
  // and what was replayed is repeated from its own settings
  EXPECT_EQ(explore("again/mission.yaml", "once-more", {}).status, 0);
  expect_same("again", "once-more");
}

TEST_F(Replay, GivesBackLateMissingAndUnequalPictures) {
  const auto words = with({"--seed", "3", "--duration", "4", "--set", "require=[]"}, kHard);
  EXPECT_EQ(explore(kOffice, "live", words).status, 0);
  EXPECT_EQ(record("data", words).status, 0);
  const std::string events = read_file(folder_ / "work/data/mav0/events.csv");
  for (const char* kind : {",deadline,", ",now,", ",picture,front,", ",missing,front,"}) {
    EXPECT_THAT(events, HasSubstr(kind));
  }
  EXPECT_EQ(replay("data", "again").status, 0);
  expect_same("live", "again");
}

TEST_F(Replay, SaysFromWhenOnOtherSettingsWouldHaveDrivenElsewhere) {
  EXPECT_EQ(record("data", kShort).status, 0);
  const Said said = replay("data", "other", {"--set", "navigator.driver.lookahead_m=0.3"});
  EXPECT_EQ(said.status, 0);
  EXPECT_THAT(said.out, HasSubstr("\nreplayed: with these settings the robot would have driven "
                                  "differently from "));
  const auto m = metrics("other");
  EXPECT_GT(m["replay"]["commands_diverged_at_s"], 0);
  for (const char* key : {"collisions", "min_clearance_m", "stuck_s", "goals", "exploration"}) {
    EXPECT_FALSE(m.contains(key)) << key;
  }
  EXPECT_EQ(m["frames"], kFrames);
  EXPECT_EQ(m["trajectory"].size(), 4U);

  // a mission of its own takes rig, robot and seed from the recording
  write("m.yaml", "platform: {recorded: data}\nnavigator: {revisits_last: 1000}\n");
  EXPECT_EQ(panoptes({"check", "m.yaml"}).out, "m.yaml: ok (mission)\n");
  EXPECT_EQ(replay("m.yaml", "own").status, 0);
  EXPECT_EQ(metrics("own")["end_reason"], "end_of_data");
  EXPECT_FALSE(metrics("own").contains("replay"));
  EXPECT_EQ(read_file(folder_ / "work/own/steps.csv"), read_file(folder_ / "work/data/steps.csv"));
}

TEST_F(Replay, AKilledRecordingIsReadToItsLastCompleteFrameSet) {
  const auto words = with(kShort, kExactClocks);
  EXPECT_EQ(explore(kOffice, "live", words).status, 0);
  const Said killed =
      record("data", words, {{}, {}, SIGKILL, "data/mav0/front/data/2000000000.png"});
  EXPECT_EQ(killed.status, -1);
  EXPECT_FALSE(fs::exists(folder_ / "work/data/metrics.json"));
  EXPECT_EQ(replay("data", "again").status, 0);
  EXPECT_EQ(metrics("again")["end_reason"], "end_of_data");
  EXPECT_FALSE(metrics("again").contains("replay"));
  const CsvTable live = read_csv(folder_ / "work/live/steps.csv");
  const CsvTable again = read_csv(folder_ / "work/again/steps.csv");
  ASSERT_GE(again.rows.size(), 29U);
  ASSERT_LT(again.rows.size(), live.rows.size());
  for (std::size_t i = 0; i < again.rows.size(); ++i) {
    EXPECT_EQ(again.rows[i], live.rows[i]);
  }
}

TEST_F(Replay, KeepsWhatThePicturesTrulyShow) {
  const auto words =
      with({"--duration", "0.2", "--set", "require=[]", "--depth", "--labels"}, kExactClocks);
  EXPECT_EQ(record("data", words).status, 0);
  const fs::path mav = folder_ / "work/data/mav0";
  for (const char* folder :
       {"front", "front_depth", "front_labels", "front_floor", "floor_depth"}) {
    EXPECT_TRUE(fs::exists(mav / folder / "data/133333333.png")) << folder;
    EXPECT_THAT(read_file(mav / folder / "data.csv"), HasSubstr("\n133333333,133333333.png\n"));
  }
  EXPECT_THAT(read_file(mav / "things.csv"), StartsWith("#number, thing\n0,nothing\n1,"));
  EXPECT_THAT(read_dataset(folder_ / "work/data").cameras,
              testing::ElementsAre("back", "floor", "front"));
}

TEST_F(Replay, NeedsNoFileButTheDatasets) {
  write("route.yaml", "waypoints: [{x_m: 4.95, y_m: 3.0}]\n");
  // what the mission requires of a whole run, a short recording need not meet
  EXPECT_EQ(record("data", {"--duration", "2", "--set",
                            "platform.start={x_m: 4.95, y_m: 4.0, "
                            "theta_deg: -90}",
                            "--set", "drive={route: route.yaml}"})
                .status,
            0);
  fs::remove(folder_ / "work/route.yaml");
  const std::string kept =
      "data/keyframes: [0-9]+ keyframes, [0-9.]+ kB of signatures and features each\n";
  EXPECT_THAT(panoptes({"check", "data"}).out, MatchesRegex(kept + "data: ok .dataset.\n"));
  EXPECT_EQ(replay("data", "again", {"--set", "require=[]"}).status, 0);
  EXPECT_EQ(read_file(folder_ / "work/data/steps.csv"),
            read_file(folder_ / "work/again/steps.csv"));
  EXPECT_THAT(panoptes({"check", "again"}).out,
              MatchesRegex("again/keyframes: .*\nagain: ok .run.\n"));
  fs::resize_file(folder_ / "work/again/keyframes/features.bin", 100);
  const Said cut = panoptes({"check", "again"});
  EXPECT_EQ(cut.status, 2);
  EXPECT_THAT(cut.out, StartsWith("again/keyframes/features.bin: byte 100: the file ends"));
  fs::remove(folder_ / "work/data/mission.yaml");  // as another program's
  EXPECT_THAT(
      panoptes({"check", "data"}).out,
      MatchesRegex("data: has no mission.yaml; it is replayed with every setting's default, "
                   "or by a mission with platform: .kind: recorded, dataset: data.\n" +
                   kept + "data: ok .dataset.\n"));
  const fs::path rows = folder_ / "work/data/mav0/odom0/data.csv";
  write_file(rows, read_file(rows) + "3000000000,1e9,0,0,0,0\n");
  const Said said = panoptes({"check", "data"});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.out,
            "data/mav0/odom0/data.csv:33: field 2 must be from -1e+06 to 1e+06, got 1e9\n");
}

TEST_F(Replay, NothingIsOverwrittenAndNothingIsLeftOfWhatIsRefused) {
  fs::create_directories(folder_ / "work/data");
  write("data/note.txt", "mine");
  Said said = record("data", {});
  EXPECT_EQ(said.status, 2);
  EXPECT_EQ(said.err, "data: is not empty; remove it or name another folder with --out\n");
  EXPECT_EQ(read_file(folder_ / "work/data/note.txt"), "mine");
  said = record("new", {"--set", "platform.start={x_m: 2.1, y_m: 2, theta_deg: 0}"});
  EXPECT_EQ(said.status, 2);
  EXPECT_FALSE(fs::exists(folder_ / "work/new"));
}

TEST_F(Replay, SpoiltDatasetsAreRefusedWithThePlace) {
  const auto words = with({"--duration", "0.5", "--set", "require=[]"}, kExactClocks);
  EXPECT_EQ(record("data", words).status, 0);
  const fs::path mav = folder_ / "work/data/mav0";
  const auto expect_refused = [&](const std::string& message) {
    const Said said = replay("data", "out");
    EXPECT_EQ(said.status, 2);
    EXPECT_EQ(said.err, message + "\n");
    EXPECT_FALSE(fs::exists(folder_ / "work/out"));
  };
  const std::string picture = read_file(mav / "floor/data/200000000.png");
  write_file(mav / "floor/data/200000000.png", picture.substr(0, picture.size() / 2));
  expect_refused(
      "data/mav0/floor/data.csv:5: data/mav0/floor/data/200000000.png is torn, the end of the PNG "
      "picture is missing: copy it again from where it was recorded, or remove its row");
  write_file(mav / "floor/data/200000000.png", picture);
  const std::string rows = read_file(mav / "odom0/data.csv");
  write_file(mav / "odom0/data.csv", rows.substr(0, rows.find("\n200000000,") + 11) + "\n");
  expect_refused("data/mav0/odom0/data.csv:5: has 2 fields, must have 6");
  fs::remove(mav / "odom0/data.csv");
  const Said said = replay("data", "out");
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, StartsWith("data: has pictures of back, floor, front but no "
                                   "mav0/odom0/data.csv"));
}

}  // namespace
}  // namespace panoptes
