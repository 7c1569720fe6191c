// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/camera/rig.h"
#include "core/map/second_view.h"

namespace panoptes {

/// A surface of one colour with a noise texture of several scales.
struct Surface {
  Vec3 bgr = Vec3(120, 120, 120);
  double contrast = 0.1;  ///< relative
  int pattern = 1;        ///< seeds the texture
};

/// An upright box on the floor.
struct SceneBox {
  Vec2 low = Vec2::Zero();
  Vec2 high = Vec2::Zero();
  double height_m = 0.7;
  Surface surface;
};

/// A floor of two carpets that meet at x = `seam_x_m`, with boxes on it, for drawing what a floor
/// camera would see.
struct FloorScene {
  Surface carpet;
  Surface second_carpet;
  double seam_x_m = 1e9;
  std::vector<SceneBox> boxes;
  double contact_shade = 0.0;  ///< how much darker the floor is where a box stands on it
  double noise_grey = 2.0;
};

/// The camera of the office's rig: 0.75 m high, tilted by 28 degrees, seeing the floor from 0.19 m.
RigCamera office_floor_camera();

/// Of a second camera that shows everything as the floor camera does.
Levels same_levels();

cv::Mat draw(const FloorScene& scene, const RigCamera& camera, const Pose2& T_scene_body, Rng& rng);

}  // namespace panoptes
