// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "sim/render/renderer.h"

namespace panoptes::sim {

/// Our picture's rows run downwards, OpenGL's upwards: the picture is drawn upside down and read
/// back right. So clip y points down like the camera's own. Depth is near_m over the distance along
/// the axis: as exact far away as floating point is.
Eigen::Matrix4f clip_from_scene(const View& view, double near_m);

}  // namespace panoptes::sim
