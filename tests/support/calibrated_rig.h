// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include "core/calib/rig_calibration.h"
#include "tests/support/driven_rig.h"

namespace panoptes {

/// Two cameras that look away from each other, driven and adjusted without pictures.
struct CalibratedRig {
  explicit CalibratedRig(const DrivenScene& scene, std::uint64_t seed = 40)
      : driven(driven_rig(two_cameras(), scene, {}, Rng(seed))) {
    calibration.cameras = {"ahead", "behind"};
    calibration.map_of_point.assign(driven.start.points_start.size(), -1);
    calibration.before = driven.start;
    calibration.bundle = adjusted(driven);
    calibration.tracks = driven.tracks;
    for (const RigSeen& seen : calibration.tracks.seen) {
      if (seen.own) {
        calibration.map_of_point[seen.point] =
            static_cast<int>(calibration.tracks.views[seen.view].camera);
      }
    }
    calibration.wheels = [this](Time at) { return driven.rose.wheels(at); };
  }
  CalibratedRig(const CalibratedRig&) = delete;
  CalibratedRig& operator=(const CalibratedRig&) = delete;

  static std::vector<RigCamera> two_cameras() {
    std::vector<RigCamera> rig(2);
    for (std::size_t c = 0; c < rig.size(); ++c) {
      rig[c].intrinsics = pinhole(640, 480, deg_to_rad(80));
      rig[c].T_body_camera =
          mounted_camera({c == 0 ? 0.15 : -0.15, 0, 0.7}, c == 0 ? 0 : std::numbers::pi, 0);
      rig[c].sigma.rotation_rad.setConstant(0.02);
    }
    return rig;
  }
  cv::Mat blank() const { return {480, 640, CV_8U, cv::Scalar(90)}; }

  DrivenRig driven;
  RigCalibration calibration;
};

}  // namespace panoptes
