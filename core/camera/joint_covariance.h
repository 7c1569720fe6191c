// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace panoptes {

struct Intrinsics;

/// How well the cameras of a rig are known together: what was calibrated together is off together,
/// which sigmas of each camera do not tell.
struct JointCovariance {
  std::vector<std::string> parameters;  ///< of its rows: those of one camera, then of the next
  Eigen::MatrixXd covariance;
};

/// Of one camera, in this order: `<camera>.rotation_x_rad`, `_y_rad`, `_z_rad` (its turn about the
/// body's axes), `<camera>.position_x_m`, `_y_m`, `_z_m` (in body), its lens
/// (lens_parameter_names), `<camera>.clock_s`.
std::vector<std::string> joint_parameters(const std::string& camera, const Intrinsics& lens);

/// How these parameters go together; what `joint` does not tell of goes with nothing.
Eigen::MatrixXd correlations(const JointCovariance& joint,
                             const std::vector<std::string>& parameters);

}  // namespace panoptes
