// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/recorder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/report/figure_names.h"
#include "core/base/error.h"
#include "core/camera/rig.h"
#include "core/io/csv.h"
#include "core/io/graph_file.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"
#include "tests/support/scratch.h"

namespace panoptes {
namespace {

using nlohmann::json;
constexpr double kPi = std::numbers::pi;
constexpr double kRoundoff = 1e-9;

/// A drive twice around a rectangle in a room of 8 x 6 m with a table in its middle, the robot's
/// wheels drifting, the estimate 3 cm off, one right and one wrong closure.
struct MadeUpRun {
  Truth truth;
  RunResult result;
  std::vector<Observation> seen;
  std::vector<SlamStep> slam;
  std::vector<PilotStep> steps;

  MadeUpRun() {
    const auto layer = [](double cell_m, auto is_set) {
      TruthLayer made{cell_m,
                      {0, 0},
                      static_cast<int>(std::lround(8 / cell_m)),
                      static_cast<int>(std::lround(6 / cell_m)),
                      {}};
      for (int row = 0; row < made.rows; ++row) {
        for (int column = 0; column < made.columns; ++column) {
          made.cells.push_back(is_set((column + 0.5) * cell_m, (row + 0.5) * cell_m) ? 1 : 0);
        }
      }
      return made;
    };
    const auto solid = [](double x, double y) {
      return x < 0.1 || y < 0.1 || x > 7.9 || y > 5.9 || (x > 2 && x < 6 && y > 2.2 && y < 3.8);
    };
    truth.floor = layer(0.01, solid);
    truth.body = truth.floor;
    truth.seen = layer(0.05, [](double, double) { return true; });

    const Pose2 T_scene_map{1, 1, 0};
    const int sides_m[] = {6, 4, 6, 4};
    Pose2 T{1, 1, 0};
    Pose2 T_odom;
    int frame = 0;
    double since_keyframe_m = 1;
    for (int side = 0; side < 8; ++side) {
      for (int step_of_side = 0; step_of_side < 10 * sides_m[side % 4]; ++step_of_side) {
        const Time stamp(Duration(frame++ * std::int64_t{250'000'000}));
        truth.poses.push_back({stamp, T, {0.4, 0}, 0.5 - 0.001 * frame});
        Observation observation;
        observation.stamp = stamp;
        observation.pictures["front"].stamp = stamp;
        observation.odometry.T_odom_body = T_odom;
        SlamStep where;
        where.stamp = stamp;
        PilotStep step;
        where.T_map_body = T_scene_map.inverse() * T;
        step.command_body = {0.4, 0};
        step.state = PilotState::kDriving;
        step.reason = "to a frontier, 1.2 m2";
        step.goal_map = Vec2(2, 3);
        step.frontier_reachable = side < 6;
        if (since_keyframe_m > 0.45) {
          since_keyframe_m = 0;
          where.keyframe_made = static_cast<int>(result.keyframes.size());
          const Pose2 T_map = where.T_map_body;
          result.keyframes.push_back(
              {stamp, {T_map.x_m, T_map.y_m + 0.03, T_map.theta_rad}, T_odom});
          result.graph.T_map_node.push_back(result.keyframes.back().T_map_body);
        }
        seen.push_back(observation);
        slam.push_back(where);
        steps.push_back(step);
        T = T * Pose2{0.1, 0, 0};
        T_odom = T_odom * Pose2{0.1, 0, 0.0004};
        since_keyframe_m += 0.1;
        truth.path_m += 0.1;
      }
      T.theta_rad = wrap_angle(T.theta_rad + kPi / 2);
      T_odom.theta_rad = wrap_angle(T_odom.theta_rad + kPi / 2);
    }
    for (int i = 1; i < static_cast<int>(result.keyframes.size()); ++i) {
      result.graph.edges.push_back({i - 1, i, {0.5, 0, 0}, Mat3::Identity(), false});
    }
    const auto closure = [&](int recent, int earlier, bool accepted, std::size_t at) {
      ClosureReport report;
      report.recent = recent;
      report.earlier = earlier;
      report.accepted = accepted;
      report.information = Vec3(1e4, 1e4, 1e4).asDiagonal();
      report.verdict = accepted ? "accepted" : "diagonal 4.1 grey, over 1.5";
      slam[at].closures.push_back(report);
    };
    closure(45, 5, true, 220);   // the second time around: truly there
    closure(50, 20, true, 300);  // across the room
    closure(60, 22, false, 330);

    result.map.cell_m = 0.01;
    result.map.origin = {-1.5, -1.5};
    result.map.columns = 900;
    result.map.rows = 700;
    for (int row = 0; row < 700; ++row) {
      for (int column = 0; column < 900; ++column) {
        const Vec2 p = T_scene_map * result.map.centre(column, row);
        const bool inside = p.x() > 0.05 && p.y() > 0.05 && p.x() < 7.95 && p.y() < 5.95;
        const bool inside_table = p.x() > 2.05 && p.x() < 5.95 && p.y() > 2.25 && p.y() < 3.75;
        result.map.cells.push_back(!inside || inside_table ? Cell::kUnknown
                                   : solid(p.x(), p.y())   ? Cell::kOccupied
                                                           : Cell::kFree);
      }
    }
  }

  OccupancyMap part_of_map(double share) const {
    OccupancyMap part = result.map;
    for (std::size_t i = static_cast<std::size_t>(share * 700) * 900; i < part.cells.size(); ++i) {
      part.cells[i] = Cell::kUnknown;
    }
    return part;
  }
};

class RecorderTest : public ScratchTest {
 protected:
  RunReport record(const std::filesystem::path& out_dir, const std::optional<Truth>& truth,
                   std::vector<std::string> require = {}, RunEnd end = {"completed", "explored"},
                   bool judged = true) {
    std::filesystem::create_directories(out_dir);
    RunInfo info;
    info.judged = judged;
    info.version = "0.1.0";
    info.mission = "made-up";
    info.seed = 7;
    info.mission_yaml = "seed: 7\n";
    info.rig = believed_;
    info.body = Body();
    for (const std::string& line : require) {
      info.require.push_back(parse_requirement(line));
    }
    StageClock clock;
    Recorder recorder(out_dir, info, &clock);
    for (std::size_t i = 0; i < run_.seen.size(); ++i) {
      {
        const TimedStage stage(clock, "step");
        PilotStep step = run_.steps[i];
        step.goals = goals_;
        recorder.add(run_.seen[i], run_.slam[i], step);
      }
      if (recorder.snapshot_due(run_.seen[i].stamp)) {
        const double share = std::min(1.0, static_cast<double>(i) / 260);
        recorder.add_snapshot(run_.seen[i].stamp, run_.part_of_map(share));
      }
      clock.end_frame();
    }
    RunResult result = run_.result;
    result.rig = learned_;
    return recorder.write_report(truth, result, end);
  }
  json metrics(const std::filesystem::path& out_dir) {
    const json all = json::parse(read_file(out_dir / "metrics.json"));
    const json flat = all.flatten();
    for (const auto& [pointer, value] : flat.items()) {
      std::string path = pointer.substr(1);
      std::replace(path.begin(), path.end(), '/', '.');
      EXPECT_TRUE(value.is_null() || path.starts_with("requirements") || is_figure(path)) << path;
    }
    return all;
  }

  static const MadeUpRun run_;
  std::vector<GoalProgress> goals_;
  std::optional<Rig> believed_;
  std::optional<RigEstimate> learned_;
};
const MadeUpRun RecorderTest::run_;

TEST_F(RecorderTest, LeavesEveryFileOfTheRunDirectory) {
  const auto out = folder_ / "run";
  const RunReport report = record(out, run_.truth);
  EXPECT_EQ(report.exit_status, 0);
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(out)) {
    names.insert(entry.path().filename());
  }
  EXPECT_THAT(names,
              testing::ElementsAre("contacts.csv", "coverage.png", "errors.png", "exploration.csv",
                                   "graph.g2o", "ground_truth.tum", "keyframes.tum", "loops.csv",
                                   "map.pgm", "map.png", "map.yaml", "metrics.json", "mission.yaml",
                                   "odometry.tum", "steps.csv", "trajectory.tum"));
  EXPECT_EQ(read_file(out / "mission.yaml"), "# panoptes 0.1.0\nseed: 7\n");
  EXPECT_EQ(read_map_server(out / "map.yaml").cells, run_.result.map.cells);
  EXPECT_EQ(read_tum(out / "trajectory.tum").size(), run_.seen.size());
  EXPECT_EQ(read_tum(out / "keyframes.tum").size(), run_.result.keyframes.size());
  EXPECT_EQ(read_tum(out / "ground_truth.tum").size(), run_.seen.size());
  EXPECT_EQ(read_tum(out / "odometry.tum").size(), run_.seen.size());
  EXPECT_EQ(read_graph(out / "graph.g2o").graph.edges.size(), run_.result.graph.edges.size());
  EXPECT_EQ(read_csv(out / "steps.csv").rows.size(), run_.seen.size());
  const CsvTable loops = read_csv(out / "loops.csv");
  ASSERT_EQ(loops.rows.size(), 3U);
  EXPECT_EQ(loops.rows[0][loops.column("correct")], "1");
  EXPECT_EQ(loops.rows[1][loops.column("correct")], "0");
  EXPECT_EQ(loops.rows[2][loops.column("verdict")], "diagonal 4.1 grey, over 1.5");
}

TEST_F(RecorderTest, CarriesTheLastKeyframeOnAtEveryFrameSet) {
  const auto out = folder_ / "run";
  record(out, run_.truth);
  const std::vector<TumPose> trajectory = read_tum(out / "trajectory.tum");
  const std::vector<KeyframePose>& keyframes = run_.result.keyframes;
  ASSERT_EQ(trajectory.size(), run_.seen.size());
  std::size_t last = 0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    last += run_.slam[i].keyframe_made.value_or(0) > 0 ? 1 : 0;
    EXPECT_EQ(trajectory[i].stamp, run_.seen[i].stamp);
    const Pose2 expected = keyframes[last].T_map_body * keyframes[last].T_odom_body.inverse() *
                           run_.seen[i].odometry.T_odom_body;
    EXPECT_NEAR((floor_pose(trajectory[i]).position() - expected.position()).norm(), 0, kRoundoff)
        << i;
    EXPECT_NEAR(wrap_angle(floor_pose(trajectory[i]).theta_rad - expected.theta_rad), 0, kRoundoff);
  }
  EXPECT_NEAR(floor_pose(trajectory[5]).y_m, 0.03,
              0.001);  // the map's error, and a hair of the wheels'
}

TEST_F(RecorderTest, WritesTheFigures) {
  record(folder_ / "run", run_.truth);
  const json m = metrics(folder_ / "run");
  EXPECT_EQ(m["schema"], "panoptes.metrics/1");
  EXPECT_EQ(m["command"], "explore");
  EXPECT_EQ(m["outcome"], "completed");
  EXPECT_EQ(m["end_reason"], "explored");
  EXPECT_EQ(m["frames"], 400);
  EXPECT_NEAR(m["run_s"].get<double>(), 399 * 0.25, kRoundoff);
  EXPECT_NEAR(m["distance_m"].get<double>(), 40, kRoundoff);
  EXPECT_NEAR(m["T_scene_map"]["x_m"].get<double>(), 1, kRoundoff);
  EXPECT_NEAR(m["trajectory"]["ate_rmse_m"].get<double>(), 0.03, kRoundoff);
  EXPECT_NEAR(m["trajectory"]["ate_max_m"].get<double>(), 0.03, kRoundoff);
  EXPECT_GT(m["trajectory"]["odometry_ate_rmse_m"].get<double>(), 0.1);
  EXPECT_GT(m["odometry"]["error_percent"].get<double>(), 0.1);
  EXPECT_GT(m["odometry"]["heading_error_deg"].get<double>(), 0.01);
  EXPECT_EQ(m["checkpoints"]["count"], 8);
  EXPECT_NEAR(m["checkpoints"]["error_mean_m"].get<double>(), 0.03, kRoundoff);
  EXPECT_EQ(m["loops"]["accepted"], 2);
  EXPECT_EQ(m["loops"]["correct"], 1);
  EXPECT_EQ(m["loops"]["false"], 1);
  EXPECT_EQ(m["loops"]["recall_same"], 1.0);
  EXPECT_FALSE(m["loops"].contains("recall_opposite"));
  EXPECT_EQ(m["map"]["coverage"], 1.0);
  EXPECT_EQ(m["map"]["free_iou"], 1.0);
  EXPECT_EQ(m["map"]["leaked_m2"], 0.0);
  EXPECT_EQ(m["map"]["leaked_share"], 0.0);
  EXPECT_EQ(m["map"]["obstacle_recall"], 1.0);
  EXPECT_EQ(m["collisions"], 0);
  EXPECT_NEAR(m["min_clearance_m"].get<double>(), 0.1, kRoundoff);
  EXPECT_EQ(m["stuck_s"], 0.0);
  EXPECT_GT(m["exploration"]["t90_s"], m["exploration"]["t50_s"]);
  EXPECT_NEAR(m["exploration"]["end_delay_s"].get<double>(), 100 * 0.25, kRoundoff);
  EXPECT_TRUE(m["timing_ms"]["step"].contains("p99"));
  EXPECT_TRUE(m["timing_cpu_ms"]["step"].contains("mean"));
  EXPECT_TRUE(m["timing_cpu_ms"]["step"].contains("p99"));
  EXPECT_GT(m["peak_memory_mb"], 1);
}

// Along the first side of the rectangle, 6 m in 15 s; its last robot does not stand.
std::vector<GoalProgress> made_up_goals() {
  GoalProgress first;
  first.goal_map = {5.9, 0.1};
  first.state = GoalProgress::State::kReached;
  first.began = time_at(0);
  first.ended = time_at(14.75);
  GoalProgress second;
  second.goal_map = {3, 2};
  second.state = GoalProgress::State::kRefused;
  second.why = "something stands there";
  second.began = time_at(14.75);
  second.ended = time_at(20);
  GoalProgress third;
  third.goal_map = {1, 1};
  return {first, second, third};
}

TEST_F(RecorderTest, WritesWhatHasBecomeOfEachGoal) {
  goals_ = made_up_goals();
  Truth truth = run_.truth;
  truth.poses[59].twist_body = {};
  const RunReport report =
      record(folder_ / "run", truth, {"map.coverage > 2", "goals.0.reached == 1"},
             {"goal_unreachable", "goal 2: something stands there"});
  EXPECT_EQ(report.exit_status, 1);
  const json m = metrics(folder_ / "run");
  EXPECT_EQ(m["outcome"], "goal_unreachable");
  EXPECT_EQ(m["requirements"][0]["pass"], nullptr) << "nobody explores";
  EXPECT_EQ(m["requirements"][1]["pass"], true);
  const json& first = m["goals"][0];
  EXPECT_EQ(first["x_m"], 5.9);
  EXPECT_EQ(first["reached"], true);
  EXPECT_EQ(first["refused"], false);
  EXPECT_EQ(first["time_s"], 14.75);
  EXPECT_NEAR(first["moved_m"].get<double>(), 5.9, kRoundoff);
  EXPECT_EQ(first["path_m"], first["moved_m"]);
  EXPECT_NEAR(first["shortest_m"].get<double>(), std::hypot(5.9, 0.1), 0.03);
  EXPECT_NEAR(first["true_error_m"].get<double>(), 0.1, kRoundoff);
  const json& second = m["goals"][1];
  EXPECT_EQ(second["reached"], false);
  EXPECT_EQ(second["refused"], true);
  EXPECT_EQ(second["why"], "something stands there");
  EXPECT_FALSE(second.contains("path_m"));
  EXPECT_FALSE(second.contains("shortest_m")) << "it is in the table";
  EXPECT_EQ(m["goals"][2],
            json({{"x_m", 1.0}, {"y_m", 1.0}, {"reached", false}, {"refused", false}}));
  EXPECT_THAT(report.summary,
              testing::Contains(testing::StartsWith("goal 1 (5.90, 0.10): reached after 14.8 s")));
  EXPECT_THAT(report.summary, testing::Contains("goal 2 (3.00, 2.00): refused after 5.2 s: "
                                                "something stands there"));
  EXPECT_THAT(report.summary, testing::Contains("goal 3 (1.00, 1.00): not begun"));
  goals_.clear();
  record(folder_ / "without", truth);
  EXPECT_NE(read_file(folder_ / "run" / "map.png"), read_file(folder_ / "without" / "map.png"));
}

TEST_F(RecorderTest, ShowsTheMapWhereverAGoalIs) {
  const auto size_px = [this](const std::string& run) {
    return cv::imread((folder_ / run / "map.png").string()).size();
  };
  record(folder_ / "without", run_.truth);
  goals_ = {made_up_goals().front()};
  goals_.front().goal_map = {-9000, 40};
  record(folder_ / "far", run_.truth);
  EXPECT_EQ(size_px("far").width, size_px("without").width);
  goals_.front().goal_map = {3, 6};  // a metre outside of the room
  record(folder_ / "near", run_.truth);
  EXPECT_GT(size_px("near").height, size_px("without").height);
}

TEST_F(RecorderTest, AGoalThatTheTruthDoesNotBearOutIsNotReached) {
  goals_ = {made_up_goals().front()};
  const RunEnd end{"completed", "goals_done"};
  EXPECT_EQ(record(folder_ / "moves", run_.truth, {}, end).exit_status, 1);
  EXPECT_EQ(metrics(folder_ / "moves")["outcome"], "failed");
  EXPECT_EQ(metrics(folder_ / "moves")["goals"][0]["reached"], false) << "it drives by";
  EXPECT_EQ(record(folder_ / "unknown", std::nullopt, {}, end).exit_status, 0);
  const json m = metrics(folder_ / "unknown");
  EXPECT_EQ(m["goals"][0]["reached"], true) << "by what it says itself";
  EXPECT_FALSE(m["goals"][0].contains("true_error_m"));
}

TEST_F(RecorderTest, TellsHowTruthAndBeliefDiffer) {
  Truth truth = run_.truth;
  truth.rig = Rig();
  truth.rig->cameras["front"].intrinsics = pinhole(320, 240, deg_to_rad(80));
  truth.wheels = {1.01 * Body().wheel_radius_m, 1.01 * Body().wheel_radius_m, Body().wheel_base_m};
  believed_ = truth.rig;
  believed_->cameras["front"].intrinsics.cx_px -= 3;
  record(folder_ / "run", truth, {"platform_truth.cameras.front.centre_error_px.0 > 2.9"});
  const json m = metrics(folder_ / "run");
  const json& front = m["platform_truth"]["cameras"]["front"];
  EXPECT_NEAR(front["centre_error_px"][0].get<double>(), 3, kRoundoff);
  EXPECT_EQ(front["yaw_error_deg"], 0.0);
  EXPECT_NEAR(m["platform_truth"]["wheels"]["radius_error_percent"].get<double>(), 1, kRoundoff);
  EXPECT_EQ(m["requirements"][0]["pass"], true);
  record(folder_ / "without", run_.truth);
  EXPECT_FALSE(metrics(folder_ / "without").contains("platform_truth"));
}

TEST_F(RecorderTest, TellsWhatTheRunHasLearnedOfItsRig) {
  believed_ = Rig();
  for (const auto& [name, yaw_rad] : {std::pair{"front", 0.0}, {"back", 3.1}}) {
    RigCamera& camera = believed_->cameras[name];
    camera.roles = {std::string("loop_") + name};
    camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
    camera.T_body_camera = mounted_camera({0.2, 0, 0.5}, yaw_rad, 0);
  }
  learned_.emplace();
  learned_->believed = loop_cameras(*believed_);
  const int states = rig_states(2);
  learned_->state = RigState::Zero(states);
  learned_->state[kRotation + 2] = deg_to_rad(1);
  learned_->prior_covariance = 1e-4 * Eigen::MatrixXd::Identity(states, states);
  learned_->covariance = learned_->prior_covariance;
  learned_->covariance(kRotation + 2, kRotation + 2) = 1e-8;
  const int base = wheel_state(2) + kWheelBase;
  learned_->covariance(base, base) = 1e-8;
  Truth truth = run_.truth;
  truth.rig = believed_;
  truth.wheels = {Body().wheel_radius_m, Body().wheel_radius_m, 0.99 * Body().wheel_base_m};
  record(folder_ / "run", truth, {"rig.front.yaw_correction_deg_sigma < 0.01"});
  const json m = metrics(folder_ / "run");
  const json& front = m["rig"]["front"];
  EXPECT_NEAR(front["yaw_correction_deg"].get<double>(), 1, kRoundoff);
  EXPECT_NEAR(front["yaw_correction_deg_error"].get<double>(), 1, kRoundoff);
  EXPECT_EQ(front["error_freedom"], 1);
  EXPECT_EQ(front["error_inside_95"], 0);
  for (const char* key : {"pitch_correction_deg", "x_correction_m", "z_correction_m",
                          "clock_offset_s", "position_error_m"}) {
    EXPECT_FALSE(front.contains(key)) << key;
  }
  EXPECT_FALSE(m["rig"].contains("back"));  // of which nothing was learned
  EXPECT_NEAR(m["wheels"]["base_error"].get<double>(), 0.01 * Body().wheel_base_m, kRoundoff);
  EXPECT_FALSE(m["wheels"].contains("radius_ratio"));
  EXPECT_EQ(m["requirements"][0]["pass"], true);
  const Rig refined_rig = read_settings<Rig>((folder_ / "run" / "rig_refined.yaml").string());
  EXPECT_EQ(write_settings(refined_rig), write_settings(refined(*believed_, *learned_)));
  record(folder_ / "without", std::nullopt);
  const json without = metrics(folder_ / "without");
  EXPECT_FALSE(without["rig"]["front"].contains("yaw_correction_deg_error"));
  EXPECT_FALSE(without["rig"]["front"].contains("error_chi2"));
}

TEST_F(RecorderTest, InventsNothingWithoutTruth) {
  record(folder_ / "run", std::nullopt);
  const json m = metrics(folder_ / "run");
  for (const char* key :
       {"T_scene_map", "collisions", "min_clearance_m", "stuck_s", "trajectory", "checkpoints"}) {
    EXPECT_FALSE(m.contains(key)) << key;
  }
  EXPECT_FALSE(m["map"].contains("coverage"));
  EXPECT_FALSE(m["loops"].contains("false"));
  EXPECT_EQ(m["loops"]["accepted"], 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run" / "ground_truth.tum"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "run" / "errors.png"));
}

TEST_F(RecorderTest, SaysWhatTheDevicesCounted) {
  record(folder_ / "run", std::nullopt, {"devices.base.resyncs <= 2"},
         {.outcome = "completed",
          .end_reason = "explored",
          .devices = {{"base", {{"resyncs", 3}, {"lost_s", 0.5}}}, {"front", {{"dropped", 1}}}}});
  const json m = metrics(folder_ / "run");
  EXPECT_EQ(m["devices"], json::parse(R"({"base": {"lost_s": 0.5, "resyncs": 3},
                                          "front": {"dropped": 1}})"));
  EXPECT_EQ(m["requirements"][0]["pass"], false);
  record(folder_ / "none", std::nullopt);
  EXPECT_FALSE(metrics(folder_ / "none").contains("devices"));
}

TEST_F(RecorderTest, JudgesTheRequirements) {
  const auto report = record(folder_ / "run", run_.truth,
                             {"map.coverage >= 0.85", "loops.false == 0", "outcome == completed",
                              "goals == 3", "real_time_factor > 0"});
  EXPECT_EQ(report.exit_status, 1);
  const json lines = metrics(folder_ / "run")["requirements"];
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_EQ(lines[0]["pass"], true);
  EXPECT_EQ(lines[0]["value"], 1.0);
  EXPECT_EQ(lines[1]["pass"], false);
  EXPECT_EQ(lines[1]["value"], 1);
  EXPECT_EQ(lines[2]["pass"], true);
  EXPECT_EQ(lines[3]["pass"], false);
  EXPECT_FALSE(lines[3].contains("value"));
  EXPECT_EQ(lines[4]["pass"], true);
  EXPECT_THAT(report.summary, testing::Contains("broken: loops.false == 0, it is 1"));
  EXPECT_THAT(report.summary, testing::Contains("broken: goals == 3, no such figure"));
}

TEST_F(RecorderTest, AReplayThatDivergedIsNotJudgedByFiguresOfDriving) {
  const RunReport report = record(
      folder_ / "run", run_.truth,
      {"collisions == 0", "exploration.t90_s <= 100", "loops.accepted >= 0"},
      {.outcome = "completed", .end_reason = "end_of_data", .commands_diverged_at = time_at(1)});
  EXPECT_EQ(report.exit_status, 0);
  const json lines = metrics(folder_ / "run")["requirements"];
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0], json::parse(R"({"require": "collisions == 0", "pass": null})"));
  EXPECT_EQ(lines[1], json::parse(R"({"require": "exploration.t90_s <= 100", "pass": null})"));
  EXPECT_EQ(lines[2]["pass"], true);
  EXPECT_THAT(report.summary,
              testing::Contains("not judged: collisions == 0, exploration.t90_s <= 100 (figures "
                                "that driving decides)"));
  EXPECT_EQ(
      record(
          folder_ / "misspelt", run_.truth, {"map.covrage >= 0.5"},
          {.outcome = "completed", .end_reason = "end_of_data", .commands_diverged_at = time_at(1)})
          .exit_status,
      1);
}

TEST_F(RecorderTest, ARecordingIsNotJudgedByWhatTheWholeMissionRequires) {
  const RunReport report = record(folder_ / "run", run_.truth, {"map.coverage >= 2"},
                                  {.outcome = "completed", .end_reason = "duration"}, false);
  EXPECT_EQ(report.exit_status, 0);
  const json lines = metrics(folder_ / "run")["requirements"];
  EXPECT_TRUE(lines[0].at("pass").is_null());
  EXPECT_TRUE(lines[0].contains("value"));
  EXPECT_THAT(report.summary, testing::Contains("not judged: map.coverage >= 2 (it is not for "
                                                "what this command does)"));
}

TEST_F(RecorderTest, TellsWhatWasMissedWhileACameraWasLost) {
  Rig rig;
  for (const char* role : {"floor", "loop_left", "stereo_left"}) {
    rig.cameras[role].roles = {role};
    rig.cameras[role].intrinsics = pinhole(320, 240, deg_to_rad(80));
  }
  RunEnd end{"completed", "duration"};
  end.cameras = CameraHealth(rig).reports();
  for (auto& [name, report] : end.cameras) {
    report.dark = 15;
    report.lost = from_seconds(1);
  }
  const RunReport report = record(folder_ / "run", run_.truth, {}, end);
  for (const char* line :
       {"camera floor: lost for 1.0 s, pictures 15 dark; meanwhile no floor was mapped by it",
        "camera loop_left: lost for 1.0 s, pictures 15 dark; meanwhile no loops could be closed",
        "camera stereo_left: lost for 1.0 s, pictures 15 dark; meanwhile nobody needed it"}) {
    EXPECT_THAT(report.summary, testing::Contains(line));
  }
}

TEST_F(RecorderTest, CallsACollisionACollision) {
  Truth truth = run_.truth;
  truth.contacts.push_back({time_at(3), {2, 2}, "table", true});
  EXPECT_EQ(record(folder_ / "run", truth).exit_status, 1);
  const json m = metrics(folder_ / "run");
  EXPECT_EQ(m["outcome"], "collision");
  EXPECT_FALSE(m.contains("end_reason"));
  EXPECT_EQ(m["collisions"], 1);
}

TEST_F(RecorderTest, TellsWhereAndWhenWhatWasTouched) {
  Truth truth = run_.truth;
  truth.contacts = {{time_at(3), {2, 2.5}, "table", true}, {time_at(9.5), {6, 3}, "anna", false}};
  record(folder_ / "run", truth);
  EXPECT_EQ(read_file(folder_ / "run" / "contacts.csv"),
            "stamp_s,x_m,y_m,object,while_moving\n"
            "3,1,1.5,table,1\n"  // in map, which lies at (1, 1) in scene
            "9.5,5,2,anna,0\n");
  record(folder_ / "clear", run_.truth);
  EXPECT_NE(read_file(folder_ / "run" / "map.png"), read_file(folder_ / "clear" / "map.png"));
  EXPECT_EQ(read_csv(folder_ / "clear" / "contacts.csv").rows.size(), 0U);
  record(folder_ / "untold", std::nullopt);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "untold" / "contacts.csv"));
}

TEST_F(RecorderTest, KeepsWhatAnInterruptedRunDid) {
  EXPECT_EQ(record(folder_ / "run", run_.truth, {}, {"interrupted", ""}).exit_status, 130);
  EXPECT_EQ(metrics(folder_ / "run")["outcome"], "interrupted");
  EXPECT_EQ(record(folder_ / "lost", run_.truth, {}, {"device_lost", ""}).exit_status, 3);
}

TEST_F(RecorderTest, CallsARunThatEndsWithoutProgressStuck) {
  Truth truth = run_.truth;
  const TruePose last = truth.poses.back();
  for (int s = 1; s <= 61; ++s) {
    TruePose still = last;
    still.stamp = last.stamp + std::chrono::seconds(s);
    truth.poses.push_back(still);
  }
  EXPECT_EQ(record(folder_ / "run", truth).exit_status, 1);
  EXPECT_EQ(metrics(folder_ / "run")["outcome"], "stuck");
}

TEST_F(RecorderTest, LeavesNothingOfARunThatNeverBegan) {
  std::filesystem::create_directories(folder_ / "run");
  { const Recorder recorder(folder_ / "run", {}, nullptr); }
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "run"));
}

TEST_F(RecorderTest, KeepsTheInstantsOfABlindRunInOrder) {
  const auto out = folder_ / "run";
  std::filesystem::create_directories(out);
  RunInfo info;
  info.no_cameras = true;
  Recorder recorder(out, info, nullptr);
  for (const double t_s : {0.0, 0.1003, 0.1002, 0.1003, 0.2}) {
    Observation seen;
    seen.stamp = time_at(t_s);
    recorder.add(seen, {}, {});
  }
  recorder.write_report(std::nullopt, {}, {"completed", "duration"});
  EXPECT_EQ(read_tum(out / "odometry.tum").size(), 3U);  // else it throws
  EXPECT_EQ(read_csv(out / "steps.csv").rows.size(), 3U);
  for (const char* name : {"map.png", "coverage.png"}) {
    EXPECT_FALSE(std::filesystem::exists(out / name)) << "nothing was mapped: " << name;
  }
}

// Carried on by what slam takes of it, whatever the platform says.
TEST_F(RecorderTest, KeepsOdometryThatTellsNoNumberOrJumpsWhereItWas) {
  const auto out = folder_ / "run";
  std::filesystem::create_directories(out);
  Recorder recorder(out, RunInfo{}, nullptr);
  const double no_number = std::nan("");
  const auto add = [&](double t_s, double says_m, std::optional<double> told_m, bool maps) {
    Observation seen;
    seen.stamp = time_at(t_s);
    seen.pictures["front"].stamp = seen.stamp;
    seen.odometry.T_odom_body = {says_m, 0, 0};
    SlamStep at;
    if (told_m) {
      at.odometry.emplace().T_odom_body = {*told_m, 0, 0};
    } else if (maps) {
      at.passed_over = "the wheels jumped";
    }
    recorder.add(seen, at, {});
  };
  add(0, no_number, std::nullopt, true);
  add(1, 1, 1, true);
  add(2, no_number, std::nullopt, true);
  add(3, 50, std::nullopt, true);
  add(4, 51, 2, true);
  add(5, 3, std::nullopt, false);
  add(6, no_number, std::nullopt, false);
  recorder.write_report(std::nullopt, {}, {"device_lost", "odometry"});
  std::vector<double> x_m;
  for (const TumPose& pose : read_tum(out / "odometry.tum")) {
    x_m.push_back(pose.T_frame_body.translation.x());
  }
  EXPECT_THAT(x_m, testing::ElementsAre(0, 1, 1, 1, 2, 3, 3));
  EXPECT_EQ(read_csv(out / "steps.csv").rows.size(), x_m.size());
}

TEST_F(RecorderTest, TellsThatTheRobotStandsForPicturesDoNotCome) {
  const auto out = folder_ / "run";
  std::filesystem::create_directories(out);
  Recorder recorder(out, RunInfo{}, nullptr);
  PilotStep step;
  for (int i = 0; i < 6; ++i) {
    Observation seen;
    seen.stamp = time_at(0.1 * i);
    if (i < 2) {
      seen.pictures["front"].stamp = seen.stamp;
    }
    step.camera_lost = i >= 4;
    recorder.add(seen, {}, step);
  }
  recorder.write_report(std::nullopt, {}, {"device_lost", ""});
  EXPECT_EQ(read_csv(out / "steps.csv").rows.size(), 4U);
}

TEST_F(RecorderTest, SaysFailedFromTheEndUntilTheFiguresAreFound) {
  const auto out = folder_ / "run";
  std::filesystem::create_directories(out);
  Recorder recorder(out, RunInfo{}, nullptr);
  recorder.keep_ended();
  const auto before = nlohmann::json::parse(read_file(out / "metrics.json"));
  EXPECT_EQ(before["outcome"], "failed");
  EXPECT_EQ(before["fault"], "ended before its figures were found");
  recorder.write_report(std::nullopt, {}, {"completed", "duration"});
  const auto after = nlohmann::json::parse(read_file(out / "metrics.json"));
  EXPECT_EQ(after["outcome"], "completed");
  EXPECT_FALSE(after.contains("fault"));
}

TEST_F(RecorderTest, KeepsARunThatEndedAtOnce) {
  const auto out = folder_ / "run";
  std::filesystem::create_directories(out);
  Recorder recorder(out, {}, nullptr);
  EXPECT_EQ(recorder.write_report(std::nullopt, {}, {"interrupted", ""}).exit_status, 130);
  EXPECT_EQ(metrics(out)["keyframes"], 0);
}

TEST_F(RecorderTest, WritesTheSameBytesTwice) {
  record(folder_ / "a", run_.truth);
  record(folder_ / "b", run_.truth);
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "a")) {
    const auto name = entry.path().filename();
    if (name == "metrics.json") {
      json a = metrics(folder_ / "a");
      json b = metrics(folder_ / "b");
      for (const char* key : {"wall_s", "cpu_s", "real_time_factor", "peak_memory_mb", "timing_ms",
                              "timing_cpu_ms"}) {
        a.erase(key);
        b.erase(key);
      }
      EXPECT_EQ(a, b);
    } else {
      EXPECT_EQ(read_file(entry.path()), read_file(folder_ / "b" / name)) << name;
    }
  }
}

TEST_F(RecorderTest, OfAReplayThatWouldHaveDrivenElsewhereNoFigureSpeaksOfDriving) {
  const RunEnd end{"completed", "end_of_data", time_at(12.25)};
  const RunReport report = record(folder_ / "run", run_.truth, {"collisions == 0"}, end);
  EXPECT_EQ(report.exit_status, 0);  // nobody can say, so nobody does
  const json m = metrics(folder_ / "run");
  EXPECT_EQ(m["outcome"], "completed");
  EXPECT_EQ(m["end_reason"], "end_of_data");
  EXPECT_EQ(m["replay"], (json{{"commands_diverged_at_s", 12.25}}));
  for (const char* key : {"collisions", "collisions_while_stopped", "min_clearance_m", "stuck_s",
                          "goals", "exploration"}) {
    EXPECT_FALSE(m.contains(key)) << key;
  }
  EXPECT_TRUE(m.contains("trajectory"));
  EXPECT_TRUE(m["map"].contains("free_iou"));
  EXPECT_THAT(report.summary,
              testing::Contains("replayed: with these settings the robot would have driven "
                                "differently from 12.2 s on; no figures are given that driving "
                                "decides"));
}

}  // namespace
}  // namespace panoptes
