// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/camera/rig.h"
#include "core/geometry/body.h"

namespace panoptes::sim {

/// The first row of the picture that is mapped.
int first_mapped_row(const RigCamera& camera);

/// The point of the floor under a pixel, in the body's frame; empty above the horizon.
std::optional<Vec2> floor_under(const RigCamera& true_camera, const Vec2& px);

/// Whether a point of the floor lies in the mapped range of a camera that has a floor view: so far
/// from the body's edge, the way the camera looks.
bool in_mapped_range(const RigCamera& true_camera, const Body& body, const Vec2& p_body);

}  // namespace panoptes::sim
