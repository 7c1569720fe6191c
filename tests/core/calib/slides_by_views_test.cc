// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/slides_by_views.h"

#include <cmath>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(SlidesByViews, AreOfHowMuchNearerAndHowFarAsideItIsThanOnTheMean) {
  // A point 2 m ahead: from there, from half as near, and from 0.2 m aside.
  const std::vector<RigSeen> seen(3);
  const auto by = slides_by_views(seen, {{2, 0, 0}, {1, 0, 0}, {2, 0.2, 0}}, 1);
  ASSERT_EQ(by.size(), 3U);
  EXPECT_LT((by[0] + by[1] + by[2]).norm(), 1e-12);
  const BySlides nearer = by[1] - by[0];
  EXPECT_NEAR(nearer.col(0).norm(), std::log(2.0), 1e-12);
  EXPECT_NEAR(nearer.col(1).norm(), std::log(2.0), 1e-12);
  EXPECT_LT(nearer.rightCols<2>().norm(), 1e-12);
  EXPECT_NEAR((by[2] - by[0]).col(2).norm(), 0.1, 0.002);
  EXPECT_NEAR(std::abs(nearer(2, 1)), std::log(2.0), 1e-12) << "upright";
  EXPECT_LT(std::abs(nearer(2, 0)), 1e-12) << "horizontally";
}

TEST(SlidesByViews, AreTheSameInAnotherMetre) {
  const std::vector<RigSeen> seen(2);
  const auto by = slides_by_views(seen, {{2, 0, 0.3}, {1, 0.1, 0.2}}, 1);
  const auto longer = slides_by_views(seen, {{6, 0, 0.9}, {3, 0.3, 0.6}}, 1);
  EXPECT_LT((by[0] - longer[0]).norm() + (by[1] - longer[1]).norm(), 1e-12);
}

TEST(SlidesByViews, AreByWhatIsBelievedAndNoneWhereNothingIs) {
  std::vector<RigSeen> seen(3);
  seen[1].believed = false;
  seen[2].point = 1;
  seen[2].believed = false;
  const auto by = slides_by_views(seen, {{2, 0, 0}, {1, 0, 0}, {3, 0, 0}}, 2);
  EXPECT_EQ(by[0].norm(), 0);
  EXPECT_NEAR(by[1].col(0).norm(), std::log(2.0), 1e-12);
  EXPECT_EQ(by[2].norm(), 0);
}

}  // namespace
}  // namespace panoptes
