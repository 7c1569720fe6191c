// SPDX-License-Identifier: BSD-3-Clause
#include "apps/trials/run_trials.h"

#include <csignal>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "apps/batch/manifest.h"
#include "apps/trials/halving.h"
#include "apps/trials/tables.h"
#include "core/base/error.h"
#include "core/config/sha256.h"
#include "core/io/csv.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;

constexpr double kRoundoff = 1e-9;

std::string message_of(const std::function<void()>& what) {
  try {
    what();
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Seeds, AreNumbersAndRanges) {
  EXPECT_THAT(parse_seeds("7"), ElementsAre(7));
  EXPECT_THAT(parse_seeds("1-3,101,5-5"), ElementsAre(1, 2, 3, 101, 5));
  for (const char* bad : {"", "a", "1-", "1,,2", "1 2", "-1"}) {
    EXPECT_EQ(message_of([&] { parse_seeds(bad); }),
              std::string("--seeds ") + bad + ": must be numbers and ranges, as 1-5,101");
  }
  EXPECT_EQ(message_of([] { parse_seeds("5-1"); }),
            "--seeds 5-1: 5-1 descends; write the lower number first");
  EXPECT_EQ(
      message_of([] { parse_seeds("7,1-1000000000000"); }),
      "--seeds 7,1-1000000000000: 1-1000000000000 makes too many; at most 100000 may be given");
  for (const char* text : {"7", "1-3,101,5", "3,2,1", "0-1"}) {
    EXPECT_EQ(numbers_text(parse_seeds(text)), text);
  }
  EXPECT_EQ(parse_seeds("0-99999").size(), 100000U);
  EXPECT_EQ(message_of([] { parse_seeds("0-99999,100000"); }),
            "--seeds 0-99999,100000: 100000-100000 makes too many; at most 100000 may be given");
}

TEST(Varying, DividesAtCommasOutsideOfBrackets) {
  const Vary vary = parse_vary("platform.start={x_m: 1, y_m: 2},{x_m: 3, y_m: 4}");
  EXPECT_EQ(vary.key, "platform.start");
  EXPECT_THAT(vary.values, ElementsAre("{x_m: 1, y_m: 2}", "{x_m: 3, y_m: 4}"));
  EXPECT_EQ(message_of([] { parse_vary("a"); }), "--vary a: must be key.path=value,value");
  EXPECT_EQ(message_of([] { parse_vary("a=1,,2"); }), "--vary a=1,,2: has an empty value");
}

/// Stands in for `panoptes explore MISSION --quiet --out DIR --set a=b ...`: coverage is the seed
/// over ten, 0.5 is required. Seed 9 breaks; the setting slow=yes waits until it is interrupted.
/// With paint=better it is 0.05 to 0.06 more, with paint=other 0.09 more for odd seeds and less for
/// even ones.
constexpr const char* kProgram = R"(#!/bin/bash
dir=$5
listing=$7
for word in "$@"; do
  case $word in seed=*) seed=${word#seed=} ;; slow=yes) slow=1 ;; paint=*) paint=${word#paint=} ;; esac
done
mkdir -p "$dir"
echo "$seed" >>"${dir%/*}/../../started"
outcome=completed
if [ -n "${slow:-}" ]; then
  trap 'outcome=interrupted' INT
  while [ $outcome = completed ]; do sleep 0.02; done
fi
if [ "$seed" = 9 ]; then echo "no world" >&2; exit 3; fi
pass=false
[ "$seed" -ge 5 ] && pass=true
coverage=0.$seed
case ${paint:-} in
  better) coverage=0.$seed$((5 + seed % 2)) ;;
  other) [ $((seed % 2)) = 1 ] && coverage=0.${seed}9 || coverage=0.$((seed - 1))1 ;;
esac
threads=
settings="${*:8}"
if [ "${8:-}" = --threads ]; then threads=$9; settings="${*:10}"; fi
printf 'm.yaml %s' "$settings" >"$dir/mission.yaml"
sha256sum "$0" "${0%/*}/texture" >"$listing"
cat >"$dir/metrics.json" <<END
{"seed": $seed, "outcome": "$outcome", "wall_s": 2, "threads": "$threads",
 "map": {"coverage": $coverage}, "requirements":
 [{"require": "map.coverage >= 0.5", "value": 0.$seed, "pass": $pass}]}
END
[ $outcome = interrupted ] && exit 130
[ $pass = true ]
)";

class Trials : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    options_.program = folder_ / "program";
    run_as(kProgram);
    write_file(folder_ / "texture", "wood");
    options_.missions = {"m.yaml"};
    options_.seeds = {3, 6};
    options_.out_dir = folder_ / "out";
    options_.junit = folder_ / "junit.xml";
    options_.quiet = true;
    options_.version = "0.1.0";
    options_.resolve = [this](const std::string&, const std::string& mission,
                              const std::vector<std::string>& set) {
      std::string text = mission;
      for (const std::string& setting : set) {
        text += " --set " + setting;
      }
      return ResolvedMission{std::filesystem::path(mission).stem(), text, mission_inputs_};
    };
  }
  void run_as(const std::string& program) {
    write_file(options_.program, program);
    std::filesystem::permissions(options_.program, std::filesystem::perms::owner_all);
  }
  int merge_quietly() {
    testing::internal::CaptureStdout();
    const int status = merge_trials(options_);
    testing::internal::GetCapturedStdout();
    return status;
  }
  json metrics() { return json::parse(read_file(options_.out_dir / "metrics.json")); }
  /// Seeds that were really run, in order.
  std::string started(const std::string& mission = "m") {
    const auto path = options_.out_dir / mission / ".." / "started";
    return std::filesystem::exists(path) ? read_file(path) : "";
  }

  TrialsOptions options_;
  std::map<std::string, std::string> mission_inputs_;
};

TEST_F(Trials, AreRunAndJudged) {
  EXPECT_EQ(run_trials(options_), 1);
  const CsvTable table = read_csv(options_.out_dir / "trials.csv");
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_EQ(table.rows[0][table.column("seed")], "3");
  EXPECT_EQ(table.rows[0][table.column("verdict")], "fail");
  EXPECT_EQ(table.rows[1][table.column("verdict")], "pass");
  EXPECT_EQ(table.rows[1][table.column("map.coverage")], "0.6");
  const json m = metrics();
  EXPECT_EQ(m["outcome"], "failed");
  EXPECT_EQ(m["runs"], 2);
  EXPECT_EQ(m["passed"], 1);
  EXPECT_EQ(m["mission"], "m");
  EXPECT_EQ(m["seeds"], json({3, 6}));
  EXPECT_EQ(
      m["requirements"],
      json::parse(R"([{"require": "map.coverage >= 0.5", "runs": 2, "met": 1, "pass": false}])"));
  for (const char* key : {"schema", "command", "version", "seed", "outcome", "run_s"}) {
    EXPECT_TRUE(m.contains(key)) << key;
  }
  EXPECT_FALSE(m["settings"][0]["scores"].contains("wall_s"));
  const CsvTable timing = read_csv(options_.out_dir / "timing.csv");
  EXPECT_THAT(timing.columns, ElementsAre("mission", "seed", "wall_s"));
  EXPECT_THAT(timing.rows[1], ElementsAre("m", "6", "2"));
  EXPECT_NEAR(m["settings"][0]["scores"]["map.coverage"]["mean"].get<double>(), 0.45, kRoundoff);
  EXPECT_EQ(m["settings"][0]["scores"]["map.coverage"]["count"], 2);
  const std::string junit = read_file(options_.junit);
  EXPECT_THAT(junit, HasSubstr("tests=\"2\" failures=\"1\" errors=\"0\" skipped=\"0\""));
  EXPECT_THAT(junit, HasSubstr("<testcase classname=\"m\" name=\"seed 6\" time=\"2.000\"/>"));
  EXPECT_THAT(junit, HasSubstr("<failure message=\"map.coverage &gt;= 0.5, it is 0.3\">"));
}

TEST_F(Trials, ExplainTheirTable) {
  testing::internal::CaptureStdout();
  run_trials(options_);
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              HasSubstr("\nmeans over the seeds +- half of their 95 % intervals; panoptes trials "
                        "--help says what the columns are\n"));
  EXPECT_THAT(table_legend(),
              HasSubstr("\n  coverage %      of the floor that the robot can get to: mapped "
                        "(map.coverage)\n"));
}

TEST_F(Trials, PassWhenEveryRunPasses) {
  options_.seeds = {5, 6, 7};
  options_.jobs = 2;
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_EQ(metrics()["outcome"], "completed");
  const json run = json::parse(read_file(options_.out_dir / "m" / "7" / "metrics.json"));
  EXPECT_EQ(run["threads"], "1");  // the runs share the machine
}

TEST_F(Trials, KeepWhatIsFinishedAndRunTheRest) {
  options_.seeds = {5};
  EXPECT_EQ(run_trials(options_), 0);
  options_.seeds = {5, 6};
  std::filesystem::create_directories(options_.out_dir / "m" / "6");
  write_file(options_.out_dir / "m" / "6" / "steps.csv", "half of a run");
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_EQ(started(), "5\n6\n");
  EXPECT_FALSE(std::filesystem::exists(options_.out_dir / "m" / "6" / "steps.csv"));
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_EQ(started(), "5\n6\n");
}

TEST_F(Trials, OverwriteNothingThatOthersHaveLeft) {
  options_.seeds = {5, 6};
  EXPECT_EQ(run_trials(options_), 0);
  const std::string table = read_file(options_.out_dir / "trials.csv");
  options_.set = {"a=1"};
  EXPECT_EQ(message_of([&] { run_trials(options_); }),
            (options_.out_dir / "m" / "5").string() +
                ": holds a run with other settings or of another version; name another folder "
                "with --out");
  options_.set = {};
  options_.seeds = {5, 7};
  EXPECT_EQ(
      message_of([&] { run_trials(options_); }),
      (options_.out_dir / "manifest.jsonl").string() +
          ": holds m seed 6, which is not among these runs; ask for it as well, or name another "
          "folder with --out");
  options_.vary = {parse_vary("a=1,2")};
  EXPECT_EQ(message_of([&] { run_trials(options_); }),
            (options_.out_dir / "manifest.jsonl").string() +
                ": is of trials that varied other settings; name another folder with --out");
  EXPECT_EQ(read_file(options_.out_dir / "trials.csv"), table);
  EXPECT_EQ(started(), "5\n6\n");
}

TEST_F(Trials, KeepNoVerdictOnWhatHasChanged) {
  options_.seeds = {6};
  EXPECT_EQ(run_trials(options_), 0);
  const std::string run = (options_.out_dir / "m" / "6").string();
  const auto refused = [&] { return message_of([&] { run_trials(options_); }); };
  const std::string elsewhere = "; name another folder with --out";
  const std::string texture = (folder_ / "texture").string();

  write_file(texture, "stone");
  EXPECT_EQ(refused(), run + ": holds a run of before " + texture + " changed" + elsewhere);
  std::filesystem::remove(texture);
  EXPECT_EQ(refused(), run + ": holds a run of before " + texture + " changed" + elsewhere);
  write_file(texture, "wood");
  EXPECT_EQ(refused(), "no error");

  mission_inputs_["/included.yaml"] = "hash";
  EXPECT_EQ(refused(), run + ": holds a run that did not read /included.yaml" + elsewhere);
  mission_inputs_.clear();

  write_file(options_.program, std::string(kProgram) + "# another\n");
  EXPECT_EQ(refused(), run + ": holds a run of another program" + elsewhere);
  write_file(options_.program, kProgram);

  const std::string inputs = run + "/inputs.sha256";
  const std::string listing = read_file(inputs);
  std::filesystem::remove(inputs);
  EXPECT_EQ(refused(), run + ": holds a run that does not say what it was made of (" + inputs +
                           " is missing)" + elsewhere);
  write_file(inputs, listing);
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_EQ(started(), "6\n");
}

TEST_F(Trials, ThatCannotWriteTheirVerdictsDoNotBegin) {
  options_.junit = folder_ / "nowhere" / "junit.xml";
  EXPECT_EQ(message_of([&] { run_trials(options_); }),
            "--junit " + options_.junit.string() +
                ": cannot be created: No such file or directory; name another file");
  options_.junit = folder_;
  EXPECT_EQ(message_of([&] { run_trials(options_); }),
            "--junit " + folder_.string() + ": is a folder; name another file");
  EXPECT_FALSE(std::filesystem::exists(options_.out_dir));
  EXPECT_EQ(started(), "");
}

TEST_F(Trials, TryEveryCombinationOfSettings) {
  options_.seeds = {5};
  options_.vary = {parse_vary("a=1,2"), parse_vary("file=x/y,z")};
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_TRUE(
      std::filesystem::exists(options_.out_dir / "m" / "a=2,file=x_y" / "5" / "metrics.json"));
  EXPECT_EQ(metrics()["settings"].size(), 4U);
  EXPECT_EQ(metrics()["settings"][2]["vary"], (json{{"a", "2"}, {"file", "x/y"}}));
}

TEST_F(Trials, CompareSettingsWithTheFirstSeedBySeed) {
  options_.seeds = {5, 6, 7, 8};
  options_.vary = {parse_vary("paint=plain,better,other,plainer")};
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_trials(options_), 0);
  const std::string said = testing::internal::GetCapturedStdout();
  EXPECT_THAT(said, ContainsRegex("m paint=better +4 +\\+5.5 \\+- 0.9"));
  EXPECT_THAT(said, ContainsRegex("m paint=other +4 +none from 2"));
  EXPECT_THAT(said, ContainsRegex("m paint=plainer +4 +same"));
  const json settings = metrics()["settings"];
  EXPECT_FALSE(settings[0].contains("differences"));
  const json better = settings[1]["differences"]["map.coverage"];
  EXPECT_NEAR(better["mean"].get<double>(), 0.055, kRoundoff);
  EXPECT_EQ(better["pairs"], 4);
  EXPECT_EQ(better["shows"], true);
  const json other = settings[2]["differences"]["map.coverage"];
  EXPECT_EQ(other["shows"], false);
  EXPECT_GT(other["detectable"], other["high"]);
}

TEST(Varying, OfAStudyOfPlacesIsAListInEveryRun) {
  TrialsOptions options;
  add_vary(options, parse_vary("places.histogram=grey,colour"));
  add_vary(options, parse_vary("a=1,2"));
  EXPECT_THAT(options.set, ElementsAre("places.histogram=[grey, colour]"));
  ASSERT_EQ(options.vary.size(), 1U);
  EXPECT_EQ(options.vary[0].key, "a");
}

/// All that trials leave but their runs and what these cost.
std::map<std::string, std::string> left_in(const fs::path& out_dir) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(out_dir)) {
    const std::string name = entry.path().filename();
    if (entry.is_regular_file() && name != "started" && name != "timing.csv") {
      files[name] = read_file(entry.path());
    }
  }
  return files;
}

TEST_F(Trials, OfShardsLeaveTheSameBytes) {
  options_.seeds = {3, 5, 6, 7, 9};
  options_.vary = {parse_vary("paint=plain,better")};
  options_.jobs = 2;
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_trials(options_), 1);
  const auto whole = left_in(options_.out_dir);
  EXPECT_THAT(whole, testing::Contains(testing::Key("trials.csv")));
  const std::string verdicts = read_file(options_.junit);

  options_.out_dir = folder_ / "sharded";
  EXPECT_EQ(run_shard(options_, {2, 3}), 1) << "seed 9 breaks";
  EXPECT_EQ(merge_trials(options_), 1);
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              HasSubstr("7 of 10 runs are missing: m/paint=plain/3, m/paint=plain/6, "));
  EXPECT_EQ(metrics()["missing"], 7);
  TrialsOptions planned;  // all else is in the manifest
  planned.out_dir = options_.out_dir;
  planned.program = options_.program;
  planned.version = options_.version;
  planned.junit = folder_ / "sharded.xml";
  planned.quiet = true;
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_shard(planned, {1, 3}), 1) << "seed 9 breaks";
  EXPECT_EQ(run_shard(planned, {3, 3}), 0);
  EXPECT_EQ(run_shard(planned, {1, 1}), 1) << "twice as well";
  EXPECT_EQ(merge_trials(planned), 1);
  testing::internal::GetCapturedStdout();
  EXPECT_EQ(left_in(options_.out_dir), whole);
  EXPECT_EQ(read_file(folder_ / "sharded.xml"), verdicts);
}

TEST_F(Trials, OfAShardThatWasKilledAreMadeAgain) {
  options_.seeds = {5, 6};
  EXPECT_EQ(run_shard(options_, {1, 2}), 0);
  const fs::path left = options_.out_dir / "m" / ".6.part-elsewhere-7" / "run";
  fs::create_directories(left);
  write_file(left / "steps.csv", "half of a run");
  EXPECT_EQ(merge_trials(options_), 1);
  EXPECT_TRUE(fs::exists(left)) << "it may still run";
  EXPECT_EQ(run_shard(options_, {2, 2}), 0);
  EXPECT_EQ(merge_trials(options_), 0);
  EXPECT_FALSE(fs::exists(left.parent_path()));
  EXPECT_EQ(started(), "5\n6\n");
}

TEST_F(Trials, OfWhomSomebodyWasFirstAreThrownAway) {
  options_.seeds = {6};
  EXPECT_EQ(run_trials(options_), 0);
  const fs::path first = folder_ / "first";
  fs::rename(options_.out_dir / "m" / "6", first);
  write_file(first / "mark", "first");
  run_as(std::string(kProgram) + "mv '" + first.string() +
         "' \"${dir%/*}/../6\"\n[ $pass = true ]");
  write_file(first / "inputs.sha256", sha256(read_file(options_.program)) + "  program\n");
  fs::remove(options_.out_dir / "manifest.jsonl");
  fs::remove(options_.out_dir / "trials.csv");
  fs::remove(options_.out_dir / "timing.csv");
  fs::remove(options_.out_dir / "metrics.json");
  fs::remove(options_.out_dir / "started");
  fs::remove(options_.out_dir / "m");
  EXPECT_EQ(run_shard(options_, {1, 1}), 0);
  EXPECT_TRUE(fs::exists(options_.out_dir / "m" / "6" / "mark"));
  EXPECT_EQ(std::distance(fs::directory_iterator(options_.out_dir / "m"), {}), 1);
}

TEST_F(Trials, KeepTheMetricsAlone) {
  options_.seeds = {6};
  options_.keep = Keep::kMetrics;
  EXPECT_EQ(run_trials(options_), 0);
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(options_.out_dir / "m" / "6")) {
    files.push_back(entry.path().filename());
  }
  EXPECT_THAT(files,
              testing::UnorderedElementsAre("metrics.json", "mission.yaml", "inputs.sha256"));
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_EQ(started(), "6\n");
}

TEST_F(Trials, OfOtherShardsAreNotMerged) {
  options_.seeds = {5, 6};
  EXPECT_EQ(run_shard(options_, {1, 2}), 0);
  const std::string manifest = (options_.out_dir / "manifest.jsonl").string();
  options_.set = {"a=1"};
  EXPECT_EQ(message_of([&] {
              run_shard(options_, {2, 2});
            }),
            manifest +
                ": is of other trials than these; leave the missions and settings out to go on "
                "with those, or name another folder with --out");
  options_.set = {};
  options_.seeds = {5, 6, 7};
  EXPECT_THAT(message_of([&] {
                run_shard(options_, {2, 2});
              }),
              HasSubstr("is of other trials than these"));
  options_.seeds = {5, 6};
  write_file(options_.program, std::string(kProgram) + "# another\n");
  EXPECT_EQ(message_of([&] { merge_trials(options_); }),
            manifest +
                ": was planned by another program; run that one, or name another folder with "
                "--out");
  write_file(options_.program, kProgram);
  const std::string run = (options_.out_dir / "m" / "5").string();
  write_file(run + "/mission.yaml", "of another study");
  for (const auto& act :
       {std::function<void()>([&] { merge_trials(options_); }), std::function<void()>([&] {
          run_shard(options_, {1, 2});
        })}) {
    EXPECT_EQ(message_of(act),
              run +
                  ": holds a run with other settings or of another version; name another folder "
                  "with --out");
  }
  const std::string lines = read_file(manifest);
  write_file(manifest, lines.substr(0, lines.size() / 2));
  EXPECT_THAT(message_of([&] { merge_trials(options_); }),
              HasSubstr(manifest + ": is no manifest of trials, or damaged ("));
  fs::remove(manifest);
  options_.missions.clear();
  EXPECT_EQ(message_of([&] { merge_trials(options_); }),
            manifest + ": cannot be read; name the missions or the study, and trials are planned");
}

TEST(Shards, AreSomeOfHowMany) {
  EXPECT_EQ(parse_shard("2/8").index, 2);
  EXPECT_EQ(parse_shard("2/8").count, 8);
  for (const char* bad : {"", "3", "0/2", "3/2", "1/2/3", "a/b", "1/"}) {
    EXPECT_EQ(message_of([&] { parse_shard(bad); }),
              std::string("--shard ") + bad +
                  ": must be which of how many, as 2/8 is the second of eight");
  }
}

TEST_F(Trials, AreResolvedOnceWhereTheSeedIsOneLine) {
  options_.seeds = {1, 2, 3, 4, 5};
  int resolved = 0;
  const auto count = [&](const std::string& more) {
    resolved = 0;
    options_.resolve = [&resolved, more](const std::string&, const std::string&,
                                         const std::vector<std::string>& set) {
      ++resolved;
      const std::string seed = set.back().substr(5);
      return ResolvedMission{
          "m", "a: 1\nseed: " + seed + "\n" + (more.empty() ? "" : more + seed), {}, 60};
    };
    return plan_trials(options_);
  };
  const std::vector<Trial> trials = count("");
  EXPECT_EQ(resolved, 2);
  EXPECT_EQ(trials[4].settings_sha256, sha256("a: 1\nseed: 5\n"));
  EXPECT_EQ(count("room: ").at(4).settings_sha256, sha256("a: 1\nseed: 5\nroom: 5"));
  EXPECT_EQ(resolved, 5);
}

TEST_F(Trials, GoToTasksOfAMinuteOrMore) {
  auto point = std::make_shared<TrialPoint>();
  point->duration_s = 50;  // a quarter of a minute
  std::vector<Trial> trials(100);
  for (Trial& trial : trials) {
    trial.point = point;
  }
  EXPECT_EQ(tasks_for(trials, std::nullopt), 25);
  EXPECT_EQ(tasks_for(trials, 1), 100);
  EXPECT_EQ(tasks_for(trials, 1000), 1);
  trials[7].left_out = true;
  EXPECT_EQ(tasks_for(trials, 1), 99);
  trials[7].left_out = false;
  point->duration_s = 0.1;
  EXPECT_EQ(tasks_for(trials, std::nullopt), 1);
  point->duration_s = 6000;
  trials.resize(5000, trials[0]);
  EXPECT_EQ(tasks_for(trials, std::nullopt), 1000);
}

TEST_F(Trials, TakeWhatRunsFoundOfPlacesTogether) {
  options_.seeds = {5, 6};
  write_file(options_.program,
             std::string(kProgram) +
                 "cat >\"$dir/places.csv\" <<END\n"
                 "histogram,distance,pictures,recall,recall_same,recall_opposite,recognised,"
                 "keyframes,recalled_same,revisits_same,recalled_opposite,revisits_opposite\n"
                 "grey,emd,front_back,0.25,0.5,,10,40,1,2,0,0\n"
                 "END\n");
  std::filesystem::permissions(options_.program, std::filesystem::perms::owner_all);
  EXPECT_EQ(run_trials(options_), 0);
  const CsvTable study = read_csv(options_.out_dir / "places.csv");
  EXPECT_THAT(study.columns, ElementsAre("mission", "seed", "histogram", "distance", "pictures",
                                         "recall", "recall_same", "recall_opposite"));
  ASSERT_EQ(study.rows.size(), 2U);
  EXPECT_THAT(study.rows[1], ElementsAre("m", "6", "grey", "emd", "front_back", "0.25", "0.5", ""));
  EXPECT_TRUE(std::filesystem::exists(options_.out_dir / "places.png"));
}

/// One mission under two rigs and two rungs.
Study small_study() {
  Study study;
  study.missions.push_back({"office", "", "m.yaml", "explore", {}});
  study.rigs.resize(2);
  study.rigs[0].name = "on the axis";
  study.rigs[1].name = "edges";
  study.rigs[1].settings = {{"b=2"}, {"s.yaml:3:9"}};
  study.rungs.resize(2);
  study.rungs[0].name = "none";
  study.rungs[1].name = "1 degree";
  study.rungs[1].settings = {{"a=1"}, {"s.yaml:5:9"}};
  return study;
}

TEST_F(Trials, RunEveryCellOfAStudy) {
  options_.missions.clear();
  options_.study = small_study();
  options_.seeds = {6, 7};
  options_.set = {"c=3"};
  EXPECT_EQ(run_trials(options_), 0);
  const fs::path run = options_.out_dir / "office" / "edges" / "1-degree" / "7";
  EXPECT_EQ(read_file(run / "mission.yaml"), "m.yaml --set b=2 --set a=1 --set c=3 --set seed=7");
  EXPECT_EQ(read_csv(options_.out_dir / "study.csv").rows.size(), 8U);
  EXPECT_THAT(read_csv(options_.out_dir / "trials.csv").rows[1], testing::Contains("on the axis"));
  EXPECT_THAT(read_file(options_.out_dir / "study.md"), HasSubstr("| rig | none | 1 degree |"));
  EXPECT_EQ(metrics()["settings"][3]["vary"], (json{{"rig", "edges"}, {"rung", "1 degree"}}));
  EXPECT_EQ(metrics()["settings"][3]["runs"], 2);
}

TEST_F(Trials, FailWhereALimitOfAStudyIsBroken) {
  options_.missions.clear();
  options_.study = small_study();
  options_.seeds = {6, 7};
  EXPECT_EQ(run_trials(options_), 0);
  const std::string ran = read_file(options_.out_dir / "office" / "edges" / "started");

  StudyLimit limit;  // seed 6 breaks it, in two of the cells
  limit.require = "map.coverage >= 0.65";
  limit.limit = parse_limit(limit.require);
  limit.rigs = {"edges"};
  options_.study->limits = {limit};
  EXPECT_EQ(run_trials(options_), 1) << "what has been run is judged again";
  EXPECT_EQ(read_file(options_.out_dir / "office" / "edges" / "started"), ran);
  const CsvTable table = read_csv(options_.out_dir / "study.csv");
  int broken = 0;
  for (const auto& row : table.rows) {
    const bool breaks = row[table.column("rig")] == "edges" && row[table.column("seed")] == "6";
    EXPECT_EQ(row[table.column("verdict")], breaks ? "fail" : "pass");
    EXPECT_EQ(row[table.column("faults")], breaks ? "map.coverage >= 0.65, it is 0.6" : "");
    broken += breaks ? 1 : 0;
  }
  EXPECT_EQ(broken, 2);
  EXPECT_EQ(metrics()["outcome"], "failed");
  EXPECT_EQ(metrics()["requirements"][1]["require"], "map.coverage >= 0.65");
  EXPECT_EQ(metrics()["requirements"][1]["runs"], 4);
  EXPECT_EQ(metrics()["requirements"][1]["met"], 2);
  EXPECT_THAT(read_file(options_.out_dir / "study.md"),
              HasSubstr("- office, edges, none, seed 6: map.coverage >= 0.65, it is 0.6\n"));
  EXPECT_THAT(read_file(options_.junit), HasSubstr("name=\"edges, none seed 6\""));

  options_.study->limits[0].limit = parse_limit("trajectory.ate_rmse_m <= 1");
  EXPECT_EQ(run_trials(options_), 1) << "a figure that is absent breaks a limit";
}

TEST_F(Trials, RankTheRigsOfAStudy) {
  options_.missions.clear();
  Study study = small_study();
  study.rigs[1].settings = {{"paint=better"}, {"s.yaml:3:9"}};  // by 0.05 to 0.06
  study.rungs.resize(1);
  study.scores = {{"", "map.coverage"}, {"", "map.*"}};
  options_.study = study;
  options_.seeds = {1, 2, 3, 4, 5, 6, 7, 8};
  testing::internal::CaptureStdout();
  run_trials(options_);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("| office, none | passed |"));
  const std::string page = read_file(options_.out_dir / "study.md");
  EXPECT_LT(page.find("| edges | "), page.find("| on the axis | ", page.find("Ranked")));
  const json settings = metrics()["settings"];
  EXPECT_EQ(settings[1]["rank"], 1);
  EXPECT_EQ(settings[1]["not_distinguishable_from_best"], true);
  EXPECT_EQ(settings[0]["rank"], 2);
  EXPECT_EQ(settings[0]["not_distinguishable_from_best"], false);
  const json by_coverage = settings[0]["ranks"]["map.coverage"];
  EXPECT_GT(by_coverage["detectable"], 0);
  EXPECT_LT(by_coverage["detectable"], 0.055);
  for (const char* picture : {"scores.png", "pareto.png"}) {
    EXPECT_TRUE(fs::exists(options_.out_dir / picture)) << picture;
  }
  EXPECT_FALSE(fs::exists(options_.out_dir / "maps.png")) << "these runs leave none";
}

TEST_F(Trials, DoNotGuessWhichWayAFigureOfAStudyIsBetter) {
  options_.missions.clear();
  options_.study = small_study();
  options_.study->figure = "map.coverage";
  options_.seeds = {6};
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), Not(HasSubstr("Ranked")));
  EXPECT_FALSE(metrics()["settings"][0].contains("rank"));
}

TEST_F(Trials, CompareTheRigsOfAStudyWithItsFirst) {
  options_.missions.clear();
  Study study = small_study();
  study.rigs[1].settings = {{"paint=better"}, {"s.yaml:3:9"}};  // by 0.05 to 0.06
  study.rungs.resize(1);
  for (const char* line :
       {"map.coverage >= -0.01", "map.coverage > 0.055", "map.coverage <= 0.01"}) {
    study.against_first.push_back({line, "s.yaml:9:1", parse_comparison(line)});
  }
  options_.study = study;
  options_.seeds = {5, 6, 7, 8};
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_trials(options_), 0);
  const std::string said = testing::internal::GetCapturedStdout();
  EXPECT_THAT(said, HasSubstr("Against on the axis"));
  EXPECT_THAT(read_file(options_.out_dir / "study.md"), HasSubstr("| map.coverage > 0.055 | "));
  const json settings = metrics()["settings"];
  EXPECT_FALSE(settings[0].contains("against_first"));
  const json told = settings[1]["against_first"];
  ASSERT_EQ(told.size(), 3U);
  EXPECT_EQ(told[0]["holds"], true);
  EXPECT_EQ(told[1]["holds"], false) << "the mean is 0.055, the bound is below";
  EXPECT_EQ(told[2]["holds"], false);
  EXPECT_EQ(told[0]["pairs"], 4);
  EXPECT_NEAR(told[0]["mean"].get<double>(), 0.055, kRoundoff);
  EXPECT_LT(told[0]["bound"].get<double>(), 0.055);
  EXPECT_GT(told[2]["bound"].get<double>(), 0.055);
  EXPECT_GT(told[1]["detectable"].get<double>(), 0.055) << "it would have shown";
  EXPECT_LT(told[2]["detectable"].get<double>(), 0.01);

  options_.seeds = {5};
  options_.out_dir = folder_ / "one";
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_trials(options_), 0);
  testing::internal::GetCapturedStdout();
  EXPECT_EQ(metrics()["settings"][1]["against_first"][0]["holds"], false) << "of one pair";
}

Study halving_study() {
  Study study = small_study();
  study.rungs.resize(1);
  study.rigs.resize(4);
  study.rigs[1] = {"plain", "", "", "", {}};
  study.rigs[2] = {"better", "", "", "", {{"paint=better"}, {"s.yaml:3:9"}}};
  study.rigs[3] = {"other", "", "", "", {{"paint=other"}, {"s.yaml:4:9"}}};
  study.halving = StudyHalving{1, 1, {"", "map.coverage"}, ""};
  return study;
}

TEST_F(Trials, ByHalvingDropTheWorseHalfOfTheRigs) {
  options_.missions.clear();
  options_.study = halving_study();
  options_.seeds = {5, 6, 7, 8};  // other is the best with 5 and the worst with 6
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("| 1 | other, better | plain |"));
  const CsvTable table = read_csv(options_.out_dir / "trials.csv");
  std::map<std::string, std::string> seeds;
  for (const auto& row : table.rows) {
    seeds[row[table.column("rig")]] += row[table.column("seed")];
  }
  EXPECT_THAT(seeds, ElementsAre(Pair("better", "5678"), Pair("on the axis", "5678"),
                                 Pair("other", "56"), Pair("plain", "5")));
  const std::string page = read_file(options_.out_dir / "study.md");
  EXPECT_THAT(page, HasSubstr("| 2 | better | other |"));
  EXPECT_THAT(page, Not(HasSubstr("...")));
  EXPECT_FALSE(metrics().contains("missing"));
  EXPECT_EQ(metrics()["outcome"], "completed");
  EXPECT_EQ(runs_of_halving(*options_.study, plan_trials(options_)), 11U);
  EXPECT_THAT(read_file(options_.junit), HasSubstr("skipped=\"5\""));

  const std::string whole = read_file(options_.out_dir / "metrics.json");
  EXPECT_EQ(merge_quietly(), 0);
  EXPECT_EQ(read_file(options_.out_dir / "metrics.json"), whole);
}

TEST_F(Trials, ByHalvingCountRunsThatFailBeforeFigures) {
  options_.missions.clear();
  options_.study = halving_study();
  options_.study->halving = StudyHalving{2, 1, {"map.coverage", ""}, ""};
  StudyLimit limit;  // plain has the least coverage, and breaks it with seed 5
  limit.limit = parse_limit("map.coverage >= 0.505");
  limit.rigs = {"plain"};
  options_.study->limits = {limit};
  options_.seeds = {5, 6, 7};
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_trials(options_), 0) << "a rig that has dropped out is not judged";
  EXPECT_THAT(read_file(options_.junit), HasSubstr("failures=\"0\""));
  for (const json& line : metrics()["requirements"]) {
    EXPECT_EQ(line["pass"], true) << line;
  }
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("| 2 | other, better | plain |"));
}

TEST_F(Trials, ByHalvingAreMadeInShardsARoundAtATime) {
  options_.missions.clear();
  options_.study = halving_study();
  options_.seeds = {5, 6, 7, 8};
  const auto make_round = [&] {
    testing::internal::CaptureStdout();
    for (int i = 1; i <= 2; ++i) {
      EXPECT_EQ(run_shard(options_, {i, 2}), 0);
    }
    const int status = merge_trials(options_);
    testing::internal::GetCapturedStdout();
    return status;
  };
  EXPECT_EQ(make_round(), 1);
  EXPECT_GT(metrics()["missing"], 0) << "of a later round";
  EXPECT_EQ(metrics()["runs"], 4);
  EXPECT_EQ(make_round(), 1);
  EXPECT_EQ(make_round(), 0);
  EXPECT_EQ(metrics()["runs"], 11);
  EXPECT_FALSE(metrics().contains("missing"));
}

TEST_F(Trials, GoOnWithAStudy) {
  options_.missions.clear();
  options_.study = small_study();
  options_.seeds = {6};
  EXPECT_EQ(run_trials(options_), 0);
  const fs::path kept = options_.out_dir / "office" / "edges" / "none" / "6" / "metrics.json";
  const fs::path lost = options_.out_dir / "office" / "edges" / "1-degree" / "6" / "metrics.json";
  const auto first = fs::last_write_time(kept);
  fs::remove(lost);
  options_.seeds = {6, 7};
  EXPECT_EQ(run_trials(options_), 0);
  EXPECT_EQ(fs::last_write_time(kept), first);
  EXPECT_TRUE(fs::exists(lost));
  EXPECT_EQ(read_csv(options_.out_dir / "study.csv").rows.size(), 8U);
}

TEST_F(Trials, TellAllThatIsWrongWithTheMissionsOfAStudyAndWhere) {
  options_.missions.clear();
  options_.study = small_study();
  options_.set = {"d=4"};
  options_.resolve = [](const std::string&, const std::string&,
                        const std::vector<std::string>& set) -> ResolvedMission {
    std::vector<std::string> lines;
    for (const std::string& word : set) {
      if (!word.starts_with("seed")) {
        lines.push_back("--set " + word.substr(0, 1) + ": unknown key");
      }
    }
    throw ConfigError(lines);
  };
  EXPECT_EQ(message_of([&] { run_trials(options_); }),
            "--set d: unknown key\ns.yaml:3:9: b: unknown key\ns.yaml:5:9: a: unknown key");
  EXPECT_FALSE(fs::exists(options_.out_dir));
}

TEST_F(Trials, ReportARunThatBroke) {
  options_.seeds = {5, 9};
  EXPECT_EQ(run_trials(options_), 1);
  const CsvTable table = read_csv(options_.out_dir / "trials.csv");
  EXPECT_EQ(table.rows[1][table.column("verdict")], "error");
  EXPECT_EQ(table.rows[1][table.column("outcome")], "exit status 3");
  EXPECT_THAT(
      read_file(options_.junit),
      HasSubstr("<error message=\"exit status 3: no world\">exit status 3: no world</error>"));
}

TEST_F(Trials, StopTheirRunsWhenInterrupted) {
  options_.seeds = {5, 6, 7};
  options_.set = {"slow=yes"};
  options_.jobs = 2;
  std::thread user([this] {
    while (started() != "5\n6\n" && started() != "6\n5\n") {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // the traps are set
    std::raise(SIGINT);
  });
  EXPECT_EQ(run_trials(options_), 130);
  user.join();
  EXPECT_EQ(metrics()["outcome"], "interrupted");
  EXPECT_EQ(metrics()["runs"], 0);
  EXPECT_THAT(read_file(options_.junit), HasSubstr("skipped=\"3\""));
}

TEST_F(Trials, RefuseAFolderOfSomethingElse) {
  std::filesystem::create_directories(options_.out_dir);
  write_file(options_.out_dir / "note.txt", "mine");
  EXPECT_EQ(message_of([&] { run_trials(options_); }),
            options_.out_dir.string() +
                ": holds something else than trials; name another folder with --out");
  options_.missions = {"a/m.yaml", "b/m.yaml"};
  EXPECT_EQ(message_of([&] { run_trials(options_); }),
            "b/m.yaml: two missions are called m; give one of them another name");
  options_.missions = {"m.yaml"};
  options_.seeds = {4, 4};
  EXPECT_EQ(message_of([&] { run_trials(options_); }),
            (options_.out_dir / "m" / "4").string() +
                ": two runs would go there; a seed or a value is given twice");
}

TEST_F(Trials, ThatCannotGoOnEndTheirOwnRunsAloneAndSaySo) {
  run_as(R"(#!/bin/bash
dir=$5
mkdir -p "$dir"
for word in "$@"; do case $word in seed=*) seed=${word#seed=} ;; esac; done
if [ "$seed" = 4 ]; then
  trap 'touch "$dir/ended"; exit 130' INT
  touch "${dir%/*}/../waits"
  while true; do sleep 0.02; done
fi
until [ -e "${dir%/*}/../waits" ]; do sleep 0.02; done
mkdir "${dir%/*}/../../trials.csv.part"  # no table can be written from now on
echo '{"outcome": "completed"}' >"$dir/metrics.json"
)");
  options_.seeds = {3, 4};
  options_.jobs = 2;
  const pid_t bystander = ::fork();
  ASSERT_GE(bystander, 0);
  if (bystander == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    std::signal(SIGINT, SIG_DFL);
    ::pause();
    ::_exit(0);
  }
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_trials(options_), 3);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("trials.csv: cannot be created"));
  EXPECT_TRUE(std::filesystem::exists(options_.out_dir / "m" / "4" / "ended"));
  EXPECT_EQ(metrics()["outcome"], "failed");
  EXPECT_THAT(metrics()["fault"].get<std::string>(), HasSubstr("trials.csv: cannot be created"));
  EXPECT_EQ(::waitpid(bystander, nullptr, WNOHANG), 0);
  ::kill(bystander, SIGKILL);
  ::waitpid(bystander, nullptr, 0);
}

TEST_F(Trials, CallARunBrokenWhoseFiguresAreNone) {
  run_as(
      "#!/bin/bash\nmkdir -p \"$5\"\n"
      "echo '{\"outcome\": \"completed\", \"wall_s\": \"long\"}' >\"$5/metrics.json\"\n");
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_trials(options_), 1);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("exit status 0"));
}

}  // namespace
}  // namespace panoptes
