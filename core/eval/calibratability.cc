// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/calibratability.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace panoptes {

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
  for (std::size_t i = 0; i < plan.cameras.size(); ++i) {
    CameraCalibratability camera;
    camera.camera = plan.cameras[i];
    camera.rotation_rad = sigma.segment<3>(known.camera[i]).maxCoeff();
    camera.position_m = sigma.segment<2>(known.camera[i] + 3).maxCoeff();
    camera.unobservable = known.unobservable[i];
    out.rotation_rad = std::max(out.rotation_rad, camera.rotation_rad);
    out.position_m = std::max(out.position_m, camera.position_m);
    out.all_observable = out.all_observable && camera.unobservable.empty();
    out.cameras.push_back(std::move(camera));
  }
  return out;
}

}  // namespace panoptes
