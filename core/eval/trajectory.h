// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/eval/run_result.h"
#include "core/eval/truth.h"

namespace panoptes {

/// The true pose at an instant, between frame sets by a constant twist; held before the first and
/// after the last. There must be at least one pose.
Pose2 true_pose_at(const std::vector<TruePose>& poses, Time stamp);

/// The true poses at the keyframes' instants.
std::vector<Pose2> true_keyframes(const std::vector<KeyframePose>& keyframes, const Truth& truth);

/// Distances of positions from the truth, without any alignment.
struct PathError {
  double rmse_m = 0;
  double max_m = 0;
};
PathError path_error(const std::vector<Pose2>& T_scene_body,
                     const std::vector<Pose2>& true_T_scene_body);

/// The smallest rms of these distances that one rotation of all positions about `start_scene`
/// leaves.
double rotated_rmse_m(const std::vector<Pose2>& T_scene_body,
                      const std::vector<Pose2>& true_T_scene_body, const Vec2& start_scene);

/// How far the wheels alone are from the truth.
struct OdometryError {
  /// Of position, relative to the way: rms over all stretches of kOdometryStretch_m, each laid on
  /// the truth where it begins. None where the way is shorter.
  std::optional<double> share;
  double heading_rad = 0;  ///< the largest of the run, both laid on each other at its start
};
constexpr double kOdometryStretch_m = 1;

/// Of poses at the same instants, at least one.
OdometryError odometry_error(const std::vector<Pose2>& T_odom_body,
                             const std::vector<Pose2>& true_T_scene_body);

/// Keyframes far apart, at which the map's position is compared with the truth (thesis Table 6.1).
struct Checkpoints {
  std::vector<int> keyframes;
  double error_mean_m = 0;
  double error_max_m = 0;
};
constexpr int kCheckpoints = 8;

/// Eight keyframes by farthest-point sampling on true positions among those more than 1 m from the
/// start, beginning with the one farthest from it; of equals the earlier. Empty below eight.
std::optional<Checkpoints> checkpoints(const std::vector<Pose2>& T_scene_body,
                                       const std::vector<Pose2>& true_T_scene_body,
                                       const Vec2& start_scene);

}  // namespace panoptes
