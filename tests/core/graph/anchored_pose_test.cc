// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/anchored_pose.h"

#include <vector>

#include <gtest/gtest.h>

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-12;

TEST(AnchoredPose, GoesWhereTheNearestKeyframeGoes) {
  std::vector<Pose2> T_map_keyframes = {{0, 0, 0}, {2, 1, 0.5}, {4, 0, -1}};
  AnchoredPose held({2.3, 1.4, 2}, T_map_keyframes);
  const Pose2 T_keyframe_place = T_map_keyframes[1].inverse() * held.T_map_place();
  T_map_keyframes.push_back({2.3, 1.4, 2});  // a nearer one later does not take it
  T_map_keyframes[1] = {2.5, 0.8, 0.7};
  held.follow(T_map_keyframes);
  const Pose2 wanted = T_map_keyframes[1] * T_keyframe_place;
  EXPECT_NEAR((held.p_map() - wanted.position()).norm(), 0, kRoundoff);
  EXPECT_NEAR(held.T_map_place().theta_rad, wanted.theta_rad, kRoundoff);
}

TEST(AnchoredPose, StaysToTheBitWhileItsKeyframeDoes) {
  std::vector<Pose2> T_map_keyframes = {{0.1, 0.7, 0.3}, {2, 1, 0.5}};
  AnchoredPose held({0.3, 0.4, 2}, T_map_keyframes);
  T_map_keyframes[1] = {7, 7, 1};
  held.follow(T_map_keyframes);
  EXPECT_EQ(held.T_map_place(), (Pose2{0.3, 0.4, 2}));
}

TEST(AnchoredPose, StaysWithoutKeyframes) {
  AnchoredPose held({0.3, 0.4, 2}, {});
  held.follow(std::vector<Pose2>{{9, 9, 1}});
  EXPECT_EQ(held.T_map_place(), (Pose2{0.3, 0.4, 2}));
}

}  // namespace
}  // namespace panoptes
