// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/lattice2.h"

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(CellBox, NumbersItsCellsRowByRow) {
  const CellBox box{-2, 5, 1, 7};
  EXPECT_EQ(box.columns(), 3);
  EXPECT_EQ(box.rows(), 2);
  EXPECT_EQ(box.size(), 6);
  EXPECT_EQ(box.index(-2, 5), 0);
  EXPECT_EQ(box.index(0, 6), 5);
  EXPECT_TRUE(box.contains(0, 6));
  EXPECT_FALSE(box.contains(1, 6));
  EXPECT_FALSE(box.contains(0, 7));
  EXPECT_FALSE(box.contains(-3, 5));
  EXPECT_FALSE(box.contains(-2, 4));
}

TEST(Lattice2, GrowsByWholeBlocks) {
  Lattice2<int> lattice(0.1, 8);
  EXPECT_EQ(lattice.box().size(), 0);
  lattice.reserve({-1, 0, 1, 8});
  EXPECT_EQ(lattice.box(), (CellBox{-8, 0, 8, 8}));
  lattice.reserve({-8, 7, 8, 8});
  EXPECT_EQ(lattice.box(), (CellBox{-8, 0, 8, 8})) << "it holds them already";
  EXPECT_EQ(lattice.grown({9, -17, 10, -16}), (CellBox{-8, -24, 16, 8}));
  lattice.reserve({9, -17, 10, -16});
  EXPECT_EQ(lattice.box(), (CellBox{-8, -24, 16, 8}));
}

TEST(Lattice2, KeepsItsCellsAsItGrows) {
  Lattice2<int> lattice(0.1, 4);
  lattice.reserve({0, 0, 4, 4});
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      lattice(column, row) = 1 + 10 * row + column;
    }
  }
  lattice.reserve({-5, -1, 3, 6});
  for (int row = lattice.box().low_row; row < lattice.box().end_row; ++row) {
    for (int column = lattice.box().low_column; column < lattice.box().end_column; ++column) {
      const bool old = column >= 0 && row >= 0 && column < 4 && row < 4;
      ASSERT_EQ(lattice.at(column, row), old ? 1 + 10 * row + column : 0) << column << ' ' << row;
      ASSERT_EQ(lattice.row(row)[column - lattice.box().low_column], lattice.at(column, row));
    }
  }
  EXPECT_EQ(lattice.at(-100, 0), 0);
}

}  // namespace
}  // namespace panoptes
