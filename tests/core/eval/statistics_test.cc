// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/statistics.h"

#include <cmath>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kTable = 1e-3;  // of the printed table of Student's t

TEST(Quantile, IsLinearBetweenNeighbours) {
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 0.5), 2.5);
  EXPECT_EQ(quantile({10, 0}, 0.95), 9.5);
  EXPECT_EQ(quantile({7}, 0.99), 7);
  EXPECT_EQ(quantile({1, 5}, 1), 5);
}

TEST(MeanInterval, IsStudents) {
  const MeanInterval five = mean_interval({1, 2, 3, 4, 5});
  EXPECT_EQ(five.mean, 3);
  EXPECT_EQ(five.count, 5);
  EXPECT_NEAR(five.high - five.mean, 2.776 * std::sqrt(2.5 / 5), kTable);
  EXPECT_NEAR(five.mean - five.low, 2.776 * std::sqrt(2.5 / 5), kTable);
}

TEST(MeanInterval, OfOneValueIsTheValue) {
  const MeanInterval one = mean_interval({4});
  EXPECT_EQ(one.low, 4);
  EXPECT_EQ(one.high, 4);
}

TEST(MeanInterval, OfManyApproachesTheNormalLaw) {
  std::vector<double> values;
  for (int i = 0; i < 61; ++i) {
    values.push_back(i % 2 == 0 ? 1 : -1);
  }
  const MeanInterval many = mean_interval(values);
  const double spread = std::sqrt((61.0 - 1.0 / 61) / 60 / 61);
  EXPECT_NEAR((many.high - many.mean) / spread, 2.0003, kTable);  // t of 60 degrees of freedom
}

}  // namespace
}  // namespace panoptes
