// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/board_shape.h"

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kRoundoff_m = 1e-15;

const Board kBoard;
const BoardShape kShape{0.004, -0.002, 0.0005, -0.0003, 0.0002};

TEST(BoardShape, NumbersGoThereAndBack) {
  EXPECT_EQ(shape_numbers(shape_of(shape_numbers(kShape))), shape_numbers(kShape));
}

TEST(BoardShape, WithoutOneCornersAreAsDeclared) {
  const std::vector<Vec3> corners = corners_board(kBoard, {});
  for (int i = 0; i < kBoard.corners(); ++i) {
    EXPECT_EQ(corners[i], kBoard.corner_board(i));
  }
}

TEST(BoardShape, IsTheSameFromBothEnds) {
  const std::vector<Vec3> corners = corners_board(kBoard, kShape);
  const Vec3 last = kBoard.corner_board(kBoard.corners() - 1);
  for (int i = 0; i < kBoard.corners(); ++i) {
    const Vec3& other = corners[kBoard.corners() - 1 - i];
    const Vec3 turned(last.x() - other.x(), last.y() - other.y(), other.z());
    EXPECT_LT((corners[i] - turned).norm(), kRoundoff_m);
  }
}

TEST(BoardShape, StretchesRowsAgainstColumnsAndBowsTheirEnds) {
  const std::vector<Vec3> corners = corners_board(kBoard, kShape);
  const Vec3 row = corners[8] - corners[0];
  const Vec3 column = corners[45] - corners[0];
  const double ratio = (row.x() / (8 * kBoard.square_m)) / (column.y() / (5 * kBoard.square_m));
  constexpr double kSecondOrder = 1e-5;
  EXPECT_NEAR(ratio, 1 + kShape.stretch, kSecondOrder);
  EXPECT_NEAR(row.head<2>().normalized().dot(column.head<2>().normalized()), kShape.skew_rad,
              kSecondOrder);
  EXPECT_NEAR(corners[0].z(), kShape.bow_rows_m + kShape.bow_columns_m + kShape.twist_m,
              kRoundoff_m);
  EXPECT_NEAR(corners[8].z(), kShape.bow_rows_m + kShape.bow_columns_m - kShape.twist_m,
              kRoundoff_m);
}

}  // namespace
}  // namespace panoptes
