// SPDX-License-Identifier: BSD-3-Clause
#include "apps/evaluate/saved_run.h"

#include <algorithm>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "apps/evaluate/given_truth.h"
#include "apps/mission/mission.h"
#include "apps/serve/served_truth.h"
#include "core/base/error.h"
#include "core/io/file.h"
#include "core/io/tum.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kRoundoff = 1e-9;
constexpr std::int64_t kRun_unix_ns = 1'700'000'000'000'000'000;  // 2023-11-14 22:13:20 UTC
constexpr Duration kServedBefore = std::chrono::seconds(100);     // the run began
const Pose2 kStart_scene{2, 3, 0.5};
const std::vector<std::string> kRequire{"collisions == 0", "outcome == completed", "run_s > 1"};

Pose2 true_pose(double run_s) { return kStart_scene * Pose2{0.4 * run_s, 0, 0}; }

/// A robot that drives straight ahead for 8 s, its map 5 cm to the left of the truth, its wheels
/// 10 % short, and closes one loop that is wrong; nobody tells it the truth.
class SavedRunTest : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    run_ = folder_ / "run";
    served_ = folder_ / "served";
    RunInfo info;
    info.mission = "straight";
    info.version = "0.1.0";
    info.start_unix_ns = kRun_unix_ns;
    for (const std::string& line : kRequire) {
      info.require.push_back(parse_requirement(line));
    }
    fs::create_directories(run_);
    fs::create_directories(served_);
    Recorder recorder(run_, info, nullptr);
    RunResult result;
    for (int i = 0; i <= 80; ++i) {
      const double t_s = 0.1 * i;
      Observation seen;
      seen.stamp = time_at(t_s);
      seen.pictures["front"].stamp = seen.stamp;
      seen.odometry.T_odom_body = {0.36 * t_s, 0, 0};
      SlamStep at;
      PilotStep step;
      at.T_map_body = {0.4 * t_s, 0.05, 0};
      step.goal_map = Vec2(9, 0);
      if (i % 5 == 0) {
        result.keyframes.push_back({seen.stamp, at.T_map_body, seen.odometry.T_odom_body});
        result.graph.T_map_node.push_back(at.T_map_body);
      }
      if (i == 80) {
        ClosureReport closure;
        closure.recent = 12;
        closure.earlier = 3;
        closure.accepted = true;
        closure.information = Mat3::Identity() * 1e4;
        closure.verdict = "accepted, wrongly";
        at.closures = {closure, closure};
        at.closures[1].accepted = false;
        at.closures[1].T_earlier_recent.x_m = std::numeric_limits<double>::quiet_NaN();
        at.closures[1].verdict = "features: 3 of 9 agree, \"12\" needed";
      }
      recorder.add(seen, at, step);
    }
    for (int i = 1; i < static_cast<int>(result.keyframes.size()); ++i) {
      result.graph.edges.push_back({i - 1, i, {0.2, 0, 0}, Mat3::Identity(), false});
    }
    result.graph.edges.push_back({3, 12, {}, Mat3::Identity() * 1e4, true});
    result.map = {0.05, {-1, -1}, 40, 20, std::vector<Cell>(800, Cell::kFree)};
    recorder.write_report(std::nullopt, result, {.outcome = "completed", .end_reason = "explored"});
  }

  /// From before the run until after it, 15 times a second.
  Truth truth() const {
    Truth truth;
    truth.body = {0.05, {0, 0}, 200, 200, std::vector<std::uint8_t>(40000, 0)};
    truth.floor = truth.body;
    for (int i = 90 * 15; i <= 110 * 15; ++i) {
      TruePose pose;
      pose.stamp = time_at(i / 15.0);
      pose.T_scene_body = true_pose(std::clamp(i / 15.0 - 100, 0.0, 8.0));
      pose.clearance_m = i < 95 * 15 ? 0.01 : 0.3;
      truth.poses.push_back(pose);
    }
    return truth;
  }
  void serve(const Truth& truth) {
    fs::remove_all(served_);
    fs::create_directories(served_);
    ServedTruthWriter(served_, kRun_unix_ns - kServedBefore.count(), truth);
  }
  /// In scene, its stamps in seconds since `start_unix_ns`.
  fs::path trajectory(std::int64_t start_unix_ns) {
    fs::create_directories(folder_ / "lab");
    std::vector<TumPose> poses;
    for (int i = -10; i <= 90; ++i) {
      poses.push_back({Time(Duration(kRun_unix_ns - start_unix_ns) + from_seconds(0.1 * i)),
                       on_floor(true_pose(std::clamp(0.1 * i, 0.0, 8.0)))});
    }
    write_tum(folder_ / "lab" / "robot.tum", poses);
    return folder_ / "lab" / "robot.tum";
  }

  RunReport evaluate(const fs::path& truth) {
    warnings_.clear();
    const SavedRun left = read_run(run_);
    return report_with(left, truth_during(left.run, "run", read_given_truth(truth), warnings_));
  }
  json metrics() { return json::parse(read_file(run_ / "metrics.json")); }
  void change(const std::function<void(json&)>& by) {
    json m = metrics();
    by(m);
    write_file(run_ / "metrics.json", m.dump());
  }
  std::string fault(const fs::path& truth) {
    try {
      evaluate(truth);
    } catch (const ConfigError& error) {
      std::string what = error.what();
      for (std::size_t at; (at = what.find(folder_.string() + "/")) != std::string::npos;) {
        what.erase(at, folder_.string().size() + 1);
      }
      return what;
    }
    return "no error";
  }
  void replace(const fs::path& file, const std::string& what, const std::string& by) {
    std::string text = read_file(file);
    ASSERT_NE(text.find(what), std::string::npos);
    text.replace(text.find(what), what.size(), by);
    write_file(file, text);
  }

  fs::path run_;
  fs::path served_;
  std::vector<std::string> warnings_;
};

TEST_F(SavedRunTest, GetsTheFiguresThatNeedTheTruth) {
  const json before = metrics();
  EXPECT_FALSE(before.contains("trajectory"));
  EXPECT_EQ(before["requirements"][0]["pass"], false);
  serve(truth());
  const RunReport report = evaluate(served_);
  EXPECT_EQ(report.exit_status, 0);
  EXPECT_TRUE(warnings_.empty());
  const json m = metrics();
  EXPECT_NEAR(m["T_scene_map"]["x_m"], 2, kRoundoff);
  EXPECT_NEAR(m["T_scene_map"]["theta_deg"], rad_to_deg(0.5), kRoundoff);
  EXPECT_NEAR(m["trajectory"]["ate_rmse_m"], 0.05, kRoundoff);
  EXPECT_NEAR(m["checkpoints"]["error_max_m"], 0.05, kRoundoff);
  EXPECT_GT(m["trajectory"]["odometry_ate_rmse_m"], 0.1);
  EXPECT_NEAR(m["distance_m"], 3.2, kRoundoff);
  EXPECT_EQ(m["collisions"], 0);
  EXPECT_EQ(m["min_clearance_m"], 0.3);  // that of before the run does not count
  EXPECT_EQ(m["stuck_s"], 0);
  EXPECT_EQ(m["loops"]["false"], 1);
  EXPECT_EQ(m["edges"]["driving"]["count"], 16);
  EXPECT_NEAR(m["edges"]["driving"]["heading_rms_deg"], 0, kRoundoff);
  EXPECT_GT(m["map"]["reachable_m2"], 50);
  EXPECT_GT(m["map"]["coverage"], 0);
  EXPECT_TRUE(m["map"].contains("leaked_share"));
  EXPECT_FALSE(m["map"].contains("free_iou"));  // what a camera saw of the floor is not known
  EXPECT_FALSE(m["exploration"].contains("t50_s"));
  EXPECT_EQ(m["exploration"]["end_delay_s"], before["exploration"]["end_delay_s"]);
  EXPECT_EQ(m["wall_s"], before["wall_s"]);
  EXPECT_EQ(m["requirements"][0]["pass"], true);
  EXPECT_EQ(m["evaluated"], (json{{"outcome", "completed"}, {"end_reason", "explored"}}));
  const std::vector<TumPose> trajectory = read_tum(run_ / "ground_truth.tum");
  EXPECT_EQ(trajectory.front().stamp, time_at(0));
  EXPECT_EQ(trajectory.back().stamp, time_at(8));
  EXPECT_NEAR(trajectory.back().T_frame_body.translation.x(), 3.2, kRoundoff);
  const CsvTable loops = read_csv(run_ / "loops.csv");
  EXPECT_EQ(loops.rows[0][loops.column("correct")], "0");
  EXPECT_NEAR(loops.number(0, loops.column("true_x_m")), 1.8, kRoundoff);
  EXPECT_EQ(loops.rows[1][loops.column("x_m")], "");
  EXPECT_EQ(loops.rows[1][loops.column("verdict")], "features: 3 of 9 agree, \"12\" needed");
  EXPECT_TRUE(fs::exists(run_ / "errors.png"));
}

TEST_F(SavedRunTest, DoesNotJudgeWhatTheRunItselfDidNot) {
  for (const char* command : {"explore", "teleop", "record"}) {
    change([command](json& m) {
      m["command"] = command;
      for (json& line : m["requirements"]) {
        line["pass"] = nullptr;
      }
    });
    EXPECT_FALSE(read_run(run_).run.info.judged);
    serve(truth());
    const RunReport report = evaluate(served_);
    EXPECT_EQ(report.exit_status, 0) << command;
    for (const json& line : metrics()["requirements"]) {
      EXPECT_TRUE(line["pass"].is_null()) << command;
    }
    EXPECT_THAT(report.summary,
                testing::Contains("not judged: collisions == 0, outcome == completed, run_s > 1 "
                                  "(it is not for what this command does)"));
  }
}

TEST_F(SavedRunTest, ComparesTheTrueRobotWithWhatItsMissionBelieves) {
  Truth known = truth();
  known.wheels = {1.02 * Body().wheel_radius_m, 1.02 * Body().wheel_radius_m,
                  1.01 * Body().wheel_base_m};
  serve(known);
  evaluate(served_);
  EXPECT_FALSE(metrics().contains("platform_truth"));  // the run does not say what it believed
  const std::string mission = PANOPTES_SOURCE_DIR "/scenes/missions/explore-office.yaml";
  write_file(run_ / "mission.yaml", write_settings(load_mission<ExploreMission>(mission)));
  evaluate(served_);
  const json wheels = metrics()["platform_truth"]["wheels"];
  EXPECT_NEAR(wheels["radius_error_percent"], 2, kRoundoff);
  EXPECT_NEAR(wheels["radius_ratio_error_percent"], 0, kRoundoff);
  EXPECT_NEAR(wheels["base_error_percent"], 1, kRoundoff);
  EXPECT_FALSE(metrics()["platform_truth"].contains("cameras"));  // none were served
  serve(truth());
  evaluate(served_);
  EXPECT_FALSE(metrics().contains("platform_truth"));  // what an earlier truth said is gone
}

TEST_F(SavedRunTest, KnowsTheWheelsOfAKeyframeBetweenFrameSets) {
  serve(truth());
  const SavedRun whole = read_run(run_);
  replace(run_ / "keyframes.tum", "\n0.5 ", "\n0.45 ");
  const SavedRun between = read_run(run_);
  EXPECT_EQ(whole.run.result.keyframes[1].T_odom_body.x_m, 0.36 * 0.5);
  EXPECT_NEAR(between.run.result.keyframes[1].T_odom_body.x_m, 0.36 * 0.45, kRoundoff);
}

TEST_F(SavedRunTest, EvaluatedTwiceIsTheSame) {
  serve(truth());
  evaluate(served_);
  std::map<std::string, std::string> once;
  for (const auto& entry : fs::directory_iterator(run_)) {
    once[entry.path().filename()] = read_file(entry.path());
  }
  evaluate(served_);
  for (const auto& [name, bytes] : once) {
    EXPECT_TRUE(read_file(run_ / name) == bytes) << name;
  }
}

TEST_F(SavedRunTest, ACollisionIsOneForAsLongAsTheTruthSaysSo) {
  Truth hit = truth();
  hit.contacts = {{time_at(99), {0, 0}, "before", true},
                  {time_at(103), {3, 3}, "desk", true},
                  {time_at(104), {3, 3}, "walker", false},
                  {time_at(109), {0, 0}, "after", true}};
  serve(hit);
  const RunReport report = evaluate(served_);
  EXPECT_EQ(report.exit_status, 1);
  EXPECT_THAT(report.summary, testing::Contains("broken: collisions == 0, it is 1"));
  EXPECT_EQ(metrics()["outcome"], "collision");
  EXPECT_FALSE(metrics().contains("end_reason"));
  EXPECT_EQ(metrics()["collisions"], 1);
  EXPECT_EQ(metrics()["collisions_while_stopped"], 1);
  const CsvTable contacts = read_csv(run_ / "contacts.csv");
  ASSERT_EQ(contacts.rows.size(), 2U);
  EXPECT_NEAR(contacts.number(0, contacts.column("stamp_s")), 3, kRoundoff);
  const Vec2 p_map = kStart_scene.inverse() * Vec2(3, 3);
  EXPECT_NEAR(contacts.number(0, contacts.column("x_m")), p_map.x(), kRoundoff);
  EXPECT_NEAR(contacts.number(0, contacts.column("y_m")), p_map.y(), kRoundoff);
  serve(truth());
  EXPECT_EQ(evaluate(served_).exit_status, 0);
  EXPECT_EQ(metrics()["outcome"], "completed");
  EXPECT_EQ(metrics()["end_reason"], "explored");
  EXPECT_EQ(metrics()["collisions"], 0);
}

TEST_F(SavedRunTest, OfATrajectoryAloneNoContactsAreInvented) {
  serve(truth());
  evaluate(served_);
  EXPECT_TRUE(fs::exists(run_ / "contacts.csv"));
  for (const bool since_1970 : {true, false}) {
    const fs::path tum = trajectory(since_1970 ? 0 : kRun_unix_ns - 5'000'000'000);
    if (!since_1970) {
      write_file(folder_ / "lab" / "metrics.json",
                 "{\"start_unix_ns\": " + std::to_string(kRun_unix_ns - 5'000'000'000) + "}");
    }
    EXPECT_EQ(evaluate(tum).exit_status, 1);  // collisions == 0 cannot be shown
    const json m = metrics();
    EXPECT_NEAR(m["trajectory"]["ate_max_m"], 0.05, kRoundoff);
    EXPECT_EQ(m["outcome"], "completed");
    for (const char* key : {"collisions", "collisions_while_stopped", "min_clearance_m"}) {
      EXPECT_FALSE(m.contains(key)) << key;
    }
    EXPECT_FALSE(m["map"].contains("coverage"));
    EXPECT_FALSE(fs::exists(run_ / "contacts.csv"));
  }
}

TEST_F(SavedRunTest, RefusesClocksThatCannotMatch) {
  const fs::path tum = trajectory(kRun_unix_ns);  // seconds since the run's start, as it seems 1970
  EXPECT_EQ(fault(tum),
            "lab/robot.tum: tells of 1969-12-31 23:59:59.000 to 1970-01-01 00:00:09.000 UTC, but "
            "run needs it from 2023-11-14 22:13:20.000 to 2023-11-14 22:13:28.000 UTC; give the "
            "truth of that time, or one whose start_unix_ns is by the same clock");
  change([](json& m) { m.erase("start_unix_ns"); });
  EXPECT_EQ(fault(tum),
            "run/metrics.json: start_unix_ns: missing; the run's clock cannot be matched with the "
            "truth's: give a run of a robot that is real or served");
}

TEST_F(SavedRunTest, RefusesATruthThatEndsBeforeTheLastKeyframe) {
  Truth cut = truth();
  std::erase_if(cut.poses, [](const TruePose& pose) { return pose.stamp > time_at(107.9); });
  serve(cut);
  EXPECT_THAT(fault(served_), HasSubstr("served: tells of 2023-11-14 22:13:10.000 to 2023-11-14 "
                                        "22:13:27.866 UTC, but run needs it from"));
  EXPECT_FALSE(metrics().contains("evaluated"));
}

TEST_F(SavedRunTest, SaysWhereTheTruthHasGaps) {
  Truth holed = truth();
  std::erase_if(holed.poses, [](const TruePose& pose) {
    return (pose.stamp > time_at(102.2) && pose.stamp < time_at(103.2)) ||
           pose.stamp > time_at(108.1);
  });
  serve(holed);
  change([](json& m) { m["run_s"] = 12.5; });
  EXPECT_EQ(evaluate(served_).exit_status, 0);
  EXPECT_THAT(warnings_, ElementsAre(testing::EndsWith("served: ends 4.4 s before the run; nothing "
                                                       "is known of the rest"),
                                     testing::EndsWith("served: has no pose for more than 0.5 s "
                                                       "around 2 of 17 keyframes; their true poses "
                                                       "are interpolated")));
}

TEST_F(SavedRunTest, SaysWhichFileIsWrong) {
  const fs::path tum = trajectory(0);
  EXPECT_EQ(fault(folder_ / "none"), "none: is not there");
  EXPECT_EQ(fault(run_ / "map.yaml"),
            "run/map.yaml: is no truth; give a folder that panoptes serve has written, or a "
            "trajectory that ends in .tum");
  EXPECT_EQ(fault(run_), "run/ground_truth.tum: cannot be opened: No such file or directory");
  replace(run_ / "loops.csv", ",12,3,same", ",12,40,same");
  EXPECT_EQ(fault(tum), "run/loops.csv:2: earlier must be a keyframe of keyframes.tum, got 40");
  replace(run_ / "loops.csv", ",12,40,same", ",11,3,same");
  EXPECT_EQ(fault(tum),
            "run/loops.csv:2: is accepted, but graph.g2o has no edge between its keyframes");
  replace(run_ / "keyframes.tum", "\n8 ", "\n8.5 ");
  EXPECT_EQ(fault(tum),
            "run/keyframes.tum: the keyframe of 8.5 s is later than all of odometry.tum");
  replace(run_ / "steps.csv", "\n0.2,", "\n0.25,");
  EXPECT_EQ(fault(tum), "run/steps.csv:4: stamp_s must be 0.2, as in odometry.tum, got 0.25");
  replace(run_ / "odometry.tum", "0.3 ", "0.1 ");
  EXPECT_EQ(fault(tum), "run/odometry.tum:4: the stamp is not later than the one before, 0.2");
  write_file(tum, "1700000000.5 1 2 0 0 0 0 1\n1700000000.25 1 2 0 0 0 0 1\n");
  EXPECT_EQ(fault(tum), "run/odometry.tum:4: the stamp is not later than the one before, 0.2");
  change([](json& m) { m["run_s"] = "long"; });
  EXPECT_THAT(fault(tum), HasSubstr("run/metrics.json: is not of a run that drove and mapped: "));
  fs::remove(run_ / "metrics.json");
  EXPECT_EQ(fault(tum), "run: is no run directory; it holds no metrics.json");
}

TEST_F(SavedRunTest, WantsAPoseOfTheGraphForEveryKeyframe) {
  const fs::path tum = trajectory(0);
  replace(run_ / "graph.g2o", "VERTEX_SE2 16 ", "# ");
  replace(run_ / "graph.g2o", "EDGE_SE2 15 16 ", "# ");
  EXPECT_EQ(fault(tum), "run/graph.g2o: has 16 poses, but there are 17 in keyframes.tum");
}

TEST_F(SavedRunTest, RefusesATrajectoryWhoseTimeRunsBack) {
  const fs::path tum = trajectory(0);
  write_file(tum, "1700000000.5 1 2 0 0 0 0 1\n1700000000.25 1 2 0 0 0 0 1\n");
  EXPECT_EQ(fault(tum),
            "lab/robot.tum:2: the stamp is not later than the one before, 1700000000.5");
  write_file(tum, "# nothing\n");
  EXPECT_EQ(fault(tum), "lab/robot.tum: holds no whole pose");
}

}  // namespace
}  // namespace panoptes
