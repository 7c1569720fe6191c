// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/joint_covariance.h"

#include <algorithm>
#include <cmath>

#include "core/camera/lens_parameters.h"

namespace panoptes {

std::vector<std::string> joint_parameters(const std::string& camera, const Intrinsics& lens) {
  std::vector<std::string> all{"rotation_x_rad", "rotation_y_rad", "rotation_z_rad",
                               "position_x_m",   "position_y_m",   "position_z_m"};
  for (const std::string& number : lens_parameter_names(lens)) {
    all.push_back(number);
  }
  all.emplace_back("clock_s");
  for (std::string& parameter : all) {
    parameter.insert(0, camera + ".");
  }
  return all;
}

Eigen::MatrixXd correlations(const JointCovariance& joint,
                             const std::vector<std::string>& parameters) {
  const auto size = static_cast<Eigen::Index>(parameters.size());
  std::vector<Eigen::Index> row_of;  // -1: none
  for (const std::string& parameter : parameters) {
    const auto found = std::find(joint.parameters.begin(), joint.parameters.end(), parameter);
    row_of.push_back(found == joint.parameters.end() ? -1 : found - joint.parameters.begin());
  }
  Eigen::MatrixXd all = Eigen::MatrixXd::Identity(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index k = 0; k < size; ++k) {
      const Eigen::Index a = row_of[static_cast<std::size_t>(i)];
      const Eigen::Index b = row_of[static_cast<std::size_t>(k)];
      if (i == k || a < 0 || b < 0) {
        continue;
      }
      const double by = std::sqrt(joint.covariance(a, a) * joint.covariance(b, b));
      all(i, k) = by > 0 ? joint.covariance(a, b) / by : 0;
    }
  }
  return all;
}

}  // namespace panoptes
