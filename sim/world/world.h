// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/pose3.h"

namespace panoptes::sim {

/// A corner of a triangle in its object's frame. Texture coordinates run right and down from the
/// picture's top left corner; the picture repeats outside of 0..1.
struct Corner {
  Vec3 p_object = Vec3::Zero();
  Vec2 uv = Vec2::Zero();
};

/// Counter-clockwise seen from its front; the back is not drawn.
struct Triangle {
  std::array<Corner, 3> corners;
  int texture = 0;  ///< in World::textures
};

/// What a surface looks like: the square root of the share of light it returns, as pictures have
/// it.
struct Texture {
  std::string name;
  cv::Mat bgr;
};

/// A rigid thing that stands in the world.
struct Object {
  std::string name;
  Pose3 T_scene_object;
  std::vector<Triangle> triangles;
};

/// A shining rectangle. With power 1 it lights a surface that faces it from 1 m straight below its
/// middle with 1 (a white surface lit with 1 is drawn white). A surface of the world that lies in
/// the rectangle, its front the way the light shines, is seen shining.
struct AreaLight {
  Vec3 at_m = Vec3(0, 0, 2.5);
  Vec2 size_m = Vec2(0.6, 0.6);
  Vec3 normal = Vec3(0, 0, -1);
  double power = 1;
};

/// A synthetic world at rest: a plain value in `scene`, z up, the floor at z = 0.
struct World {
  std::string name;
  double ambient = 0.35;  ///< light from everywhere, weakened in corners
  std::vector<AreaLight> lights;
  std::vector<Texture> textures;
  std::vector<Object> objects;
};

}  // namespace panoptes::sim
