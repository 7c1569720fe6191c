// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "sim/world/world.h"

namespace panoptes::sim {

/// A triangle of the world in `scene`, with the places of its corners in the lightmap (in texels,
/// 0, 0 at the centre of the first).
struct LitTriangle {
  std::array<Vec3, 3> p_scene;
  std::array<Vec2, 3> uv;
  std::array<Vec2, 3> texel;
  int texture = 0;
};

/// Connected triangles of one object in one plane: a rectangle of the lightmap. Its corner texels
/// lie on the corners of the rectangle around it in space, so that drawing never looks outside of
/// it.
struct Chart {
  int object = 0;
  Vec3 normal = Vec3::UnitZ();
  Vec3 origin_scene = Vec3::Zero();  ///< of texel (0, 0)
  Vec3 u = Vec3::UnitX();            ///< along the columns, unit length
  Vec3 v = Vec3::UnitY();            ///< along the rows, unit length
  Vec2 size_m = Vec2::Zero();
  int column = 0;  ///< where it lies in the lightmap
  int row = 0;
  int columns = 0;
  int rows = 0;
  std::vector<LitTriangle> triangles;
};

struct Charts {
  std::vector<Chart> charts;
  int columns = 0;  ///< size of the lightmap
  int rows = 0;
};

/// Cuts the world into charts and lays them out, each with a texel every `cell_m` or closer.
Charts make_charts(const World& world, double cell_m);

/// The light that an 8-bit 255 stands for.
inline constexpr double kMostLight = 2.0;

/// The light on every texel, as the square root of its share of kMostLight: area lights with their
/// shadows, and the ambient light as far as near surfaces let it in. The same bits for any number
/// of threads.
cv::Mat bake_light(const World& world, const Charts& charts, int num_threads);

/// The same, from the user's cache folder if it was baked before.
cv::Mat cached_light(const World& world, const Charts& charts, int num_threads);

}  // namespace panoptes::sim
