// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/calibratability.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/calib/joint_of_rig.h"

namespace panoptes {

namespace {

// Lenses and clocks go together with nothing.
void leave_alone_what_is_no_mounting(JointCovariance& joint) {
  for (Eigen::Index i = 0; i < joint.covariance.rows(); ++i) {
    const std::string& parameter = joint.parameters[static_cast<std::size_t>(i)];
    if (parameter.find(".rotation_") == std::string::npos &&
        parameter.find(".position_") == std::string::npos) {
      const double variance = joint.covariance(i, i);
      joint.covariance.row(i).setZero();
      joint.covariance.col(i).setZero();
      joint.covariance(i, i) = variance;
    }
  }
}

}  // namespace

Calibratability calibratability(const CalibratabilityOptions& options, const Rig& rig,
                                const Body& body) {
  constexpr double kLongest_s = 600;
  const std::vector<std::pair<std::string, RigCamera>> cameras(rig.cameras.begin(),
                                                               rig.cameras.end());
  const RigCalibration plan =
      plan_calibration(options.plan, cameras, driven_path(options.program, body, kLongest_s));
  const RigCovariance& known = plan.bundle.known;
  const Eigen::VectorXd sigma = known.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Calibratability out;
  out.left = rig;
  out.left.covariance = joint_covariance(plan);
  for (std::size_t i = 0; i < plan.cameras.size(); ++i) {
    CameraCalibratability camera;
    camera.camera = plan.cameras[i];
    camera.rotation_rad = sigma.segment<3>(known.camera[i]).maxCoeff();
    camera.position_m = sigma.segment<2>(known.camera[i] + 3).maxCoeff();
    camera.unobservable = known.unobservable[i];
    out.rotation_rad = std::max(out.rotation_rad, camera.rotation_rad);
    out.position_m = std::max(out.position_m, camera.position_m);
    out.all_observable = out.all_observable && camera.unobservable.empty();
    CameraSigmas& left = out.left.cameras.at(camera.camera).sigma;
    left.rotation_rad = sigma.segment<3>(known.camera[i]);
    left.position_m = sigma.segment<3>(known.camera[i] + 3);
    out.cameras.push_back(std::move(camera));
  }
  leave_alone_what_is_no_mounting(*out.left.covariance);
  return out;
}

}  // namespace panoptes
