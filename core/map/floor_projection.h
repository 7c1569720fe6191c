// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera/rig.h"
#include "core/geometry/body.h"

namespace panoptes {

/// How the mapped part of a floor camera's picture falls on the floor, in the frame `view`: the
/// body turned to where the camera looks, so that x is ahead of any camera. An upright object
/// smears outwards from the camera's foot on the floor, so the picture is read along floor rays
/// from that foot: images of vertical lines, nearly picture columns. A scan is `rows` samples
/// (nearest first) on each of `rays` rays.
struct FloorProjection {
  Pose2 T_body_view;    ///< a turn about the body's middle
  Mat3 H_view_px;       ///< floor point in view (x, y, 1) ~ H * (u, v, 1)
  Vec2 foot_view;       ///< the point of the floor under the camera
  double height_m = 0;  ///< of the camera over the floor
  double front_m = 0;   ///< x of the nearest mapped floor: the body's edge and the blind zone
  double blind_zone_m = 0;

  int rays = 0;
  int rows = 0;
  double first_ray_rad = 0;         ///< direction of ray 0,
  double ray_step_rad = 0;          ///< and from each to the next
  std::vector<std::int32_t> pixel;  ///< of sample [row * rays + ray]: v * width + u, -1 outside
  std::vector<float> range_m;       ///< of the sample from the foot
  std::vector<float> depth_m;       ///< length of floor along the ray that its pixel covers
  std::vector<std::uint8_t>
      weight;  ///< 0..kFullWeight: share of a pixel's evidence that one cell deserves

  double cell_m = 0.01;              ///< of the raster
  Vec2 origin_view = Vec2::Zero();   ///< its lower-left corner
  int cell_columns = 0;              ///< along x
  int cell_rows = 0;                 ///< along y
  std::vector<std::int32_t> sample;  ///< the scan's sample under each cell, -1 outside
  std::vector<Vec2> outline_view;    ///< convex outline of the mapped floor, counter-clockwise

  static constexpr int kFullWeight = 16;
};

/// The projection a floor camera's marks or homography give. Throws ConfigError when the camera has
/// no floor view, its marks are degenerate, or its horizon or nothing at all lies in the mapped
/// part.
FloorProjection project_floor(const RigCamera& camera, const Body& body, double cell_m = 0.01);

}  // namespace panoptes
