// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace panoptes::sim {

/// A rectangle in space.
struct SpaceRectangle {
  Eigen::Vector3f corner = Eigen::Vector3f::Zero();
  Eigen::Vector3f side_u = Eigen::Vector3f::Zero();
  Eigen::Vector3f side_v = Eigen::Vector3f::Zero();
};

/// What rectangles hide, tile by tile of a picture: told of near objects first, it spares the
/// drawing of what is behind them. Never wrong about what it calls hidden, as far as whole pixels
/// go.
class Occlusion {
 public:
  /// Forgets everything. `clip_scene` gives (x, y, near, distance) and x and y from -1 to 1, as in
  /// OpenGL with its depth reversed; where the distance is less than `near_m` nothing is drawn.
  void start(const Eigen::Matrix4f& clip_scene, int width_px, int height_px, float near_m);

  /// Whether nothing in the rectangle can be seen behind those that were added.
  bool hides(const SpaceRectangle& rectangle);

  /// A rectangle that is drawn whole. Follows upon hides() of the same.
  void add();

 private:
  void project(const SpaceRectangle& rectangle);
  float& inverse_depth(int column, int row) {
    return tiles_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
  }

  Eigen::Matrix4f clip_scene_;
  int width_px_ = 0;
  int height_px_ = 0;
  float near_m_ = 0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<float> tiles_;  ///< how near (as 1 / distance) the farthest drawn pixel is at least

  bool in_front_ = false;              ///< all four corners
  std::array<Eigen::Vector3f, 4> px_;  ///< corners, in order around: pixels from the picture's
                                       ///< corner, 1 / distance
};

}  // namespace panoptes::sim
