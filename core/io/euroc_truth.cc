// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/euroc_truth.h"

#include <cmath>

#include <yaml-cpp/yaml.h>

#include "core/base/error.h"
#include "core/io/dataset_rows.h"
#include "core/io/dataset_table.h"

namespace panoptes {
namespace {

constexpr std::string_view kSensorFile = "mav0/state_groundtruth_estimate0/sensor.yaml";

Pose3 T_body_tracked(const std::string& folder, const DatasetText& text) {
  const std::string place = in_folder(folder, kSensorFile) + ": ";
  const std::optional<std::string> found = text(std::string(kSensorFile));
  if (!found) {
    return {};
  }
  std::vector<double> m;
  try {
    const YAML::Node mount = YAML::Load(*found)["T_BS"];
    if (!mount) {
      return {};
    }
    m = (mount.IsMap() ? mount["data"] : mount).as<std::vector<double>>();
  } catch (const YAML::Exception& error) {
    throw ConfigError(place + "T_BS must be a matrix of 4 x 4: " + error.what());
  }
  constexpr double kRounded = 1e-3;  // digits that people write
  Mat3 R = Mat3::Zero();
  Vec3 t = Vec3::Zero();
  for (std::size_t i = 0; m.size() == 16 && i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    R.row(row) << m[4 * i], m[4 * i + 1], m[4 * i + 2];
    t[row] = m[4 * i + 3];
  }
  if (!t.allFinite() || !((R * R.transpose() - Mat3::Identity()).norm() < kRounded) ||
      R.determinant() < 0) {
    throw ConfigError(place + "T_BS must be a matrix of 4 x 4 that turns and shifts, row by row");
  }
  return {Eigen::Quaterniond(R).normalized(), t};
}

Eigen::Quaterniond attitude(const DatasetTable& rows, std::size_t row) {
  constexpr double kRounded = 1e-3;
  const Eigen::Quaterniond q(rows.finite(row, 4), rows.finite(row, 5), rows.finite(row, 6),
                             rows.finite(row, 7));
  if (!(std::abs(q.norm() - 1) < kRounded)) {
    throw rows.fault(row, "fields 5 to 8 must be a unit quaternion, w x y z");
  }
  return q.normalized();
}

}  // namespace

std::optional<std::vector<TumPose>> read_euroc_truth(const std::string& folder,
                                                     const DatasetText& text) {
  const std::optional<std::string> found = text(std::string(kEstimateFile));
  if (!found) {
    return std::nullopt;
  }
  constexpr double kUpright = 0.7;  // cosine of 45 degrees
  const DatasetTable rows(in_folder(folder, kEstimateFile), *found, 8, TableBy::kOthers);
  const Pose3 T_tracked_body = T_body_tracked(folder, text).inverse();
  std::vector<TumPose> poses;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const Vec3 p(rows.bounded(row, 1, kFarthest_m), rows.bounded(row, 2, kFarthest_m),
                 rows.bounded(row, 3, kFarthest_m));
    const TumPose pose{rows.stamp(row, 0), Pose3{attitude(rows, row), p} * T_tracked_body};
    if (!poses.empty() && pose.stamp <= poses.back().stamp) {
      throw rows.fault(row, "is not after the row before");
    }
    if ((pose.T_frame_body.rotation * Vec3::UnitZ()).z() < kUpright) {
      throw rows.fault(row,
                       "the body does not stand upright (x ahead, y left, z up): say by T_BS in " +
                           in_folder(folder, kSensorFile) +
                           " how the tracked thing sits in it, or remove the folder to replay "
                           "without the truth");
    }
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace panoptes
