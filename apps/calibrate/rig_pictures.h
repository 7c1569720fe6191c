// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "apps/process/fault.h"
#include "core/calib/rig_calibration.h"

namespace panoptes {

/// What is looked at of a rig's calibration, besides the numbers.
struct RigPictures {
  const RigCalibration& calibration;
  const Rig& believed;
  std::function<cv::Mat(const RigView&)> grey;  ///< as it was taken
};

/// Draws it into a folder: rig.png, matches_A_B.png of cameras that share points, and
/// reprojection_rig_CAMERA.png.
void write_rig_pictures(const std::filesystem::path& folder, const RigPictures& pictures,
                        Faults& faults);

}  // namespace panoptes
