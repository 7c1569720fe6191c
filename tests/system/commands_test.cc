// SPDX-License-Identifier: BSD-3-Clause
// The other subcommands, each once for real.
#include <algorithm>
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/camera/rig.h"
#include "core/io/csv.h"
#include "core/io/file.h"
#include "core/io/tum.h"
#include "tests/system/program.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

// The elements' names in order; fails where a tag is not closed by its own name or where & or <
// stand free.
std::vector<std::string> xml_elements(const std::string& text) {
  std::vector<std::string> names;
  std::vector<std::string> open;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '&') {
      const std::string entity = text.substr(at, text.find(';', at) + 1 - at);
      EXPECT_THAT(entity, testing::AnyOf("&amp;", "&lt;", "&gt;", "&quot;", "&apos;",
                                         testing::StartsWith("&#")));
      continue;
    }
    if (text[at] != '<') {
      continue;
    }
    const std::size_t end = text.find('>', at);
    if (end == std::string::npos) {
      ADD_FAILURE() << "a tag does not end";
      return names;
    }
    const std::string tag = text.substr(at + 1, end - at - 1);
    EXPECT_EQ(tag.find('<'), std::string::npos) << tag;
    if (tag.front() == '/') {
      EXPECT_FALSE(open.empty() || open.back() != tag.substr(1)) << tag;
      open.pop_back();
    } else if (tag.front() != '?') {
      names.push_back(tag.substr(0, tag.find_first_of(" /")));
      if (tag.back() != '/') {
        open.push_back(names.back());
      }
    }
    if (open.empty() && tag.front() == '/') {
      EXPECT_EQ(text.find_first_not_of(" \n", end + 1), std::string::npos);
    }
    at = tag.front() == '/' || tag.find('&') == std::string::npos ? end : at;
  }
  EXPECT_TRUE(open.empty());
  return names;
}

class Commands : public SystemTest {};

TEST_F(Commands, ExploreStartsFromWhatARunHasLearnedOfItsRig) {
  const std::vector<std::string> wrong{
      "--seed",     "1",
      "--duration", "12",
      "--set",      "require=[]",
      "--set",      "platform.mounting_error={sigma_deg: 1, sigma_m: 0.01}"};
  ASSERT_EQ(explore(kOffice, "first", wrong).status, 0);
  const auto yaw_error_deg = [&](const std::string& run) {
    return std::abs(
        metrics(run)["platform_truth"]["cameras"]["back"]["yaw_error_deg"].get<double>());
  };
  std::vector<std::string> again = wrong;
  again.insert(again.end(), {"--refined", "first"});
  const Said said = explore(kOffice, "second", again);
  ASSERT_EQ(said.status, 0) << said.err;
  EXPECT_LT(yaw_error_deg("second"), yaw_error_deg("first"));
  // what is true is as before
  const fs::path work = folder_ / "work";
  const auto true_x_m = [&](const std::string& run, const fs::path& believed) {
    const auto rig = read_settings<Rig>(believed.string());
    return rig.cameras.at("back").T_body_camera.translation.x() +
           metrics(run)["platform_truth"]["cameras"]["back"]["x_error_m"].get<double>();
  };
  constexpr double kRoundoff_m = 1e-12;
  EXPECT_NEAR(true_x_m("second", work / "first" / "rig_refined.yaml"),
              true_x_m("first", kScenes + "rigs/front-back-edges.yaml"), kRoundoff_m);
  // and it can be run again without the first run
  fs::remove_all(work / "first");
  ASSERT_EQ(explore((work / "second" / "mission.yaml").string(), "third", {}).status, 0);
  EXPECT_EQ(comparable(work / "second"), comparable(work / "third"));
}

TEST_F(Commands, RefusesRefinedRigsThatAreNotTheMissions) {
  const auto refused = [&](const std::string& run) {
    const Said said = explore(kOffice, "out", {"--refined", run});
    EXPECT_EQ(said.status, 2);
    return said.err;
  };
  EXPECT_THAT(refused("nowhere"), HasSubstr("nowhere: --refined: no such folder; name the "
                                            "directory that a run has left"));
  fs::create_directories(folder_ / "work" / "run");
  EXPECT_THAT(refused("run"), HasSubstr("run/rig_refined.yaml: --refined: no such file; name a "
                                        "run that has mapped"));
  write("run/rig_refined.yaml", read_file(kScenes + "rigs/left-right-floor.yaml"));
  EXPECT_THAT(refused("run"), HasSubstr("run/rig_refined.yaml: --refined: is of the cameras "));
  EXPECT_THAT(refused("run"), HasSubstr("; name a run with the mission's cameras"));
  const Said both = explore(kOffice, "out", {"--refined", "run", "--set", "rig=other.yaml"});
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(both.err, HasSubstr("--refined run: must not be given beside --set rig=other.yaml"));
  EXPECT_FALSE(fs::exists(folder_ / "work" / "out"));
}

TEST_F(Commands, TrialsRunResumeAndReport) {
  const std::vector<std::string> words{
      "trials",     kOffice,
      "--seeds",    "1-2",
      "--jobs",     "2",
      "--duration", "5",
      "--set",      "require=[\"collisions == 0\", \"map.coverage >= 0.9\"]",
      "--quiet",    "--out",
      "t",          "--junit",
      "t.xml"};
  EXPECT_EQ(panoptes(words).status, 1);  // coverage takes longer
  const fs::path work = folder_ / "work";
  const std::string table = read_file(work / "t" / "trials.csv");
  EXPECT_EQ(read_csv(work / "t" / "trials.csv").rows.size(), 2U);
  EXPECT_THAT(xml_elements(read_file(work / "t.xml")),
              ElementsAre("testsuite", "testcase", "failure", "testcase", "failure"));

  std::vector<fs::path> runs;
  for (const auto& entry : fs::recursive_directory_iterator(work / "t")) {
    if (entry.path().filename() == "steps.csv") {
      runs.push_back(entry.path().parent_path());
    }
  }
  ASSERT_EQ(runs.size(), 2U);
  std::sort(runs.begin(), runs.end());
  fs::remove(runs[1] / "metrics.json");
  const auto first = fs::last_write_time(runs[0] / "metrics.json");
  EXPECT_EQ(panoptes(words).status, 1);
  EXPECT_EQ(fs::last_write_time(runs[0] / "metrics.json"), first);  // kept
  EXPECT_TRUE(fs::exists(runs[1] / "metrics.json"));
  EXPECT_EQ(read_csv(work / "t" / "trials.csv").rows.size(), 2U);
}

TEST_F(Commands, TrialsCompareWaysToTellPlacesApartOnOneDrive) {
  // along the aisle between the desks, back, and along it again
  const std::vector<std::string> words{
      "trials",
      kOffice,
      "--seeds",
      "1",
      "--quiet",
      "--out",
      "p",
      "--set",
      "require=[]",
      "--set",
      "rig=" + kScenes + "rigs/front-back-floor-corners.yaml",
      "--set",
      "platform.nominal_rig=" + kScenes + "rigs/front-back-floor-corners.yaml",
      "--set",
      "platform.start={x_m: 4.95, y_m: 4.0, theta_deg: -90}",
      "--set",
      "drive={route: {waypoints: [{x_m: 4.95, y_m: 1.2}, {x_m: 4.95, y_m: 4.0}, "
      "{x_m: 4.95, y_m: 1.2}]}}",
      "--vary",
      "places.histogram=grey,two_dimensional",
      "--vary",
      "places.distance=emd,l2",
      "--vary",
      "places.pictures=front,front_back,four_corners"};
  const Said said = panoptes(words);
  EXPECT_EQ(said.status, 0) << said.out << said.err;
  EXPECT_THAT(said.out, HasSubstr("the thesis's own"));
  const fs::path out = folder_ / "work" / "p";
  EXPECT_EQ(read_csv(out / "trials.csv").rows.size(), 1U);
  const CsvTable study = read_csv(out / "places.csv");
  ASSERT_EQ(study.rows.size(), 12U);
  double best = 0;
  for (const auto& row : study.rows) {
    best = std::max(best, std::stod(row[study.column("recall")]));
  }
  EXPECT_GT(best, 0);
  EXPECT_TRUE(fs::exists(out / "places.png"));
  const auto run = nlohmann::json::parse(read_file(out / "explore-office" / "1" / "metrics.json"));
  EXPECT_EQ(run["places"]["grey"].size(), 2U);
  EXPECT_EQ(run["places"]["two_dimensional"]["emd"].size(), 3U);
}

TEST_F(Commands, TrialsRunAStudyAndHoldItsLimits) {
  const std::string text = "missions: [{name: office, mission: " + kOffice +
                           "}]\n"
                           "set: [until.duration_s=4, 'require=[]', platform.errors=none, "
                           "rig.cameras.*.sigma.rotation_rad=0.01]\n"
                           "rigs:\n"
                           "  - {name: front and back, rig: " +
                           kScenes +
                           "rigs/front-back-edges.yaml}\n"
                           "rungs:\n"
                           "  - {name: none}\n"
                           "  - {name: half a degree, set: "
                           "[platform.mounting_error.sigma_deg=0.5]}\n"
                           "limits:\n"
                           "  - {require: collisions == 0}\n";
  const std::string study = write("study.yaml", text);
  std::vector<std::string> words{"trials", "--study", study,   "--seeds", "1",
                                 "--jobs", "2",       "--out", "s",       "--quiet"};
  Said said = panoptes({"check", study});
  EXPECT_EQ(said.status, 0) << said.out << said.err;
  EXPECT_THAT(said.out, HasSubstr("ok (study)"));

  said = panoptes(words);
  EXPECT_EQ(said.status, 0) << said.out << said.err;
  EXPECT_THAT(said.out, HasSubstr("| rig | none | half a degree |\n"));
  const fs::path out = folder_ / "work" / "s";
  const CsvTable table = read_csv(out / "study.csv");
  ASSERT_EQ(table.rows.size(), 2U);
  const fs::path run = out / "office" / "front-and-back" / "none" / "1";
  EXPECT_THAT(read_file(run / "mission.yaml"), HasSubstr("rotation_rad: [0.01, 0.01, 0.01]"));
  const auto error_deg = [&](const char* rung) {
    const fs::path file = out / "office" / "front-and-back" / rung / "1" / "metrics.json";
    const auto m = nlohmann::json::parse(read_file(file));
    return m["platform_truth"]["cameras"]["front"]["yaw_error_deg"].get<double>();
  };
  EXPECT_EQ(error_deg("none"), 0);
  EXPECT_NE(error_deg("half-a-degree"), 0);

  const auto first = fs::last_write_time(run / "metrics.json");
  write("study.yaml", text + "  - {require: trajectory.ate_rmse_m < 0}\n");
  said = panoptes(words);
  EXPECT_EQ(said.status, 1);
  EXPECT_THAT(said.out, HasSubstr("trajectory.ate_rmse_m < 0, it is "));
  EXPECT_EQ(fs::last_write_time(run / "metrics.json"), first) << "it is not run again";

  write("study.yaml", text + "  - {require: loops.fals == 0}\n");
  said = panoptes(words);
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr("study.yaml:10:15: limits[1].require: limit 'loops.fals == 0': "
                                  "no run has a figure 'loops.fals'; did you mean loops.false?"));
  words.emplace_back(kOffice);
  said = panoptes(words);
  EXPECT_EQ(said.status, 2);
  EXPECT_THAT(said.err, HasSubstr("missions must not be given beside it"));
}

TEST_F(Commands, ServeKeepsTheTruthUntilItIsStopped) {
  const std::vector<std::string> words{"serve",      kOffice, "--quiet", "--port", "0",
                                       "--duration", "1",     "--out",   "timed"};
  Said said = panoptes(words);
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_THAT(said.out, StartsWith("a Pioneer (p3dx-sh) is at tcp:127.0.0.1:"));
  EXPECT_EQ(metrics("timed")["command"], "serve");
  EXPECT_EQ(metrics("timed")["outcome"], "completed");
  EXPECT_EQ(metrics("timed")["collisions"], 0);
  EXPECT_GT(metrics("timed")["start_unix_ns"], std::int64_t{1'600'000'000} * 1'000'000'000);
  const double run_s = metrics("timed")["run_s"];
  EXPECT_GE(run_s, 1);
  const std::vector<TumPose> poses = read_tum(folder_ / "work/timed/ground_truth.tum");
  EXPECT_GE(poses.size(), 15U);
  EXPECT_LE(run_s - to_seconds(poses.back().stamp), 1.0 / 15);

  const fs::path link = folder_ / "work/pioneer";
  said = panoptes({"serve", kOffice, "--quiet", "--link", link.string(), "--out", "stopped"},
                  {{}, {}, SIGINT, "stopped/ground_truth.tum"});
  EXPECT_EQ(said.status, 130);
  EXPECT_THAT(said.out, StartsWith("a Pioneer (p3dx-sh) is at serial:" + link.string()));
  EXPECT_EQ(metrics("stopped")["outcome"], "interrupted");
  EXPECT_FALSE(fs::exists(fs::symlink_status(link)));
}

TEST_F(Commands, DoctorFindsWhatIsNeeded) {
  const Said said = panoptes({"doctor"});
  EXPECT_EQ(said.status, 0) << said.out;
  EXPECT_THAT(said.out, StartsWith("ok      renderer"));
}

TEST_F(Commands, EverySceneThatShipsIsRight) {
  std::vector<std::string> words{"check"};
  std::size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kScenes)) {
    if (entry.path().extension() == ".yaml") {
      words.push_back(entry.path());
      ++files;
    }
  }
  const Said said = panoptes(words);
  EXPECT_EQ(said.status, 0) << said.out;
  EXPECT_EQ(static_cast<std::size_t>(std::count(said.out.begin(), said.out.end(), '\n')), files);
  EXPECT_EQ(said.err, "");
}

TEST_F(Commands, RenderShowsWhatEveryCameraSees) {
  const Said said = panoptes({"render", kOffice, "--pose", "5,4.4,90", "--out", "r"});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_EQ(said.out, "r/render.png\n");
  EXPECT_EQ(said.err, "");
  for (const char* name : {"back.png", "floor.png", "front.png", "render.png"}) {
    EXPECT_THAT(read_file(folder_ / "work" / "r" / name), StartsWith("\x89PNG")) << name;
  }
  const auto m = metrics("r");
  EXPECT_EQ(m["command"], "render");
  EXPECT_EQ(m["outcome"], "completed");
  EXPECT_GT(m["poses"][0]["clearance_m"], 0);
}

TEST_F(Commands, RenderLooksFromSeveralPlacesAndSaysWhereNoRobotCanStand) {
  const Said said = panoptes({"render", kOffice, "--pose", "5,4.4,90; 2.1,2,0", "--pose", "-30,2,0",
                              "--depth", "--labels", "--out", "r"});
  EXPECT_EQ(said.status, 0);
  EXPECT_EQ(said.out, "r/pose-1/render.png\nr/pose-2/render.png\nr/pose-3/render.png\n");
  EXPECT_THAT(said.err, StartsWith("--pose 2.1,2,0: the robot is inside desk-01; drawn all the "
                                   "same\n--pose -30,2,0: the robot is outside of the world, which "
                                   "reaches from ("));
  for (const char* name : {"front_depth.png", "floor_labels.png", "floor_floor.png"}) {
    EXPECT_THAT(read_file(folder_ / "work/r/pose-2" / name), StartsWith("\x89PNG")) << name;
  }
  EXPECT_EQ(metrics("r")["poses"][1]["fault"], "the robot is inside desk-01");
  const std::string things = read_file(folder_ / "work/r/pose-2/things.csv");
  EXPECT_THAT(things, StartsWith("#number, thing\n0,nothing\n1,"));
  EXPECT_THAT(things, HasSubstr(",desk-01\n"));
}

TEST_F(Commands, RigsThatNoNavigatorCouldUseAreLookedThroughAndRecorded) {
  const std::string rig =
      write("rig.yaml", "cameras: {side: {fov_deg: 80, at_m: [0, 0, 0.8], yaw_deg: 90}}\n");
  write("m.yaml", "rig: " + rig + "\nplatform: {kind: simulated, world: " + kScenes +
                      "worlds/office.yaml, start: {x_m: 4.95, y_m: 4}}\ndrive: none\n");
  const Said drawn = panoptes({"render", "m.yaml", "--pose", "5,5,45", "--out", "look"});
  EXPECT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_TRUE(fs::exists(folder_ / "work" / "look" / "side.png"));
  const Said recorded =
      panoptes({"record", "m.yaml", "--duration", "0.5", "--quiet", "--out", "kept"});
  EXPECT_EQ(recorded.status, 0) << recorded.err;
  EXPECT_EQ(metrics("kept")["keyframes"], 0);
  EXPECT_TRUE(fs::exists(folder_ / "work" / "kept" / "mav0" / "side" / "data.csv"));
  const Said explored = explore("m.yaml", "mapped", {});
  EXPECT_EQ(explored.status, 2);
  EXPECT_EQ(
      explored.err,
      "rig.yaml:1:1: rig: has no camera with the role loop_front or floor; SLAM in 'm' needs a "
      "camera for loops, whose role begins with loop_, and one for the floor\n");
}

TEST_F(Commands, RenderAsksForAPlaceInWords) {
  for (const char* pose : {"5,4.4", "5,4.4,x", "5,4.4,90,1", "", ";"}) {
    const Said said = panoptes({"render", kOffice, "--pose", pose, "--out", "r"});
    EXPECT_EQ(said.status, 2);
    EXPECT_THAT(said.err, testing::HasSubstr("must be x,y,theta_deg in scene, metres and degrees"));
  }
  for (const char* pose : {"1e9,1,1", "0,-1e19,0", "1e308,1e308,0"}) {
    const Said said = panoptes({"render", kOffice, "--pose", pose, "--out", "r"});
    EXPECT_EQ(said.status, 2);
    EXPECT_THAT(said.err, testing::HasSubstr("more than 10 km from the origin"));
  }
  EXPECT_FALSE(fs::exists(folder_ / "work" / "r"));
}

}  // namespace
}  // namespace panoptes
