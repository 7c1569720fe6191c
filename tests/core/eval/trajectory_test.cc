// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/trajectory.h"

#include <cmath>

#include <gmock/gmock.h>

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-12;

TruePose true_pose(double t_s, const Pose2& T) { return {time_at(t_s), T, {}, 1}; }

TEST(TruePoseAt, LiesBetweenFrameSets) {
  const std::vector<TruePose> poses = {true_pose(1, {0, 0, deg_to_rad(170)}),
                                       true_pose(2, {1, 2, deg_to_rad(-170)})};
  EXPECT_EQ(true_pose_at(poses, time_at(1)), poses[0].T_scene_body);
  EXPECT_EQ(true_pose_at(poses, time_at(0)), poses[0].T_scene_body);
  EXPECT_EQ(true_pose_at(poses, time_at(9)), poses[1].T_scene_body);
  const Pose2 between = true_pose_at(poses, time_at(1.25));
  EXPECT_NEAR(between.x_m, 0.25, kRoundoff);
  EXPECT_NEAR(between.y_m, 0.5, kRoundoff);
  EXPECT_NEAR(between.theta_rad, deg_to_rad(175), kRoundoff);  // the short way round
}

TEST(TrueKeyframes, AreTakenAtTheirInstants) {
  Truth truth;
  truth.poses = {true_pose(0, {0, 0, 0}), true_pose(1, {1, 0, 0}), true_pose(2, {5, 0, 0})};
  const auto poses = true_keyframes({{time_at(0), {}, {}}, {time_at(2), {}, {}}}, truth);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[1].x_m, 5);
}

TEST(PathError, ComparesPositionsWithoutAlignment) {
  const std::vector<Pose2> truth = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  const std::vector<Pose2> shifted = {{0, 0, 1}, {1, 0.3, 0}, {2, 0.4, 0}, {3, 0, 0}};
  const PathError error = path_error(shifted, truth);
  EXPECT_NEAR(error.rmse_m, 0.25, kRoundoff);  // sqrt((0.09 + 0.16) / 4)
  EXPECT_NEAR(error.max_m, 0.4, kRoundoff);
  EXPECT_EQ(path_error({}, {}).rmse_m, 0);
}

TEST(RotatedError, ForgivesOneRotationAboutTheStart) {
  const Vec2 start(1, 2);
  const std::vector<Pose2> truth = {{1, 2, 0}, {2, 2, 0}, {3, 4, 0}, {0, 5, 0}};
  std::vector<Pose2> turned;
  for (const Pose2& pose : truth) {
    const Vec2 p = start + Pose2{0, 0, 0.3} * Vec2(pose.position() - start);
    turned.push_back({p.x(), p.y(), 0.3});
  }
  EXPECT_GT(path_error(turned, truth).rmse_m, 0.3);
  EXPECT_NEAR(rotated_rmse_m(turned, truth, start), 0, kRoundoff);
  turned[1].x_m += 0.1;
  EXPECT_GT(rotated_rmse_m(turned, truth, start), 0.02);
  EXPECT_EQ(rotated_rmse_m({}, {}, start), 0);
}

// Wheels that tell 2 % too much of the way, and turn by 0.01 rad in each metre.
TEST(OdometryError, IsOfStretchesOfAMetreAndOfTheHeadingAtItsWorst) {
  std::vector<Pose2> truth{{1, 2, deg_to_rad(30)}};
  std::vector<Pose2> wheels{{-3, 0, deg_to_rad(-100)}};
  for (int i = 0; i < 50; ++i) {
    truth.push_back(truth.back() * Pose2{0.1, 0, 0});
    wheels.push_back(wheels.back() * exp_twist({0.102, 0.001}, 1));
  }
  const OdometryError error = odometry_error(wheels, truth);
  ASSERT_TRUE(error.share);
  EXPECT_NEAR(*error.share, std::hypot(0.02, 0.0051), 1e-4);  // half of the turn, to first order
  EXPECT_NEAR(error.heading_rad, 0.05, kRoundoff);
}

TEST(OdometryError, HasNoShareOfAWayThatIsShort) {
  const std::vector<Pose2> truth{{0, 0, 0}, {0.5, 0, 0}, {0.5, 0, 3}};
  const OdometryError error = odometry_error(truth, truth);
  EXPECT_FALSE(error.share);
  EXPECT_NEAR(error.heading_rad, 0, kRoundoff);
}

TEST(Checkpoints, BeginWithTheFarthestAndSpread) {
  // keyframes at 0, 0.5, ... 6 m from the start: 1.5 and farther are candidates
  std::vector<Pose2> truth;
  std::vector<Pose2> estimate;
  for (int i = 0; i <= 12; ++i) {
    truth.push_back({0.5 * i, 0, 0});
    estimate.push_back({0.5 * i, 0.01 * i, 0});
  }
  const auto chosen = checkpoints(estimate, truth, {0, 0});
  ASSERT_TRUE(chosen);
  // 6 m; then 1.5 m, 4.5 m from it; then 3.5 m before 4 m, both 2 m and more away; then what halves
  EXPECT_THAT(chosen->keyframes, testing::ElementsAre(12, 3, 7, 5, 9, 4, 6, 8));
  EXPECT_NEAR(chosen->error_max_m, 0.12, kRoundoff);
  EXPECT_NEAR(chosen->error_mean_m, 0.01 * (12 + 3 + 7 + 5 + 9 + 4 + 6 + 8) / 8, kRoundoff);
}

TEST(Checkpoints, AreAbsentBelowEight) {
  std::vector<Pose2> truth;
  for (int i = 0; i < 30; ++i) {
    truth.push_back({i < 22 ? 0.9 : 2.0 + i, 0, 0});  // eight beyond 1 m, then seven
  }
  EXPECT_TRUE(checkpoints(truth, truth, {0, 0}));
  truth[29] = truth[0];
  EXPECT_FALSE(checkpoints(truth, truth, {0, 0}));
}

TEST(Checkpoints, NeverTakeOneKeyframeTwice) {
  const std::vector<Pose2> truth(9, Pose2{5, 0, 0});
  const auto chosen = checkpoints(truth, truth, {0, 0});
  ASSERT_TRUE(chosen);
  EXPECT_THAT(chosen->keyframes, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
}

}  // namespace
}  // namespace panoptes
