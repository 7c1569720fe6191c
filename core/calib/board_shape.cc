// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/board_shape.h"

#include <algorithm>

namespace panoptes {

ShapeNumbers shape_numbers(const BoardShape& shape) {
  ShapeNumbers numbers;
  numbers << shape.stretch, shape.skew_rad, shape.bow_rows_m, shape.bow_columns_m, shape.twist_m;
  return numbers;
}

BoardShape shape_of(const ShapeNumbers& numbers) {
  return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]};
}

BoardShape usual_shape(const Board& board) {
  constexpr double kStretch = 0.003;   // a printer's feed against its line: 0.1 to 0.5 %
  constexpr double kSkew_rad = 0.002;  // a tenth of a degree: its head or mirror against the feed
  constexpr double kBow = 0.005;       // of half a side: 0.5 mm at the edge of 20 cm of cardboard
  const double bow_m = kBow * board.square_m * (std::max(board.columns, board.rows) - 1) / 2;
  return {kStretch, kSkew_rad, bow_m, bow_m, bow_m};
}

Eigen::Matrix<double, 3, 5> corner_by_shape(const Board& board, int index) {
  const Vec3 half = board.corner_board(board.corners() - 1) / 2;
  const Vec3 p = board.corner_board(index) - half;
  const double across = p.x() / half.x();
  const double down = p.y() / half.y();
  Eigen::Matrix<double, 3, 5> by;
  by << p.x() / 2, p.y() / 2, 0, 0, 0,  //
      -p.y() / 2, p.x() / 2, 0, 0, 0,   //
      0, 0, across * across, down * down, across * down;
  return by;
}

std::vector<Vec3> corners_board(const Board& board, const BoardShape& shape) {
  std::vector<Vec3> corners;
  corners.reserve(board.corners());
  for (int i = 0; i < board.corners(); ++i) {
    corners.push_back(board.corner_board(i) + corner_by_shape(board, i) * shape_numbers(shape));
  }
  return corners;
}

}  // namespace panoptes
