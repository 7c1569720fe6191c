// SPDX-License-Identifier: BSD-3-Clause
#include "hw/replay/tracked_truth.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/eval/trajectory.h"
#include "core/io/euroc_truth.h"
#include "core/io/tum.h"

namespace panoptes::hw {
namespace {

namespace fs = std::filesystem;

// The wheels err by a few percent of these: by 5 mm and a third of a degree.
constexpr double kLed_m = 0.1;
constexpr double kLed_rad = 0.1;
// Between poses farther apart than this a robot that speeds up by 0.6 m/s^2 may be 2 cm off the
// straight line.
constexpr Duration kLongestGap = std::chrono::milliseconds(500);

std::vector<TruePose> tracked_poses(const std::vector<TumPose>& poses, Duration epoch) {
  std::vector<TruePose> tracked;
  for (const TumPose& pose : poses) {
    TruePose known;
    known.stamp = pose.stamp - epoch;
    known.T_scene_body = floor_pose(pose);
    tracked.push_back(known);
  }
  return tracked;
}

bool is_near(const Pose2& T_odom_a, const Pose2& T_odom_b) {
  const Pose2 way = T_odom_a.inverse() * T_odom_b;
  return way.position().norm() <= kLed_m && std::abs(way.theta_rad) <= kLed_rad;
}

// The observations from `first` to `last` lie within what was tracked; the wheels lead from these
// to those before and after. False where they go too far.
bool led_to_all(const std::vector<RecordedObservation>& observations, std::size_t first,
                std::size_t last, std::vector<TruePose>& poses) {
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const std::size_t known = std::clamp(i, first, last);
    const Pose2& T_odom_known = observations[known].odometry.T_odom_body;
    const Pose2& T_odom_here = observations[i].odometry.T_odom_body;
    if (i != known) {
      if (!is_near(T_odom_known, T_odom_here)) {
        return false;
      }
      poses[i].T_scene_body = poses[known].T_scene_body * (T_odom_known.inverse() * T_odom_here);
    }
  }
  return true;
}

int in_gaps(const std::vector<RecordedObservation>& observations,
            const std::vector<TruePose>& tracked) {
  return static_cast<int>(
      std::count_if(observations.begin(), observations.end(), [&](const RecordedObservation& seen) {
        const auto next =
            std::lower_bound(tracked.begin(), tracked.end(), seen.stamp,
                             [](const TruePose& pose, Time t) { return pose.stamp < t; });
        return next != tracked.begin() && next != tracked.end() && next->stamp != seen.stamp &&
               next->stamp - std::prev(next)->stamp > kLongestGap;
      }));
}

std::optional<RecordedTruth> tracked_truth(const fs::path& folder, Dataset& dataset) {
  const std::optional<std::vector<TumPose>> found = read_euroc_truth(
      folder.string(), [&](const std::string& file) { return read_part(folder / file); });
  if (!found) {
    return std::nullopt;
  }
  const std::string file = (folder / kEstimateFile).string();
  if (found->empty()) {
    throw ConfigError(file + ": holds no pose");
  }
  const std::vector<TruePose> tracked = tracked_poses(*found, dataset.epoch);
  const std::vector<RecordedObservation>& observations = dataset.observations;
  const auto is_before = [](const RecordedObservation& seen, Time t) { return seen.stamp < t; };
  const auto is_after = [](Time t, const RecordedObservation& seen) { return t < seen.stamp; };
  const auto first =
      std::lower_bound(observations.begin(), observations.end(), tracked.front().stamp, is_before) -
      observations.begin();
  const auto end =
      std::upper_bound(observations.begin(), observations.end(), tracked.back().stamp, is_after) -
      observations.begin();
  std::vector<TruePose> poses;
  for (const RecordedObservation& seen : observations) {
    TruePose pose;
    pose.stamp = seen.stamp;
    pose.T_scene_body = true_pose_at(tracked, seen.stamp);
    poses.push_back(pose);
  }
  if (first >= end || !led_to_all(observations, static_cast<std::size_t>(first),
                                  static_cast<std::size_t>(end) - 1, poses)) {
    dataset.warnings.push_back(fmt::format(
        "{}: tells of {:.2f} to {:.2f} s, the pictures go from {:.2f} to {:.2f} s and the robot "
        "moves meanwhile; nothing is compared with it: leave out the pictures before and after",
        file, to_seconds(tracked.front().stamp), to_seconds(tracked.back().stamp),
        to_seconds(observations.front().stamp), to_seconds(observations.back().stamp)));
    return std::nullopt;
  }
  if (const int count = in_gaps(observations, tracked); count > 0) {
    dataset.warnings.push_back(
        fmt::format("{}: has no pose for more than {} s around {} of {} frame sets; their true "
                    "poses are interpolated",
                    file, to_seconds(kLongestGap), count, observations.size()));
  }
  return RecordedTruth::of_poses(poses, file);
}

}  // namespace

std::optional<RecordedTruth> truth_of(const fs::path& folder, Dataset& dataset) {
  if (dataset.ours) {
    if (std::optional<RecordedTruth> exact = RecordedTruth::read(folder, dataset.epoch)) {
      return exact;
    }
  } else if (std::error_code ignored; fs::is_directory(folder / "mav0" / "truth0", ignored)) {
    dataset.warnings.push_back((folder / "mav0" / "truth0").string() +
                               ": is left out; it tells of the frame sets as they were recorded");
  }
  return tracked_truth(folder, dataset);
}

}  // namespace panoptes::hw
