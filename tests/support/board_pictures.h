// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/calib/board.h"
#include "core/calib/board_shape.h"
#include "core/calib/lens_fit.h"
#include "core/camera/rig.h"

namespace panoptes {

/// How somebody holds a board before a camera.
struct BoardPoses {
  double most_slant_rad = deg_to_rad(45);
  double most_roll_rad = 0.5;  ///< about its normal, either way
  double least_width = 0.25;   ///< of the picture, as a share of it
  double most_width = 0.6;
  Vec2 from = Vec2(0, 0);  ///< of the picture, as shares of it: where the middle of the board is,
  Vec2 to = Vec2(1, 1);    ///< as far as the whole board is seen
};

/// T_camera_board of `count` whole boards with a margin of a square about them.
std::vector<Pose3> board_poses(const Board& board, const Intrinsics& lens, const BoardPoses& held,
                               int count, Rng& rng);

/// The same in each corner of the picture by turns, for those who were told to.
std::vector<Pose3> board_poses_in_corners(const Board& board, const Intrinsics& lens, int count,
                                          Rng& rng);

/// Where a lens draws the corners, each off by so much noise each way.
std::vector<BoardCorners> seen_corners(const Board& board, const Intrinsics& lens,
                                       const std::vector<Pose3>& poses, double noise_px, Rng& rng);

/// The same of corners that are where no declared board has them.
std::vector<BoardCorners> seen_corners(const std::vector<Vec3>& corners_board,
                                       const Intrinsics& lens, const std::vector<Pose3>& poses,
                                       double noise_px, Rng& rng);

/// What a real camera does to a picture of a board.
struct BoardLight {
  double noise_grey = 2;
  double exposure = 0.2;      ///< pictures differ by so much in brightness, either way
  double vignetting = 0.3;    ///< of the light is lost in the corners
  double sharpness_px = 0.6;  ///< standard deviation of the lens' blur
  double moves_mps = 0.05;    ///< while the shutter is open
  double shutter_s = 0.008;
};

/// Draws boards by rays through every sixteenth of a pixel: exact but for the noise.
class BoardPainter {
 public:
  BoardPainter(const Board& board, const Intrinsics& lens, const BoardShape& shape = {});

  /// 8 bits, grey.
  cv::Mat draw(const Pose3& T_camera_board, const BoardLight& light, Rng& rng) const;

 private:
  // Of a part of a pixel.
  double shade(std::size_t part, const Pose3& T_board_camera) const;

  Board board_;
  BoardShape shape_;
  Intrinsics lens_;
  std::vector<Eigen::Vector3f> directions_;  // of parts of pixels, zero where nothing is seen
  std::vector<float> room_;                  // what is there without a board
};

}  // namespace panoptes
