// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/calib/board.h"

namespace panoptes {

/// How a printed board differs from the declared one, its size apart, of which the lens does not
/// depend. The same from both ends of the board, as its corners may be counted from either.
struct BoardShape {
  double stretch = 0;        ///< of rows against columns, as a share; the area stays
  double skew_rad = 0;       ///< what the angle between rows and columns lacks to a right one
  double bow_rows_m = 0;     ///< z at the ends of rows, less the middle's
  double bow_columns_m = 0;  ///< z at the ends of columns
  double twist_m = 0;        ///< z at the first corner and the last; at the other two the opposite
};

using ShapeNumbers = Eigen::Matrix<double, 5, 1>;

/// The shape as a row of numbers in the order of the struct, and back.
ShapeNumbers shape_numbers(const BoardShape& shape);
BoardShape shape_of(const ShapeNumbers& numbers);

/// What is known of any board before it is seen, as standard deviations.
BoardShape usual_shape(const Board& board);

/// How a corner moves with the numbers, in the board's frame. It is the same for all of them.
Eigen::Matrix<double, 3, 5> corner_by_shape(const Board& board, int index);

/// Where the corners are, in the board's frame.
std::vector<Vec3> corners_board(const Board& board, const BoardShape& shape);

}  // namespace panoptes
