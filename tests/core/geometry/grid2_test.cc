// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/grid2.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panoptes {
namespace {

using ::testing::ElementsAre;

const Grid2<int> kGrid{0.5, {-1, 2}, 3, 2, {1, 2, 3, 4, 5, 6}};

TEST(Grid2, IsRowMajorFromTheLowerLeftCorner) {
  EXPECT_EQ(kGrid.size(), 6);
  EXPECT_EQ(kGrid.index(2, 1), 5);
  EXPECT_EQ(kGrid(0, 0), 1);
  EXPECT_EQ(kGrid(2, 1), 6);
  EXPECT_EQ(kGrid.centre(0, 0), Vec2(-0.75, 2.25));
  EXPECT_EQ(kGrid.centre(2, 1), Vec2(0.25, 2.75));
  EXPECT_EQ(kGrid.point(3, 2), Vec2(0.5, 3));
}

TEST(Grid2, FindsTheCellOfAPoint) {
  for (int row = 0; row < kGrid.rows; ++row) {
    for (int column = 0; column < kGrid.columns; ++column) {
      const Vec2 p = kGrid.centre(column, row);
      EXPECT_EQ(kGrid.column(p), column);
      EXPECT_EQ(kGrid.row(p), row);
      EXPECT_EQ(kGrid.at(p), kGrid(column, row));
    }
  }
  EXPECT_EQ(kGrid.at(kGrid.point(1, 1)), 5) << "a cell has its lower and left edges";
  EXPECT_EQ(kGrid.column({-1.01, 0}), -1);
  EXPECT_EQ(kGrid.row({0, -10}), -24);
}

TEST(Grid2, IsEmptyOutside) {
  EXPECT_TRUE(kGrid.contains(2, 1));
  for (const auto& [column, row] :
       std::vector<std::pair<int, int>>{{-1, 0}, {0, -1}, {3, 0}, {0, 2}}) {
    EXPECT_FALSE(kGrid.contains(column, row));
    EXPECT_EQ(kGrid.at(column, row), 0);
    EXPECT_EQ(kGrid.at(kGrid.centre(column, row)), 0);
  }
  EXPECT_EQ(kGrid.at({1e30, 2.1}), 0);
  EXPECT_EQ(kGrid.at({0, std::nan("")}), 0);
  EXPECT_EQ(Grid2<int>{}.at({0, 0}), 0);
}

TEST(Grid2, IsAssignedOneValue) {
  Grid2<int> grid = kGrid;
  grid.assign(2, 1, 7);
  EXPECT_EQ(grid.columns, 2);
  EXPECT_EQ(grid.rows, 1);
  EXPECT_THAT(grid.cells, ElementsAre(7, 7));
  EXPECT_EQ(grid.cell_m, kGrid.cell_m);
  EXPECT_EQ(grid.origin, kGrid.origin);
}

TEST(Grid2, SumsTheAreaOfAValue) {
  EXPECT_EQ(kGrid.area_m2(3), 0.25);
  EXPECT_EQ(kGrid.area_m2(0), 0);
}

TEST(Grid2, IsTransformedCellByCell) {
  const Grid2<char> odd = transformed(kGrid, [](int value) { return value % 2 == 1 ? 'y' : 'n'; });
  EXPECT_EQ(odd.cell_m, kGrid.cell_m);
  EXPECT_EQ(odd.origin, kGrid.origin);
  EXPECT_EQ(odd.columns, 3);
  EXPECT_EQ(odd.rows, 2);
  EXPECT_THAT(odd.cells, ElementsAre('y', 'n', 'y', 'n', 'y', 'n'));
}

}  // namespace
}  // namespace panoptes
