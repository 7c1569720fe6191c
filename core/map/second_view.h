// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera/rig.h"
#include "core/geometry/pose2.h"
#include "core/map/floor_colour.h"
#include "core/map/floor_projection.h"

namespace panoptes {

/// How another camera sees the floor that a floor camera maps, from another height: samples on rays
/// of the same directions and ranges, about its own foot.
struct SecondView {
  Vec2 foot_view = Vec2::Zero();
  double height_m = 0;
  std::vector<std::int32_t> pixel;  ///< of each sample: v * width + u, -1 outside
  std::vector<float> depth_m;       ///< length of floor along the ray that its pixel covers
  Mat3 covariance = Mat3::Zero();   ///< of range_error(): what the rig file does not know

  struct Pair {               ///< the same floor
    std::int32_t sample = 0;  ///< of the floor camera's scan
    std::int32_t pixel = 0;   ///< of this camera
  };
  std::vector<Pair> pairs;

  /// How the range of a floor point changes with the share by which the camera stands higher than
  /// the rig says, and with its tilt and roll (rad).
  Vec3 range_error(double range_m, double direction_rad) const;
};

/// Empty where the two cameras share too little floor or stand at much the same height.
std::optional<SecondView> second_view(const FloorProjection& projection, const RigCamera& camera);

/// By which levels of each channel the floor camera shows what the second one shows at a level, as
/// the exposures of the two differ.
using Levels = std::array<std::array<std::uint8_t, 256>, 3>;

/// Made alike on the floor that both see. `known`: how clearly each sample of the floor camera's
/// scan has the floor's colour. Empty where they see too little floor together.
std::optional<Levels> levels_alike(const SecondView& view, const cv::Mat& bgr,
                                   const FloorProjection& projection, const cv::Mat& floor_bgr,
                                   const std::vector<std::int8_t>& known);

/// How clearly each sample has the floor's colour, as FloorColour::quick says it.
std::vector<std::int8_t> rate_second(const SecondView& view, const cv::Mat& bgr,
                                     const Levels& levels, FloorColour& colour);

}  // namespace panoptes
