// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/tum.h"

#include <array>
#include <cmath>
#include <sstream>
#include <string>

#include "core/base/error.h"
#include "core/io/digits.h"
#include "core/io/file.h"

namespace panoptes {

void write_tum(const std::filesystem::path& path, const std::vector<TumPose>& poses) {
  AtomicFile file(path);
  for (const TumPose& pose : poses) {
    const Vec3& t = pose.T_frame_body.translation;
    const Eigen::Quaterniond& q = pose.T_frame_body.rotation;
    std::string line = seconds(pose.stamp);
    for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) {
      line += ' ';
      line += shortest(value);
    }
    file.append(line + "\n");
  }
  file.commit();
}

std::vector<TumPose> read_tum(const std::filesystem::path& path) {
  std::istringstream text(read_file(path));
  std::vector<TumPose> poses;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word) || word.front() == '#') {
      continue;
    }
    const auto fault = [&](const std::string& what) {
      return IoError(path.string() + ":" + std::to_string(number) + ": " + what);
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
    poses.push_back({*stamp, {rotation.normalized(), Vec3(v[0], v[1], v[2])}});
  }
  return poses;
}

}  // namespace panoptes
