// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/progress.h"

#include <gtest/gtest.h>

namespace panoptes {
namespace {

TEST(Progress, TellsTheTimeLeftFromThePaceSoFar) {
  EXPECT_EQ(progress_line(60, 600, 20), "1:00 of 10:00 (10 %), 3:00 left");
  EXPECT_EQ(progress_line(600, 600, 200), "10:00 of 10:00 (100 %), 0:00 left");
}

TEST(Progress, PromisesNothingAtTheStart) {
  EXPECT_EQ(progress_line(0, 600, 0), "0:00 of 10:00 (0 %)");
  EXPECT_EQ(progress_line(1, 600, 3), "0:01 of 10:00 (0 %)");
  EXPECT_EQ(share_line("light and shadow", 0.01, 2), "light and shadow: 1 %");
  EXPECT_EQ(share_line("light and shadow", 0.5, 2), "light and shadow: 50 %, 0:02 left");
}

TEST(Progress, SaysNothingWhenQuietOrBeforeALineIsDue) {
  testing::internal::CaptureStderr();
  {
    Progress quiet(from_seconds(600), true);
    quiet.show(time_at(1), "mapping");
    Progress early(from_seconds(600), false);
    early.show(time_at(1), "mapping");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace panoptes
