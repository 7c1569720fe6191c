// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/pose2.h"
#include "core/geometry/pose3.h"

namespace panoptes {

/// A chessboard, by the corners where four squares meet.
struct Board {
  int columns = 9;  ///< of such corners
  int rows = 6;
  double square_m = 0.025;

  static constexpr int kFewestCorners = 3;  ///< a side: what OpenCV finds
  static constexpr int kMostCorners = 100;
  static constexpr double kLargestSquare_m = 2;  ///< beyond it somebody wrote millimetres

  int corners() const { return columns * rows; }
  /// In the board's frame: x along a row, y along a column, z = 0; the first corner at the origin.
  Vec3 corner_board(int index) const;
};

/// "9x6x0.025": columns, rows and the side of a square in metres. Empty for what is none, or beyond
/// a board's limits.
std::optional<Board> parse_board(std::string_view text);

/// The corners of a whole board in a grey picture, to a fraction of a pixel, row by row. Which of a
/// board's corners is the first is not told apart where it looks alike from both ends; the lens
/// does not mind. Empty when no whole board is seen.
std::optional<std::vector<Vec2>> find_board(const cv::Mat& grey, const Board& board);

}  // namespace panoptes
