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
#include "core/calib/verdict.h"

namespace panoptes {

/// What a view of a rig shows, grey, as it was taken.
using ViewPicture = std::function<cv::Mat(const RigView&)>;

/// Of cameras whose maps' frames are in order of time.
ViewPicture view_picture(const std::vector<MappedCamera>& cameras, const FramePicture& picture);

/// Draws into a folder what views show: matches_A_B.png of cameras that share points, and
/// reprojection_rig_CAMERA.png of those that see any.
void write_seen_pictures(const std::filesystem::path& folder, const RigCalibration& calibration,
                         const ViewPicture& grey, Faults& faults);

/// Draws that, and the rig itself beside what was believed of it: rig.png.
void write_rig_pictures(const std::filesystem::path& folder, const RigCalibration& calibration,
                        const Rig& believed, Verdict verdict, const ViewPicture& grey,
                        Faults& faults);

}  // namespace panoptes
