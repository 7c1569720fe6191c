// SPDX-License-Identifier: BSD-3-Clause
#include "apps/report/figure_names.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <variant>

#include "core/base/text.h"
#include "core/config/fields.h"

namespace panoptes {
namespace {

// The words before each dot of a path, and after the last.
std::vector<std::string_view> parts(std::string_view path) {
  std::vector<std::string_view> all;
  while (true) {
    const std::size_t dot = path.find('.');
    all.push_back(path.substr(0, dot));
    if (dot == std::string_view::npos) {
      return all;
    }
    path.remove_prefix(dot + 1);
  }
}

bool is_among(const std::vector<std::string>& patterns, const std::string& path) {
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](const std::string& pattern) { return is_one_of(path, pattern); });
}

// With what each stage of a step took, and what there is of each number that is learned.
std::vector<std::string> with_families(std::vector<std::string> names) {
  for (const std::string stage :
       {"observe", "step", "rectifying", "odometry", "slam", "mapping", "planning"}) {
    for (const std::string of : {"mean", "p50", "p99", "max"}) {
      names.push_back("timing_ms." + stage + "." + of);
    }
    for (const std::string of : {"mean", "p99"}) {
      names.push_back("timing_cpu_ms." + stage + "." + of);
    }
  }
  for (const std::string learned :
       {"rig.*.yaw_correction_deg", "rig.*.pitch_correction_deg", "rig.*.roll_correction_deg",
        "rig.*.x_correction_m", "rig.*.y_correction_m", "rig.*.z_correction_m",
        "rig.*.clock_offset_s", "rig.*.centre_bearing_correction_deg", "wheels.radius_ratio",
        "wheels.base"}) {
    for (const std::string of : {"", "_sigma", "_error"}) {
      names.push_back(learned + of);
    }
  }
  return names;
}

// The same with the cameras that there are.
std::vector<std::string> with_cameras(const std::vector<std::string>& cameras) {
  std::vector<std::string> names;
  for (const std::string& name : figure_names()) {
    const bool of_cameras = name.starts_with("rig.") || name.find("cameras.*") != std::string::npos;
    const std::size_t any = of_cameras ? name.find('*') : std::string::npos;
    if (any == std::string::npos) {
      names.push_back(name);
      continue;
    }
    for (const std::string& camera : cameras) {
      names.push_back(name.substr(0, any) + camera + name.substr(any + 1));
    }
  }
  return names;
}

bool is_word(const std::string& figure) {
  const std::array<std::string_view, 7> kWords{"schema",  "command", "version",   "mission",
                                               "outcome", "fault",   "end_reason"};
  return std::find(kWords.begin(), kWords.end(), figure) != kWords.end() ||
         is_one_of(figure, "goals.*.why");
}

}  // namespace

const std::vector<std::string>& figure_names() {
  static const std::vector<std::string> kNames = with_families({
      "schema",
      "command",
      "version",
      "seed",
      "mission",
      "outcome",
      "end_reason",
      "fault",
      "start_unix_ns",
      "run_s",
      "wall_s",
      "cpu_s",
      "real_time_factor",
      "peak_memory_mb",
      "frames",
      "keyframes",
      "distance_m",
      "replay.commands_diverged_at_s",
      "collisions",
      "collisions_while_stopped",
      "min_clearance_m",
      "stuck_s",
      "T_scene_map.x_m",
      "T_scene_map.y_m",
      "T_scene_map.theta_deg",
      "trajectory.ate_rmse_m",
      "trajectory.ate_max_m",
      "trajectory.ate_start_aligned_m",
      "trajectory.odometry_ate_rmse_m",
      "odometry.error_percent",
      "odometry.heading_error_deg",
      "checkpoints.count",
      "checkpoints.error_mean_m",
      "checkpoints.error_max_m",
      "edges.spins.count",
      "edges.spins.heading_bias_deg_per_m",
      "edges.spins.heading_bias_percent_of_turn",
      "edges.spins.heading_rms_deg",
      "edges.spins.position_rms_m",
      "edges.spins.nees",
      "edges.driving.count",
      "edges.driving.heading_bias_deg_per_m",
      "edges.driving.heading_bias_percent_of_turn",
      "edges.driving.heading_rms_deg",
      "edges.driving.position_rms_m",
      "edges.driving.nees",
      "platform_truth.cameras.*.roll_error_deg",
      "platform_truth.cameras.*.pitch_error_deg",
      "platform_truth.cameras.*.yaw_error_deg",
      "platform_truth.cameras.*.x_error_m",
      "platform_truth.cameras.*.y_error_m",
      "platform_truth.cameras.*.z_error_m",
      "platform_truth.cameras.*.focal_error_percent",
      "platform_truth.cameras.*.centre_error_px.0",
      "platform_truth.cameras.*.centre_error_px.1",
      "platform_truth.cameras.*.distortion_error",
      "platform_truth.cameras.*.clock_error_s",
      "platform_truth.wheels.radius_error_percent",
      "platform_truth.wheels.radius_ratio_error_percent",
      "platform_truth.wheels.base_error_percent",
      "loops.accepted",
      "loops.correct",
      "loops.false",
      "loops.same_heading",
      "loops.opposite_heading",
      "loops.other_heading",
      "loops.revisits_same",
      "loops.revisits_opposite",
      "loops.recall_same",
      "loops.recall_opposite",
      "loops.pose_error.same.median_m",
      "loops.pose_error.same.p95_m",
      "loops.pose_error.same.median_deg",
      "loops.pose_error.same.p95_deg",
      "loops.pose_error.opposite.median_m",
      "loops.pose_error.opposite.p95_m",
      "loops.pose_error.opposite.median_deg",
      "loops.pose_error.opposite.p95_deg",
      "places.*.*.*.recall",
      "places.*.*.*.recall_same",
      "places.*.*.*.recall_opposite",
      "map.cell_m",
      "map.radius_m",
      "map.reachable_m2",
      "map.mapped_free_m2",
      "map.coverage",
      "map.free_iou",
      "map.free_precision",
      "map.obstacle_recall",
      "map.leaked_m2",
      "map.leaked_share",
      "goals.*.x_m",
      "goals.*.y_m",
      "goals.*.reached",
      "goals.*.refused",
      "goals.*.why",
      "goals.*.began_s",
      "goals.*.time_s",
      "goals.*.moved_m",
      "goals.*.path_m",
      "goals.*.shortest_m",
      "goals.*.true_error_m",
      "exploration.t50_s",
      "exploration.t90_s",
      "exploration.t97_s",
      "exploration.end_delay_s",
      "cameras.*.missing",
      "cameras.*.late",
      "cameras.*.frozen",
      "cameras.*.dark",
      "cameras.*.saturated",
      "cameras.*.covered",
      "cameras.*.lost_s",
      "devices.*.*",
      "rig.*.centre_bearing_error_deg",
      "rig.*.position_error_m",
      "rig.*.error_chi2",
      "rig.*.error_freedom",
      "rig.*.error_inside_95",
      "rig.*.knocks",
      "rig.*.knocked_s",
  });
  return kNames;
}

bool is_one_of(std::string_view path, std::string_view pattern) {
  const std::vector<std::string_view> words = parts(path);
  const std::vector<std::string_view> wanted = parts(pattern);
  return std::equal(words.begin(), words.end(), wanted.begin(), wanted.end(),
                    [](std::string_view word, std::string_view want) {
                      return !word.empty() && (want == "*" || word == want);
                    });
}

bool is_calibration_figure(const std::string& path) {
  static const std::vector<std::string> kNames{
      "T_body_reference.rotation_error_deg",
      "T_body_reference.translation_error_m",
      "T_body_reference.translation_direction_error_deg",
      "T_body_reference.error.*",
      "cameras.*.T_body_camera.rotation_error_deg",
      "cameras.*.T_body_camera.translation_error_m",
      "cameras.*.T_body_camera.translation_direction_error_deg",
      "cameras.*.rotation_error_deg",
      "cameras.*.translation_error_m",
      "cameras.*.translation_direction_error_deg",
      "cameras.*.normalised_error",
      "cameras.*.rotation_deg",
      "cameras.*.true_rotation_deg",
      "cameras.*.time_offset_s",
      "cameras.*.time_offset_sigma_s",
      "cameras.*.time_offset_error_s",
      "cameras.*.shared_points",
      "cameras.*.observation_sigma_px.*",
      "cameras.*.described_points",
      "cameras.*.wanders.*",
      "wheels.way_ratio",
      "wheels.turn_ratio",
      "wheels.turn_rad_per_m",
      "reprojection_rms_px.*",
      "slide_rad",
      "observations",
      "inter_map_matches",
      "left_out",
      "points",
  };
  return is_among(kNames, path);
}

bool is_figure(const std::string& path) { return is_among(figure_names(), path); }

bool is_cost(const std::string& path) {
  constexpr std::array<std::string_view, 5> kCosts{"wall_s", "cpu_s", "real_time_factor",
                                                   "peak_memory_mb", "solve_s"};
  return path.starts_with("timing_") ||
         std::find(kCosts.begin(), kCosts.end(), path) != kCosts.end();
}

std::string requirement_fault(const Requirement& requirement,
                              const std::vector<std::string>& cameras) {
  const std::vector<std::string> names = with_cameras(cameras);
  const auto fault = [&](const std::string& what, const std::string& near) {
    return "requirement '" + requirement.text + "': " + what +
           (near.empty() ? "" : "; did you mean " + near + "?");
  };
  if (!is_among(names, requirement.figure)) {
    return fault("no run has a figure '" + requirement.figure + "'",
                 nearest_word(requirement.figure, names));
  }
  const auto* word = std::get_if<std::string>(&requirement.wanted);
  const auto* number = std::get_if<double>(&requirement.wanted);
  if (!is_word(requirement.figure) && (number == nullptr || !std::isfinite(*number))) {
    return fault("must be compared with a number", "");
  }
  const std::vector<std::string> words =
      requirement.figure == "outcome"
          ? std::vector<std::string>{"completed",        "collision", "stuck",      "device_lost",
                                     "goal_unreachable", "failed",    "interrupted"}
      : requirement.figure == "end_reason"
          ? std::vector<std::string>{"explored", "goals_done", "duration", "keyframes",
                                     "end_of_data"}
          : std::vector<std::string>{};
  if (!words.empty() &&
      (word == nullptr || std::find(words.begin(), words.end(), *word) == words.end())) {
    return fault("must be one of " + joined(words),
                 word == nullptr ? "" : nearest_word(*word, words));
  }
  return "";
}

}  // namespace panoptes
