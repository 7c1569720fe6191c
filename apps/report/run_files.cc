// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/run_files.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "apps/draw/pictures.h"
#include "apps/recognition/recognition_table.h"
#include "core/config/fields.h"
#include "core/eval/loops.h"
#include "core/io/csv.h"
#include "core/io/digits.h"
#include "core/io/g2o.h"
#include "core/io/map_server.h"
#include "core/io/tum.h"
#include "core/motion/rig_estimate.h"

namespace panoptes {
namespace {

namespace fs = std::filesystem;

bool has_contacts(const FinishedRun& run, const RunFindings& f) {
  return f.known != nullptr && f.known->touches_known && !run.end.commands_diverged_at;
}

std::vector<Vec2> positions(const std::vector<Pose2>& poses) {
  std::vector<Vec2> all;
  all.reserve(poses.size());
  for (const Pose2& pose : poses) {
    all.push_back(pose.position());
  }
  return all;
}

std::vector<Pose2> true_trajectory_map(const RunFindings& f) {
  std::vector<Pose2> trajectory;
  if (f.known != nullptr) {
    const Pose2 T_map_scene = f.T_scene_map.inverse();
    for (const TruePose& pose : f.known->truth.poses) {
      trajectory.push_back(T_map_scene * pose.T_scene_body);
    }
  }
  return trajectory;
}

/// None where nobody knows of touches, and of a replay that would have driven elsewhere.
std::vector<TrueContact> known_contacts(const FinishedRun& run, const RunFindings& f) {
  return has_contacts(run, f) ? f.known->truth.contacts : std::vector<TrueContact>();
}

bool is_wrong(const RunFindings& f, const ClosureReport& closure) {
  return f.known != nullptr && !is_correct(closure, f.true_T_scene_body);
}

std::string name_of(const FinishedRun& run) {
  return fmt::format("{}, seed {}", run.info.mission, run.info.seed);
}

void write_trajectories(const fs::path& out_dir, const FinishedRun& run, const RunFindings& f) {
  std::vector<TumPose> keyframes;
  for (const KeyframePose& keyframe : run.result.keyframes) {
    keyframes.push_back({keyframe.stamp, on_floor(keyframe.T_map_body)});
  }
  std::vector<TumPose> trajectory;
  std::vector<TumPose> odometry;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const FinishedRun::Frame& frame = run.frames[i];
    odometry.push_back({frame.stamp, on_floor(frame.T_odom_body)});
    if (!f.T_map_frame.empty()) {
      trajectory.push_back({frame.stamp, on_floor(f.T_map_frame[i])});
    }
  }
  write_tum(out_dir / "keyframes.tum", keyframes);
  write_tum(out_dir / "trajectory.tum", trajectory);
  write_tum(out_dir / "odometry.tum", odometry);
}

/// The rig as the run has come to know it, where one is believed and something was learned of it.
void write_refined_rig(const fs::path& file, const FinishedRun& run) {
  if (run.info.rig && run.result.rig) {
    write_file(file, "# panoptes " + run.info.version + ", of " + name_of(run) + "\n" +
                         write_settings(refined(*run.info.rig, *run.result.rig)));
  }
}

void write_loops(const fs::path& file, const FinishedRun& run, const RunFindings& f) {
  CsvWriter loops_csv(file, {"stamp_s",
                             "recent",
                             "earlier",
                             "class",
                             "emd_grey",
                             "diagonal_max_grey",
                             "gate_sigma",
                             "feature_inliers",
                             "cameras_sigma",
                             "flow_heading_deg",
                             "contour_cost_m",
                             "contour_overlap",
                             "chi2_growth",
                             "x_m",
                             "y_m",
                             "theta_deg",
                             "true_x_m",
                             "true_y_m",
                             "true_theta_deg",
                             "accepted",
                             "correct",
                             "verdict"});
  const auto number = [&](double value) {  // a check that was not reached leaves no number
    if (std::isfinite(value)) {
      loops_csv << value;
    } else {
      loops_csv.skip();
    }
  };
  for (const auto& [stamp, closure] : run.closures) {
    loops_csv << stamp << closure.recent << closure.earlier << name_of(closure.heading);
    number(closure.emd_grey);
    number(closure.diagonal_max_grey);
    number(closure.gate_sigma);
    loops_csv << closure.feature_inliers;
    number(closure.cameras_sigma);
    number(rad_to_deg(closure.flow_heading_rad));
    number(closure.contour_cost_m);
    number(closure.contour_overlap);
    number(closure.chi2_growth);
    number(closure.T_earlier_recent.x_m);
    number(closure.T_earlier_recent.y_m);
    number(rad_to_deg(closure.T_earlier_recent.theta_rad));
    const auto [x, y, theta, correct] = true_loop_fields(f, closure);
    loops_csv << x << y << theta << (closure.accepted ? 1 : 0) << correct;
    loops_csv << closure.verdict;
    loops_csv.end_row();
  }
  loops_csv.finish();
}

cv::Mat drawn_map(const FinishedRun& run, const RunFindings& f) {
  MapPicture picture;
  picture.map = run.result.map;
  picture.estimate_map = f.T_map_frame;
  picture.truth_map = positions(true_trajectory_map(f));
  picture.title = fmt::format("{}: {:.1f} m2 of floor in {:.0f} s", name_of(run),
                              f.coverage.back().mapped_m2, to_seconds(run.last_step));
  for (const ClosureReport& closure : f.closures) {
    if (closure.accepted) {
      picture.loops.push_back({f.T_map_body[static_cast<std::size_t>(closure.earlier)].position(),
                               f.T_map_body[static_cast<std::size_t>(closure.recent)].position(),
                               is_wrong(f, closure)});
    }
  }
  for (const TrueContact& contact : known_contacts(run, f)) {
    picture.contacts.push_back({f.T_scene_map.inverse() * contact.p_scene, contact.while_moving});
  }
  for (const GoalFigures& goal : f.goals) {
    picture.goals.push_back({goal.goal_map, goal.reached   ? GoalMark::End::kReached
                                            : goal.refused ? GoalMark::End::kRefused
                                                           : GoalMark::End::kNeither});
  }
  return draw_map(picture);
}

cv::Mat drawn_coverage(const RunFindings& f) {
  const bool shares = f.covered_throughout();
  Plot plot;
  plot.title = shares ? "Share of the reachable floor that is mapped" : "Mapped floor";
  plot.x_label = "time [s]";
  plot.y_label = shares ? "coverage [%]" : "free floor [m2]";
  Curve curve{"coverage", kEstimateColour, {{0, 0}}};
  for (const CoverageSample& s : f.coverage) {
    curve.points.emplace_back(to_seconds(s.stamp), shares ? 100 * *s.coverage : s.mapped_m2);
  }
  plot.curves = {curve};
  if (shares) {
    plot.y_top = 100;
    plot.levels = {{50, "50 %"}, {90, "90 %"}, {97, "97 %"}};
  }
  return draw_plot(plot);
}

cv::Mat drawn_errors(const FinishedRun& run, const RunFindings& f) {
  Plot errors;
  errors.title = "Distance of keyframes from the truth";
  errors.x_label = "time [s]";
  errors.y_label = "error [cm]";
  Curve odometry_error{"wheels alone", kOdometryColour, {}};
  Curve estimate_error{"after relaxation", kEstimateColour, {}};
  for (std::size_t i = 0; i < f.T_scene_estimate.size(); ++i) {
    const double t_s = to_seconds(run.result.keyframes[i].stamp);
    const Vec2 p_scene = f.true_T_scene_body[i].position();
    estimate_error.points.emplace_back(t_s,
                                       100 * (f.T_scene_estimate[i].position() - p_scene).norm());
    odometry_error.points.emplace_back(t_s,
                                       100 * (f.T_scene_odometry[i].position() - p_scene).norm());
  }
  errors.curves = {odometry_error, estimate_error};
  bool any_wrong = false;
  for (const auto& [stamp, closure] : run.closures) {
    if (closure.accepted) {
      const bool wrong = is_wrong(f, closure);
      any_wrong = any_wrong || wrong;
      errors.ticks.push_back({to_seconds(stamp), wrong ? kWrongColour : kLoopColour});
    }
  }
  if (!errors.ticks.empty()) {
    errors.tick_names.emplace_back("loop closed", kLoopColour);
  }
  if (any_wrong) {
    errors.tick_names.emplace_back("wrongly", kWrongColour);
  }
  return draw_plot(errors);
}

}  // namespace

void write_ground_truth(const fs::path& out_dir, const RunFindings& findings) {
  if (findings.known == nullptr) {
    return;
  }
  const std::vector<Pose2> trajectory_map = true_trajectory_map(findings);
  std::vector<TumPose> poses;
  for (std::size_t i = 0; i < trajectory_map.size(); ++i) {
    poses.push_back({findings.known->truth.poses[i].stamp, on_floor(trajectory_map[i])});
  }
  write_tum(out_dir / "ground_truth.tum", poses);
}

void write_contacts(const fs::path& out_dir, const FinishedRun& run, const RunFindings& findings) {
  const fs::path file = out_dir / "contacts.csv";
  if (!has_contacts(run, findings)) {
    fs::remove(file);  // of an earlier truth
    return;
  }
  CsvWriter csv(file, {"stamp_s", "x_m", "y_m", "object", "while_moving"});
  for (const TrueContact& contact : findings.known->truth.contacts) {
    const Vec2 p_map = findings.T_scene_map.inverse() * contact.p_scene;
    csv << contact.stamp << p_map.x() << p_map.y() << contact.object
        << (contact.while_moving ? 1 : 0);
    csv.end_row();
  }
  csv.finish();
}

void write_exploration(const fs::path& out_dir, const RunFindings& findings) {
  CsvWriter csv(out_dir / "exploration.csv", {"stamp_s", "mapped_m2", "coverage"});
  for (const CoverageSample& s : findings.coverage) {
    csv << s.stamp << s.mapped_m2;
    if (s.coverage) {
      csv << *s.coverage;
    } else {
      csv.skip();
    }
    csv.end_row();
  }
  csv.finish();
}

std::array<std::string, kTrueLoopColumns.size()> true_loop_fields(const RunFindings& findings,
                                                                  const ClosureReport& closure) {
  if (findings.known == nullptr) {
    return {};
  }
  const std::vector<Pose2>& poses = findings.true_T_scene_body;
  const Pose2 T = poses[static_cast<std::size_t>(closure.earlier)].inverse() *
                  poses[static_cast<std::size_t>(closure.recent)];
  return {shortest(T.x_m), shortest(T.y_m), shortest(rad_to_deg(T.theta_rad)),
          is_correct(closure, poses) ? "1" : "0"};
}

void write_run_files(const fs::path& out_dir, const FinishedRun& run, const RunFindings& findings,
                     Faults& faults) {
  faults.attempt([&] { write_trajectories(out_dir, run, findings); });
  faults.attempt([&] { write_ground_truth(out_dir, findings); });
  faults.attempt([&] { write_contacts(out_dir, run, findings); });
  faults.attempt([&] { write_refined_rig(out_dir / kRefinedRig, run); });
  faults.attempt([&] { write_g2o(out_dir / "graph.g2o", run.result.graph); });
  faults.attempt([&] { write_loops(out_dir / "loops.csv", run, findings); });
  faults.attempt([&] { write_exploration(out_dir, findings); });
  faults.attempt([&] { write_map_server(out_dir / "map", run.result.map); });
}

std::vector<fs::path> draw_run(const fs::path& out_dir, const FinishedRun& run,
                               const RunFindings& findings,
                               const std::vector<RecognitionRow>& places, Faults& faults,
                               const std::function<bool()>& hurried) {
  std::vector<fs::path> pictures;
  const auto keep = [&](const char* name, const auto& draw) {
    if (hurried && hurried()) {
      return;
    }
    faults.attempt([&] {
      write_file(out_dir / name, png(draw()));
      pictures.push_back(out_dir / name);
    });
  };
  const bool nothing_known = run.info.no_cameras && findings.known == nullptr;
  if (!nothing_known) {
    keep("map.png", [&] { return drawn_map(run, findings); });
  }
  if (!places.empty()) {
    keep("places.png", [&] { return draw_recognition_table({{name_of(run), places}}); });
  }
  if (!nothing_known) {
    keep("coverage.png", [&] { return drawn_coverage(findings); });
  }
  if (findings.known != nullptr && !findings.T_map_body.empty()) {
    keep("errors.png", [&] { return drawn_errors(run, findings); });
  }
  return pictures;
}

}  // namespace panoptes
