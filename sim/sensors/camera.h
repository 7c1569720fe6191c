// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "core/geometry/body.h"

namespace panoptes::sim {

struct SurveyError {
  double floor_m = 0.002;  ///< of the tape measure, each axis
  double pixel_px = 0.3;   ///< of the mark in the picture, each axis
};

/// Lays four marks on the floor into the mapped part of the true camera's picture, near and far,
/// left and right, and measures them as a person would. Throws ConfigError naming the camera when
/// its mapped part has no floor in view.
std::vector<FloorMark> survey_floor(const std::string& name, const RigCamera& true_camera,
                                    const Body& body, const SurveyError& error, const Rng& rng);

}  // namespace panoptes::sim
