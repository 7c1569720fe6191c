// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/relative_motion.h"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "core/motion/motion_by_rig.h"
#include "core/motion/triangulation.h"
#include "tests/core/vision/synthetic_places.h"

namespace panoptes {
namespace {

using testing::front_and_back;
using testing::SyntheticRoom;

const FeatureOptions kFeatures;
const MotionOptions kMotion;
const PlaceDepths kNoDepths;
constexpr double kPi = std::numbers::pi;

Mat3 diagonal(double sigma_m, double sigma_rad) {
  return Vec3(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad).asDiagonal();
}

struct Errors {
  double m = 0;
  double rad = 0;
};

Errors error_of(const Pose2& estimate, const Pose2& truth) {
  return {(estimate.position() - truth.position()).norm(),
          std::abs(wrap_angle(estimate.theta_rad - truth.theta_rad))};
}

// A keyframe's depths from two neighbours on either side, a quarter of a metre apart.
PlaceDepths depths_at(const SyntheticRoom& room, const LoopCameras& cameras,
                      const Pose2& T_map_here, const PlaceFeatures& here, Rng rng) {
  std::vector<PlaceFeatures> there;
  std::vector<Neighbour> neighbours;
  const std::array<double, 4> position_m{-0.5, -0.25, 0.25, 0.5};
  there.reserve(position_m.size());
  for (const double x_m : position_m) {
    there.push_back(room.seen_from(cameras, T_map_here * Pose2{x_m, 0, 0}, 0.7, 0.15,
                                   rng.fork(std::to_string(x_m))));
  }
  for (std::size_t i = 0; i < there.size(); ++i) {
    neighbours.push_back(
        {cameras,
         there[i],
         {position_m[i] + rng.normal(0, 0.002), rng.normal(0, 0.002), rng.normal(0, 0.002)}});
  }
  return triangulate(kFeatures, kMotion, cameras, here, neighbours);
}

class RevisitedPlace : public ::testing::TestWithParam<bool> {};

TEST_P(RevisitedPlace, PoseIsFoundWithItsTranslation) {
  const bool opposite = GetParam();
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(2500, 4, Rng(3));
  Rng rng(4);
  double sum2_m = 0;
  double sum2_rad = 0;
  double normalised2 = 0;
  constexpr int kTrials = 20;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Pose2 T_map_a{rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-kPi, kPi)};
    const Pose2 T_a_b{rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3),
                      (opposite ? kPi : 0) + rng.uniform(-0.25, 0.25)};
    const Pose2 T_map_b = T_map_a * T_a_b;
    const Rng draw = rng.fork(std::to_string(trial));
    const PlaceFeatures a = room.seen_from(cameras, T_map_a, 0.7, 0.3, draw.fork("a"));
    const PlaceFeatures b = room.seen_from(cameras, T_map_b, 0.7, 0.3, draw.fork("b"));
    const MotionPrior prior{{0, 0, opposite ? kPi : 0}, diagonal(0.3, 0.2)};
    Rng search = draw.fork("search");
    const PlaceDepths depths_a = depths_at(room, cameras, T_map_a, a, draw.fork("depths a"));
    const PlaceDepths depths_b = depths_at(room, cameras, T_map_b, b, draw.fork("depths b"));
    const auto motion = motion_by_features(
        kMotion, {cameras, a, depths_a}, {cameras, b, depths_b},
        match_places(kFeatures, a, b, facings(cameras)[opposite ? 1 : 0]), prior, &search);
    ASSERT_TRUE(motion);
    EXPECT_GT(motion->inliers, 0.4 * motion->matches);
    EXPECT_GT(motion->inliers_by_camera[0], 0);
    EXPECT_GT(motion->inliers_by_camera[1], 0);
    const Errors error = error_of(motion->T_a_b_seen, T_a_b);
    sum2_m += error.m * error.m;
    sum2_rad += error.rad * error.rad;
    const Vec3 off(motion->T_a_b_seen.x_m - T_a_b.x_m, motion->T_a_b_seen.y_m - T_a_b.y_m,
                   wrap_angle(motion->T_a_b_seen.theta_rad - T_a_b.theta_rad));
    normalised2 += off.dot(motion->information_seen * off) / 3;
  }
  EXPECT_LT(std::sqrt(sum2_m / kTrials), 0.03);
  EXPECT_LT(rad_to_deg(std::sqrt(sum2_rad / kTrials)), 0.3);
  EXPECT_LT(normalised2 / kTrials, 3);
  RecordProperty("rms_m", std::to_string(std::sqrt(sum2_m / kTrials)));
  RecordProperty("rms_deg", std::to_string(rad_to_deg(std::sqrt(sum2_rad / kTrials))));
  RecordProperty("normalised", std::to_string(normalised2 / kTrials));
}

TEST_P(RevisitedPlace, EachCameraFindsThePoseAlone) {
  const bool opposite = GetParam();
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(2500, 4, Rng(3));
  const Pose2 T_map_a{0.4, -0.7, 0.3};
  const Pose2 T_a_b{0.2, -0.1, (opposite ? kPi : 0) + 0.1};
  const PlaceFeatures a = room.seen_from(cameras, T_map_a, 0.7, 0.3, Rng(5));
  const PlaceFeatures b = room.seen_from(cameras, T_map_a * T_a_b, 0.7, 0.3, Rng(6));
  const PlaceDepths depths_a = depths_at(room, cameras, T_map_a, a, Rng(7));
  const PlaceDepths depths_b = depths_at(room, cameras, T_map_a * T_a_b, b, Rng(8));
  const std::vector<PlaceMatch> matches =
      match_places(kFeatures, a, b, facings(cameras)[opposite ? 1 : 0]);
  const MotionPrior near{T_a_b * Pose2{0.05, 0.05, 0.02}, diagonal(0.3, 0.2)};
  const auto alone =
      motion_by_each_camera(kMotion, {cameras, a, depths_a}, {cameras, b, depths_b}, matches, near);
  for (int camera = 0; camera < 2; ++camera) {
    ASSERT_TRUE(alone[camera]);
    EXPECT_EQ(alone[camera]->inliers_by_camera[1 - camera], 0);
    const Errors error = error_of(alone[camera]->T_a_b_seen, T_a_b);
    EXPECT_LT(error.m, 0.05);
    EXPECT_LT(rad_to_deg(error.rad), 0.5);
  }
  // without the back camera's matches the front's answer is the same: it is its own
  std::vector<PlaceMatch> front;
  for (const PlaceMatch& match : matches) {
    if (match.camera_a == 0) {
      front.push_back(match);
    }
  }
  const auto again =
      motion_by_each_camera(kMotion, {cameras, a, depths_a}, {cameras, b, depths_b}, front, near);
  EXPECT_EQ(again[0]->T_a_b_seen, alone[0]->T_a_b_seen);
  EXPECT_FALSE(again[1]);
}

INSTANTIATE_TEST_SUITE_P(SameAndOpposite, RevisitedPlace, ::testing::Values(false, true));

TEST(RelativeMotion, GivesTheSameBitsAgain) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1500, 4, Rng(5));
  const PlaceFeatures a = room.seen_from(cameras, {0, 0, 0}, 0.7, 0.3, Rng(6));
  const PlaceFeatures b = room.seen_from(cameras, {0.2, 0.1, 0.1}, 0.7, 0.3, Rng(7));
  const MotionPrior prior{{0, 0, 0}, diagonal(0.3, 0.2)};
  Rng one(8);
  Rng two(8);
  const auto matches = match_places(kFeatures, a, b, same_facing(cameras));
  const auto first = motion_by_features(kMotion, {cameras, a, kNoDepths}, {cameras, b, kNoDepths},
                                        matches, prior, &one);
  const auto second = motion_by_features(kMotion, {cameras, a, kNoDepths}, {cameras, b, kNoDepths},
                                         matches, prior, &two);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_a_b, second->T_a_b);
  EXPECT_EQ(first->information_seen, second->information_seen);
}

TEST(RelativeMotion, RefusesWhatHasNothingInCommon) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom here(2500, 4, Rng(9));
  const SyntheticRoom elsewhere(2500, 4, Rng(10));
  const PlaceFeatures a = here.seen_from(cameras, {0, 0, 0}, 0.7, 0, Rng(11));
  const PlaceFeatures b = elsewhere.seen_from(cameras, {0, 0, 0}, 0.7, 0, Rng(12));
  const MotionPrior wheels{{0.25, 0, 0}, diagonal(0.002, 0.01)};
  const auto matches = match_places(kFeatures, a, b, same_facing(cameras));
  EXPECT_FALSE(motion_by_features(kMotion, {cameras, a, kNoDepths}, {cameras, b, kNoDepths},
                                  matches, wheels, nullptr));
}

TEST(Triangulate, ANeighbourThatNobodyKnowsWhereItIsTellsNoDepth) {
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(1500, 4, Rng(1));
  const PlaceFeatures here = room.seen_from(cameras, {0, 0, 0}, 0.7, 0.15, Rng(2));
  const PlaceFeatures there = room.seen_from(cameras, {0.25, 0, 0}, 0.7, 0.15, Rng(3));
  const PlaceDepths depths =
      triangulate(kFeatures, kMotion, cameras, here, {{cameras, there, {std::nan(""), 0, 0}}});
  for (const std::vector<InverseDepth>& of_camera : depths) {
    for (const InverseDepth& depth : of_camera) {
      ASSERT_EQ(depth.mean_per_m, InverseDepth().mean_per_m);
      ASSERT_EQ(depth.sigma_per_m, InverseDepth().sigma_per_m);
    }
  }
}

// A third camera sees what the two do not, and makes the motion surer.
TEST(RelativeMotion, TakesAnyNumberOfCameras) {
  const Pose2 T_a_b{0.3, 0.05, 0.1};
  const SyntheticRoom room(400, 3, Rng(4));
  LoopCameras cameras = front_and_back();
  cameras.push_back({"left", "left", cameras[0].intrinsics,
                     mounted_camera({0, 0.1, 0.75}, std::numbers::pi / 2, 0)});
  const MotionPrior prior{T_a_b * Pose2{0.03, -0.02, 0.02}, Vec3(0.01, 0.01, 0.01).asDiagonal()};
  std::vector<double> sigmas_rad;
  for (const std::size_t count : {2, 3}) {
    const LoopCameras used(cameras.begin(), cameras.begin() + static_cast<std::ptrdiff_t>(count));
    const PlaceFeatures a = room.seen_from(used, {}, 0.7, 0.1, Rng(6));
    const PlaceFeatures b = room.seen_from(used, T_a_b, 0.7, 0.1, Rng(7));
    const auto matches = match_places(FeatureOptions(), a, b, same_facing(used));
    const auto motion = motion_by_features(kMotion, {used, a, kNoDepths}, {used, b, kNoDepths},
                                           matches, prior, nullptr);
    ASSERT_TRUE(motion);
    ASSERT_EQ(motion->inliers_by_camera.size(), count);
    EXPECT_GT(motion->inliers_by_camera.back(), 0);
    EXPECT_NEAR(motion->T_a_b.theta_rad, T_a_b.theta_rad, 0.01);
    sigmas_rad.push_back(std::sqrt(motion->covariance(2, 2)));
    EXPECT_EQ(triangulate(FeatureOptions(), kMotion, used, a, {{used, b, T_a_b}}).size(), count);
    for (const PlaceMatch& match : match_places(FeatureOptions(), a, b, facings(used)[1])) {
      EXPECT_EQ(match.camera_b, 1 - match.camera_a);
    }
  }
  EXPECT_LT(sigmas_rad[1], sigmas_rad[0]);
}

// What a camera that is mounted otherwise than believed makes of a motion is what the derivative
// says.
TEST(MotionByRig, SaysWhatAWrongMountingDoes) {
  const LoopCameras believed = front_and_back();
  const SyntheticRoom room(2500, 3, Rng(3));
  const Pose2 T_map_a{0.4, -0.7, 0.3};
  for (const bool opposite : {false, true}) {
    const Pose2 T_a_b{0.1, -0.05, (opposite ? kPi : 0) + 0.1};
    for (const int k : {kRotation + 2, static_cast<int>(kPosition), kPosition + 1,
                        static_cast<int>(kHeight), camera_state(1) + kRotation + 2}) {
      RigState truth = RigState::Zero(rig_states(believed.size()));
      truth[k] = 0.01;
      const LoopCameras cameras = corrected(believed, truth);
      const PlaceFeatures a = room.seen_from(cameras, T_map_a, 0.05, 0, Rng(5));
      const PlaceFeatures b = room.seen_from(cameras, T_map_a * T_a_b, 0.05, 0, Rng(6));
      const PlaceDepths depths_a = depths_at(room, cameras, T_map_a, a, Rng(7));
      const PlaceDepths depths_b = depths_at(room, cameras, T_map_a * T_a_b, b, Rng(8));
      const auto matches = match_places(kFeatures, a, b, facings(believed)[opposite ? 1 : 0]);
      const MotionPrior prior{T_a_b, diagonal(0.3, 0.2)};
      const auto with = [&](const LoopCameras& used) {
        return motion_by_features(kMotion, {used, a, depths_a}, {used, b, depths_b}, matches, prior,
                                  nullptr);
      };
      const auto right = with(cameras);
      const auto wrong = with(believed);
      ASSERT_TRUE(right && wrong);
      const PictureTimes together{{}, std::vector<double>(believed.size(), 0)};
      const RigState none = RigState::Zero(truth.size());
      const Eigen::MatrixXd by_state =
          motion_by_rig(kMotion, believed, none, {together, a, depths_a}, {together, b, depths_b},
                        wrong->inlier_matches, wrong->T_a_b_seen);
      const Vec3 told = by_state * truth;
      EXPECT_NEAR(right->T_a_b_seen.x_m - wrong->T_a_b_seen.x_m, told.x(), 0.004) << k;
      EXPECT_NEAR(right->T_a_b_seen.y_m - wrong->T_a_b_seen.y_m, told.y(), 0.004) << k;
      EXPECT_NEAR(wrap_angle(right->T_a_b_seen.theta_rad - wrong->T_a_b_seen.theta_rad), told.z(),
                  0.002)
          << k;
    }
  }
}

// A robot whose wheels are larger than believed maps a larger room: what it sees of a motion again
// is larger by as much, whichever cameras show it, if how high they stand is no surer than it is.
TEST(MotionByRig, AMotionGrowsWithTheDepthsThatShowIt) {
  constexpr double kLarger = 0.02;
  const LoopCameras cameras = front_and_back();
  const SyntheticRoom room(2500, 3, Rng(3));
  const Pose2 T_map_a{0.4, -0.7, 0.3};
  for (const bool opposite : {false, true}) {
    const Pose2 T_a_b{0.2, -0.15, (opposite ? kPi : 0) + 0.1};
    const PlaceFeatures a = room.seen_from(cameras, T_map_a, 0.05, 0, Rng(5));
    const PlaceFeatures b = room.seen_from(cameras, T_map_a * T_a_b, 0.05, 0, Rng(6));
    PlaceDepths depths_a = depths_at(room, cameras, T_map_a, a, Rng(7));
    PlaceDepths depths_b = depths_at(room, cameras, T_map_a * T_a_b, b, Rng(8));
    const auto matches = match_places(kFeatures, a, b, facings(cameras)[opposite ? 1 : 0]);
    const auto motion = [&] {
      return motion_by_features(kMotion, {cameras, a, depths_a}, {cameras, b, depths_b}, matches,
                                {T_a_b, diagonal(0.3, 0.2)}, nullptr);
    };
    const auto before = motion();
    ASSERT_TRUE(before);
    const PictureTimes together{{}, std::vector<double>(cameras.size(), 0)};
    const Vec3 told = motion_by_rig(kMotion, cameras, RigState::Zero(rig_states(cameras.size())),
                                    {together, a, depths_a}, {together, b, depths_b},
                                    before->inlier_matches, before->T_a_b_seen)
                          .col(wheel_state(cameras.size()) + kWheelScale);
    if (!opposite) {
      EXPECT_NEAR((told.head<2>() - before->T_a_b_seen.position()).norm(), 0,
                  0.05 * T_a_b.position().norm());
    }
    for (PlaceDepths* depths : {&depths_a, &depths_b}) {
      for (std::vector<InverseDepth>& of_camera : *depths) {
        for (InverseDepth& depth : of_camera) {
          depth.mean_per_m /= 1 + kLarger;
          depth.sigma_per_m /= 1 + kLarger;
        }
      }
    }
    const auto after = motion();
    ASSERT_TRUE(after);
    EXPECT_NEAR(after->T_a_b_seen.x_m - before->T_a_b_seen.x_m, kLarger * told.x(), 0.002);
    EXPECT_NEAR(after->T_a_b_seen.y_m - before->T_a_b_seen.y_m, kLarger * told.y(), 0.002);
  }
}

}  // namespace
}  // namespace panoptes
