// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>

#include "sim/world/load.h"
#include "sim/world/pictures.h"

namespace panoptes::sim {

/// Towards +x, -x, +y, -y, +z, -z.
inline constexpr std::array<std::string_view, 6> kFaceNames{"front", "back", "left",
                                                            "right", "top",  "bottom"};

/// The box with its faces outwards, its pictures upright as seen from outside (on top and bottom
/// their upper edge is towards +y).
Object make_box(const BoxSettings& settings, Pictures& pictures);

/// Two triangles. The corners run counter-clockwise as seen from the front and begin at the lower
/// left of the picture, which goes on from there over the face as `uv_low` (lower left) to
/// `uv_high`.
void append_rectangle(const std::array<Vec3, 4>& corners, const Vec2& uv_low, const Vec2& uv_high,
                      int texture, std::vector<Triangle>& triangles);

}  // namespace panoptes::sim
