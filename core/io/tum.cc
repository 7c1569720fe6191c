// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/tum.h"

#include <array>
#include <cmath>
#include <sstream>
#include <string>

#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/io/digits.h"
#include "core/io/file.h"

namespace panoptes {

Pose2 floor_pose(const TumPose& pose) {
  const Vec3& t = pose.T_frame_body.translation;
  const Eigen::Quaterniond& q = pose.T_frame_body.rotation;
  return {t.x(), t.y(),
          std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z()))};
}

std::string tum_row(const TumPose& pose) {
  const Vec3& t = pose.T_frame_body.translation;
  const Eigen::Quaterniond& q = pose.T_frame_body.rotation;
  std::string line = seconds(pose.stamp);
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) {
    line += ' ';
    line += shortest(value);
  }
  return line + "\n";
}

void write_tum(const std::filesystem::path& path, const std::vector<TumPose>& poses) {
  AtomicFile file(path);
  for (const TumPose& pose : poses) {
    file.append(tum_row(pose));
  }
  file.commit();
}

std::vector<TumPose> read_tum(const std::filesystem::path& path) {
  return parse_tum(path.string(), read_file(path));
}

std::vector<TumPose> parse_tum(const std::string& name, std::string_view text) {
  std::istringstream lines{std::string(without_byte_order_mark(text))};
  std::vector<TumPose> poses;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word) || word.front() == '#') {
      continue;
    }
    const auto fault = [&](const std::string& what) {
      return IoError(name + ":" + std::to_string(number) + ": " + what);
    };
    const std::optional<Time> stamp = parse_seconds(word);
    std::array<double, 7> v{};
    bool whole = stamp.has_value();
    for (double& value : v) {
      const std::optional<double> number_read = words >> word ? parse_number(word) : std::nullopt;
      whole = whole && number_read;
      value = number_read.value_or(0);
    }
    if (!whole || words >> word) {
      throw fault("a pose is eight numbers, t x y z qx qy qz qw");
    }
    const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
    constexpr double kRounded = 1e-3;  // files with few digits; anything beyond is no rotation
    if (std::abs(rotation.norm() - 1) > kRounded) {
      throw fault("the quaternion has not length 1");
    }
    if (!poses.empty() && *stamp <= poses.back().stamp) {
      throw fault("the stamp is not later than the one before, " + seconds(poses.back().stamp));
    }
    poses.push_back({*stamp, {rotation.normalized(), Vec3(v[0], v[1], v[2])}});
  }
  return poses;
}

}  // namespace panoptes
