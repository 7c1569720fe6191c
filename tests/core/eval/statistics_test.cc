// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/statistics.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/rng.h"

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

TEST(PairedDifference, ShowsWhatSeedsHideFromEachOther) {
  // They differ by more than what is sought.
  const std::vector<double> values{10.1, 20.2, 30.1, 40.2};
  const std::vector<double> others{10, 20, 30, 40};
  const PairedDifference more = paired_difference(values, others);
  EXPECT_NEAR(more.mean.mean, 0.15, 1e-12);
  EXPECT_TRUE(more.shows());
  const PairedDifference less = paired_difference(others, values);
  EXPECT_NEAR(less.mean.high, -more.mean.low, 1e-12);
  EXPECT_TRUE(less.shows());
}

TEST(PairedDifference, TellsWhatItCouldHaveSeen) {
  Rng rng(1);
  constexpr int kRuns = 8;
  const PairedDifference of_one = paired_difference({3}, {1});
  EXPECT_EQ(of_one.mean.mean, 2);
  EXPECT_FALSE(of_one.shows());
  EXPECT_TRUE(std::isinf(of_one.detectable));
  // Of many studies of noise 1: how many show nothing where there is nothing, and how many a
  // difference of the size that they call detectable on the mean.
  constexpr int kStudies = 4000;
  int false_alarms = 0;
  int beyond_bound = 0;
  double detectable = 0;
  const auto study = [&](double truth) {
    std::vector<double> values;
    for (int i = 0; i < kRuns; ++i) {
      values.push_back(truth + rng.normal());
    }
    return paired_difference(values, std::vector<double>(kRuns, 0));
  };
  for (int i = 0; i < kStudies; ++i) {
    const PairedDifference nothing = study(0);
    false_alarms += nothing.shows() ? 1 : 0;
    beyond_bound += nothing.at_least > 0 ? 1 : 0;
    beyond_bound += nothing.at_most < 0 ? 1 : 0;
    detectable += nothing.detectable / kStudies;
  }
  int found = 0;
  for (int i = 0; i < kStudies; ++i) {
    found += study(detectable).shows() ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(false_alarms) / kStudies, 0.05, 0.012);
  EXPECT_NEAR(static_cast<double>(beyond_bound) / (2 * kStudies), 0.05, 0.01);
  EXPECT_NEAR(static_cast<double>(found) / kStudies, 0.8, 0.03);
}

TEST(PairedDifference, OfPairsThatAllDifferByTheSame) {
  const PairedDifference same = paired_difference({1, 2}, {1, 2});
  EXPECT_FALSE(same.shows());
  EXPECT_EQ(same.detectable, 0);
  EXPECT_TRUE(paired_difference({2, 3}, {1, 2}).shows());
}

}  // namespace
}  // namespace panoptes
