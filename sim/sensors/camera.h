// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "core/config/fields.h"
#include "core/geometry/body.h"

namespace panoptes::sim {

/// How far the true cameras are from where the robot believes they are, each axis by itself.
struct MountingError {
  double sigma_deg = 0;
  double sigma_m = 0;
};
void bind(Fields& f, MountingError& o);

/// The true rig: the believed one with every camera turned and moved a little.
Rig mounted(const MountingError& error, const Rig& believed, const Rng& rng);

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
