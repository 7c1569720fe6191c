// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/calibratability.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/calib/joint_of_rig.h"

namespace panoptes {

namespace {

/// Without lenses and clocks.
JointCovariance of_mountings(const JointCovariance& all) {
  JointCovariance mountings;
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < all.parameters.size(); ++i) {
    const std::string& parameter = all.parameters[i];
    if (parameter.find(".rotation_") != std::string::npos ||
        parameter.find(".position_") != std::string::npos) {
      mountings.parameters.push_back(parameter);
      rows.push_back(static_cast<Eigen::Index>(i));
    }
  }
  mountings.covariance = all.covariance(rows, rows);
  return mountings;
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
  out.left.covariance = of_mountings(joint_covariance(plan));
  return out;
}

}  // namespace panoptes
