// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/drive.h"

#include <functional>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

/// One pose a second.
std::vector<TruePose> drive(int seconds, const std::function<double(int)>& x_m) {
  std::vector<TruePose> poses;
  for (int t = 0; t <= seconds; ++t) {
    poses.push_back({time_at(t), {x_m(t), 0, 0}, {}, 1.0});
  }
  return poses;
}

std::vector<bool> always(const std::vector<TruePose>& poses) {
  return std::vector<bool>(poses.size(), true);
}

TEST(Contacts, CountByWhoMoved) {
  Truth truth;
  truth.contacts = {{time_at(1), {0, 0}, "desk", true},
                    {time_at(5), {0, 0}, "person", false},
                    {time_at(9), {0, 0}, "desk", true}};
  EXPECT_EQ(collisions(truth), 2);
  EXPECT_EQ(collisions_while_stopped(truth), 1);
}

TEST(Clearance, IsTheSmallest) {
  Truth truth;
  EXPECT_FALSE(min_clearance_m(truth));
  truth.poses = {{time_at(0), {}, {}, 0.7}, {time_at(1), {}, {}, 0.12}, {time_at(2), {}, {}, 0.3}};
  EXPECT_EQ(min_clearance_m(truth), 0.12);
}

TEST(Stuck, IsAllOfTheTimeWithoutProgress) {
  // 0.1 m/s for 50 s, 70 s at rest, and on; the metre or so about the stop belongs to it by 0.5 m
  const auto poses = drive(170, [](int t) { return 0.1 * (t < 50 ? t : t < 120 ? 50 : t - 70); });
  // any pose of the rest and the 4 s on either side that are within 0.5 m of it
  EXPECT_DOUBLE_EQ(stuck_s(poses, always(poses)), 78);
  EXPECT_FALSE(ends_stuck(poses, always(poses)));
}

TEST(Stuck, NeedsAWholeMinute) {
  const auto poses = drive(59, [](int) { return 0.0; });
  EXPECT_DOUBLE_EQ(stuck_s(poses, always(poses)), 0);
  const auto longer = drive(60, [](int) { return 0.0; });
  EXPECT_DOUBLE_EQ(stuck_s(longer, always(longer)), 60);
}

TEST(Stuck, NeedsAGoalThroughout) {
  const auto poses = drive(100, [](int) { return 0.0; });
  std::vector<bool> has_goal = always(poses);
  has_goal[50] = false;
  EXPECT_DOUBLE_EQ(stuck_s(poses, has_goal), 0);
  has_goal[50] = true;
  has_goal[10] = false;
  EXPECT_DOUBLE_EQ(stuck_s(poses, has_goal), 89);
  EXPECT_TRUE(ends_stuck(poses, has_goal));
  has_goal[90] = false;
  EXPECT_FALSE(ends_stuck(poses, has_goal));
}

TEST(Stuck, IsNotSlowDriving) {
  const auto poses = drive(300, [](int t) { return 0.01 * t; });
  EXPECT_DOUBLE_EQ(stuck_s(poses, always(poses)), 0);
}

TEST(Stuck, IsMovingToAndFro) {
  const auto poses = drive(100, [](int t) { return t % 2 == 0 ? 0.0 : 0.2; });
  EXPECT_DOUBLE_EQ(stuck_s(poses, always(poses)), 100);
}

}  // namespace
}  // namespace panoptes
