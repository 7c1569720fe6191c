// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "sim/world/world.h"

namespace panoptes::sim {

/// A triangle of the world, with the places of its corners in the lightmap (in texels, 0, 0 at the
/// centre of the first). In its chart's frame: `scene`, or its object's where that may move.
struct LitTriangle {
  std::array<Vec3, 3> p;
  std::array<Vec2, 3> uv;
  std::array<Vec2, 3> texel;
  int texture = 0;
};

/// Connected triangles of one object in one plane: a rectangle of the lightmap. Its corner texels
/// lie on the corners of the rectangle around it in space, so that drawing never looks outside of
/// it. A rectangle much smaller than a cell has one column, or one row, in its middle.
struct Chart {
  std::size_t object = 0;
  bool moves = false;  ///< in its object's frame, else in `scene`
  bool flat = false;   ///< to roundoff: no triangle leans out of the rectangle
  bool full = false;   ///< its triangles fill the rectangle
  Vec3 normal = Vec3::UnitZ();
  Vec3 origin = Vec3::Zero();  ///< of the rectangle
  Vec3 u = Vec3::UnitX();      ///< along the columns, unit length
  Vec3 v = Vec3::UnitY();      ///< along the rows, unit length
  Vec2 size_m = Vec2::Zero();
  int column = 0;  ///< where it lies in the lightmap
  int row = 0;
  int columns = 0;
  int rows = 0;
  std::vector<LitTriangle> triangles;

  Vec3 point(double column_of_chart, double row_of_chart) const;
};

/// Charts of fixed objects first, then those of each object that may move in rows of its own.
struct Charts {
  std::vector<Chart> charts;
  int columns = 0;  ///< size of the lightmap
  int rows = 0;
  double cell_m = 0;  ///< how far apart the texels are at most
};

/// Cuts the world into charts and lays them out, each with a texel every `cell_m` or closer;
/// farther apart in a world so large that it would need more than a million of them.
Charts make_charts(const World& world, double cell_m);

/// The light that an 8-bit 255 stands for.
inline constexpr double kMostLight = 2.0;

/// The light in the air, for what moves through it: six walls of a small cube at each point of a
/// grid (the ambient cubes of McTaggart 2004).
struct Probes {
  using Cube = std::array<float, 6>;  ///< light on a surface that faces +x, -x, +y, -y, +z, -z

  Vec3 low_scene = Vec3::Zero();
  Vec3 spacing_m = Vec3::Ones();
  std::array<int, 3> counts{};            ///< along x, y, z; 0 where nothing moves
  std::vector<std::vector<Cube>> groups;  ///< as the layers of BakedLight; x runs fastest

  std::size_t size() const {
    return static_cast<std::size_t>(counts[0]) * static_cast<std::size_t>(counts[1]) *
           static_cast<std::size_t>(counts[2]);
  }
};

/// The switches that the lights of a world hang on, in order of name.
std::vector<std::string> light_groups(const World& world);

/// Light and shadow of a world, one layer for each group of its lights.
struct BakedLight {
  std::vector<std::string> groups;  ///< light_groups
  /// The light on every texel with the group's power at 1, as the square root of its share of
  /// kMostLight, 8-bit. In the first, where a chart moves: how much of the light around it reaches
  /// the texel, 255 for all.
  std::vector<cv::Mat> layers;
  Probes probes;
};

/// Called now and then with the share that is done; false stops the bake.
using BakeProgress = std::function<bool(double done)>;

/// Area lights and sun with their shadows, and the ambient light as far as near surfaces let it in.
/// The same bits for any number of threads and on any processor. Throws BakeStopped when `progress`
/// says so.
BakedLight bake_light(const World& world, const Charts& charts, int num_threads,
                      const BakeProgress& progress = {});

/// The same, from the user's cache folder if it was baked before.
BakedLight cached_light(const World& world, const Charts& charts, int num_threads,
                        const BakeProgress& progress = {});

}  // namespace panoptes::sim
