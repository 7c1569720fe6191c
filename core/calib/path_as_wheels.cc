// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/path_as_wheels.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>

#include "core/base/median.h"

namespace panoptes {
namespace {

struct StampedBody {
  Time stamp;
  Pose2 T_odom_body;
};

std::vector<StampedBody> body_path(const std::vector<StampedCamera>& path,
                                   const RigCamera& believed, double map_metre_m) {
  const Pose3& first = path.front().T_map_camera;
  const Vec3 up_map =
      first.rotation * (believed.T_body_camera.rotation.conjugate() * Vec3::UnitZ());
  Turning turning = turning_of(path);
  if (turning.axis_map.dot(up_map) < 0) {
    turning = turning.reversed();
  }
  const Eigen::Quaterniond R_level_map =
      Eigen::Quaterniond::FromTwoVectors(turning.axis_map, Vec3::UnitZ());
  const Vec3 ahead_level =
      R_level_map *
      (first.rotation * (believed.T_body_camera.rotation.conjugate() * Vec3::UnitX()));
  const double heading_rad = std::atan2(ahead_level.y(), ahead_level.x());
  const Vec2 camera_body = believed.T_body_camera.translation.head<2>();
  std::vector<StampedBody> out;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec2 camera_level =
        map_metre_m * (R_level_map * path[i].T_map_camera.translation).head<2>();
    const double theta_rad = heading_rad + turning.angle_rad[i];
    const Vec2 at = camera_level - Eigen::Rotation2Dd(theta_rad) * camera_body;
    out.push_back(
        {path[i].stamp - from_seconds(believed.clock_offset_s), {at.x(), at.y(), theta_rad}});
  }
  const Pose2 T_odom_level = out.front().T_odom_body.inverse();
  for (StampedBody& at : out) {
    at.T_odom_body = T_odom_level * at.T_odom_body;
  }
  return out;
}

Duration longest_step(const std::vector<StampedBody>& path) {
  constexpr int kPeriods = 4;
  std::vector<double> steps_s;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    steps_s.push_back(to_seconds(path[i + 1].stamp - path[i].stamp));
  }
  return from_seconds(steps_s.empty() ? 0 : kPeriods * median(std::move(steps_s)));
}

/// On the line that joins two poses, which are as near as pictures.
Odometry between(const StampedBody& before, const StampedBody& after, Time at) {
  const Pose2 moved = before.T_odom_body.inverse() * after.T_odom_body;
  const double step_s = to_seconds(after.stamp - before.stamp);
  const double share = to_seconds(at - before.stamp) / step_s;
  const Vec2 way = share * moved.position();
  return {before.T_odom_body * Pose2{way.x(), way.y(), share * moved.theta_rad},
          {moved.x_m / step_s, moved.theta_rad / step_s}};
}

}  // namespace

WheelReadings path_as_wheels(const std::vector<StampedCamera>& path, const RigCamera& believed,
                             double map_metre_m) {
  const auto poses =
      std::make_shared<const std::vector<StampedBody>>(body_path(path, believed, map_metre_m));
  const Duration longest = longest_step(*poses);
  return [poses, longest](Time at) -> std::optional<Odometry> {
    const auto after = std::upper_bound(
        poses->begin(), poses->end(), at,
        [](Time instant, const StampedBody& body) { return instant < body.stamp; });
    if (after == poses->begin() || after == poses->end() ||
        after->stamp - std::prev(after)->stamp > longest) {
      return std::nullopt;
    }
    return between(*std::prev(after), *after, at);
  };
}

}  // namespace panoptes
