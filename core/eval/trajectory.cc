// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/trajectory.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace panoptes {

Pose2 true_pose_at(const std::vector<TruePose>& poses, Time stamp) {
  PANOPTES_CHECK(!poses.empty(), "the truth has a pose");
  const auto next = std::lower_bound(poses.begin(), poses.end(), stamp,
                                     [](const TruePose& pose, Time t) { return pose.stamp < t; });
  if (next == poses.end()) {
    return poses.back().T_scene_body;
  }
  if (next == poses.begin() || next->stamp == stamp) {
    return next->T_scene_body;
  }
  const Pose2& from = std::prev(next)->T_scene_body;
  const Pose2& to = next->T_scene_body;
  const double share =
      to_seconds(stamp - std::prev(next)->stamp) / to_seconds(next->stamp - std::prev(next)->stamp);
  return {from.x_m + share * (to.x_m - from.x_m), from.y_m + share * (to.y_m - from.y_m),
          wrap_angle(from.theta_rad + share * wrap_angle(to.theta_rad - from.theta_rad))};
}

std::vector<Pose2> true_keyframes(const std::vector<KeyframePose>& keyframes, const Truth& truth) {
  std::vector<Pose2> poses;
  poses.reserve(keyframes.size());
  for (const KeyframePose& keyframe : keyframes) {
    poses.push_back(true_pose_at(truth.poses, keyframe.stamp));
  }
  return poses;
}

PathError path_error(const std::vector<Pose2>& T_scene_body,
                     const std::vector<Pose2>& true_T_scene_body) {
  PANOPTES_CHECK(T_scene_body.size() == true_T_scene_body.size(), "a truth for every pose");
  PathError error;
  if (T_scene_body.empty()) {
    return error;
  }
  double squares = 0;
  for (std::size_t i = 0; i < T_scene_body.size(); ++i) {
    const double away_m = (T_scene_body[i].position() - true_T_scene_body[i].position()).norm();
    squares += away_m * away_m;
    error.max_m = std::max(error.max_m, away_m);
  }
  error.rmse_m = std::sqrt(squares / static_cast<double>(T_scene_body.size()));
  return error;
}

double rotated_rmse_m(const std::vector<Pose2>& T_scene_body,
                      const std::vector<Pose2>& true_T_scene_body, const Vec2& start_scene) {
  PANOPTES_CHECK(T_scene_body.size() == true_T_scene_body.size(), "a truth for every pose");
  if (T_scene_body.empty()) {
    return 0;
  }
  double along = 0;
  double across = 0;
  for (std::size_t i = 0; i < T_scene_body.size(); ++i) {
    const Vec2 estimate = T_scene_body[i].position() - start_scene;
    const Vec2 truth = true_T_scene_body[i].position() - start_scene;
    along += estimate.dot(truth);
    across += estimate.x() * truth.y() - estimate.y() * truth.x();
  }
  const Pose2 about{0, 0, std::atan2(across, along)};
  double squares = 0;
  for (std::size_t i = 0; i < T_scene_body.size(); ++i) {
    const Vec2 estimate = about * Vec2(T_scene_body[i].position() - start_scene);
    squares += (estimate - (true_T_scene_body[i].position() - start_scene)).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(T_scene_body.size()));
}

OdometryError odometry_error(const std::vector<Pose2>& T_odom_body,
                             const std::vector<Pose2>& true_T_scene_body) {
  PANOPTES_CHECK(T_odom_body.size() == true_T_scene_body.size(), "a truth for every pose");
  PANOPTES_CHECK(!T_odom_body.empty(), "the odometry has a pose");
  OdometryError error;
  const Pose2 T_scene_odom = true_T_scene_body[0] * T_odom_body[0].inverse();
  double squares = 0;
  int stretches = 0;
  double way_m = 0;  // from `first` to here
  std::size_t first = 0;
  const auto step_m = [&](std::size_t i) {
    return (true_T_scene_body[i + 1].position() - true_T_scene_body[i].position()).norm();
  };
  for (std::size_t i = 0; i < T_odom_body.size(); ++i) {
    error.heading_rad =
        std::max(error.heading_rad, std::abs(wrap_angle((T_scene_odom * T_odom_body[i]).theta_rad -
                                                        true_T_scene_body[i].theta_rad)));
    way_m += i > 0 ? step_m(i - 1) : 0;
    while (way_m >= kOdometryStretch_m) {
      const Vec2 told = T_odom_body[first].inverse() * T_odom_body[i].position();
      const Vec2 truth = true_T_scene_body[first].inverse() * true_T_scene_body[i].position();
      squares += (told - truth).squaredNorm() / (way_m * way_m);
      ++stretches;
      way_m -= step_m(first++);
    }
  }
  if (stretches > 0) {
    error.share = std::sqrt(squares / stretches);
  }
  return error;
}

std::optional<Checkpoints> checkpoints(const std::vector<Pose2>& T_scene_body,
                                       const std::vector<Pose2>& true_T_scene_body,
                                       const Vec2& start_scene) {
  PANOPTES_CHECK(T_scene_body.size() == true_T_scene_body.size(), "a truth for every pose");
  constexpr double kFromStart_m = 1.0;
  // how far each candidate is from what was chosen; at first, from the start
  std::vector<double> away_m(T_scene_body.size(), -1);
  int candidates = 0;
  for (std::size_t i = 0; i < away_m.size(); ++i) {
    const double from_start_m = (true_T_scene_body[i].position() - start_scene).norm();
    if (from_start_m > kFromStart_m) {
      away_m[i] = from_start_m;
      ++candidates;
    }
  }
  if (candidates < kCheckpoints) {
    return std::nullopt;
  }
  Checkpoints result;
  for (int k = 0; k < kCheckpoints; ++k) {
    const auto chosen =
        static_cast<std::size_t>(std::max_element(away_m.begin(), away_m.end()) - away_m.begin());
    result.keyframes.push_back(static_cast<int>(chosen));
    const Vec2 p_scene = true_T_scene_body[chosen].position();
    const double error_m = (T_scene_body[chosen].position() - p_scene).norm();
    result.error_mean_m += error_m / kCheckpoints;
    result.error_max_m = std::max(result.error_max_m, error_m);
    for (std::size_t i = 0; i < away_m.size(); ++i) {
      const double d_m = (true_T_scene_body[i].position() - p_scene).norm();
      if (away_m[i] >= 0) {
        away_m[i] = k == 0 ? d_m : std::min(away_m[i], d_m);
      }
    }
    away_m[chosen] = -1;  // never twice, even among keyframes at one place
  }
  return result;
}

}  // namespace panoptes
