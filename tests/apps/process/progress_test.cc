// SPDX-License-Identifier: BSD-3-Clause
#include "apps/process/progress.h"

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
  EXPECT_EQ(progress_line(0, 0, 1), "0:00 of 0:00 (100 %)") << "a recording of one instant";
  EXPECT_EQ(share_line("light and shadow", 0.01, 2), "light and shadow: 1 %");
  EXPECT_EQ(share_line("light and shadow", 0.5, 2), "light and shadow: 50 %, 0:02 left");
}

TEST(TimeLeft, IsWhatRunsLikeThoseDoneWouldTake) {
  EXPECT_EQ(time_left_s({}, {5}, 3, 1), std::nullopt);
  EXPECT_EQ(time_left_s({60, 60}, {20}, 0, 1), 40);
  EXPECT_EQ(time_left_s({60, 60}, {20}, 1, 1), 100);
  EXPECT_EQ(time_left_s({60, 60}, {20, 50}, 1, 2), 70);  // where a place is free first
  EXPECT_EQ(time_left_s({60}, {20}, 0, 2), 40);          // two places do not hurry the last run
}

TEST(TimeLeft, IsThatOfTheSlowerOnesForARunThatLasts) {
  EXPECT_EQ(time_left_s({20, 100}, {30}, 0, 1), 70);
  EXPECT_EQ(time_left_s({20, 100}, {120}, 0, 1), std::nullopt);  // never 0:00 while one drives
  EXPECT_EQ(time_left_s({20, 100}, {120}, 1, 1), 60);
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
