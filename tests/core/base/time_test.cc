// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/time.h"

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(Time, CountsNanosecondsExactly) {
  EXPECT_EQ(time_at(0.1).time_since_epoch().count(), 100000000);
  EXPECT_EQ(from_seconds(-1.5).count(), -1500000000);
  EXPECT_EQ(to_seconds(time_at(2.25)), 2.25);
  // adding a step a million times loses nothing
  Time t;
  for (int i = 0; i < 1000000; ++i) {
    t += std::chrono::microseconds(1);
  }
  EXPECT_EQ(to_seconds(t), 1);
}

}  // namespace
}  // namespace panoptes
