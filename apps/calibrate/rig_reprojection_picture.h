// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/calib/rig_calibration.h"
#include "core/calib/wheel_readings.h"

namespace panoptes {

/// A camera's views, in order of time, that together show as many points as so many can.
std::vector<std::size_t> telling_views(const RigCalibration& calibration, std::size_t camera,
                                       std::size_t most);

struct ShownView {
  std::size_t view = 0;  ///< index of RigTracks::views
  cv::Mat grey;
};

/// Keyframes of one camera, each twice: where its points and those of the other cameras' maps are
/// drawn before all cameras are adjusted together, and after (thesis Figs. 4.11, 4.14), as lines
/// from where they were seen, enlarged. 8-bit BGR.
cv::Mat draw_rig_reprojection(const RigCalibration& calibration, const WheelReadings& wheels,
                              std::size_t camera, const std::vector<ShownView>& shown);

}  // namespace panoptes
