// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/motion_information.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

const Pose2 kDriven{0.25, 0, 0};
const Pose2 kTurned{0, 0, deg_to_rad(15)};

RigCamera camera_of(const std::string& role, double yaw_deg, double tilt_deg, const Vec3& eye) {
  RigCamera camera;
  camera.roles = {role};
  camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
  camera.T_body_camera = mounted_camera(eye, deg_to_rad(yaw_deg), deg_to_rad(tilt_deg));
  if (role == "floor") {
    camera.floor.emplace();
  }
  return camera;
}

Rig rig_of(const std::vector<RigCamera>& cameras) {
  Rig rig;
  for (const RigCamera& camera : cameras) {
    rig.cameras["camera" + std::to_string(rig.cameras.size())] = camera;
  }
  return rig;
}

Mat3 information_of(const Rig& rig, const Pose2& motion, const MotionInformationOptions& o = {}) {
  const RigSight sight(rig, Body());
  return motion_information(o, sight, motion).of(~CameraSet{0});
}

TEST(MotionInformation, OfOneCameraTellsNoLengthsUnlessItSeesTheFloor) {
  const RigCamera front = camera_of("loop_front", 0, 0, {0, 0, 0.7});
  const MotionSigma by_front = motion_sigma(information_of(rig_of({front}), kDriven));
  EXPECT_FALSE(by_front.ahead_m.has_value());
  ASSERT_TRUE(by_front.heading_rad.has_value());
  EXPECT_LT(*by_front.heading_rad, deg_to_rad(0.2));
  const RigCamera floor = camera_of("floor", 0, 28, {0.02, 0, 0.75});
  const MotionSigma by_both = motion_sigma(information_of(rig_of({front, floor}), kDriven));
  ASSERT_TRUE(by_both.ahead_m.has_value());
  EXPECT_LT(*by_both.ahead_m, 0.002);
  EXPECT_LT(*by_both.heading_rad, *by_front.heading_rad);
}

TEST(MotionInformation, OfATurnOnTheSpotTellsLengthsByALeverArm) {
  const Rig on_axis = rig_of({camera_of("loop_front", 0, 0, {0, 0, 0.7})});
  const Rig off_axis = rig_of({camera_of("loop_front", 0, 0, {0.2, 0, 0.7})});
  const double heading_on = motion_sigma(information_of(on_axis, kTurned)).heading_rad.value_or(1);
  const double heading_off =
      motion_sigma(information_of(off_axis, kTurned)).heading_rad.value_or(1);
  EXPECT_LT(heading_on, deg_to_rad(0.1));
  EXPECT_GT(heading_off, heading_on);  // depths, which are not known, move what is seen
}

TEST(MotionInformation, GrowsWithEachCamera) {
  std::vector<RigCamera> cameras;
  Mat3 before = Mat3::Zero();
  for (const double yaw_deg : {0.0, 180.0, 90.0}) {
    cameras.push_back(camera_of("loop_a", yaw_deg, 0, {0, 0, 0.5 + 0.1 * cameras.size()}));
    const Mat3 now = information_of(rig_of(cameras), kDriven);
    const double least = Eigen::SelfAdjointEigenSolver<Mat3>(now - before).eigenvalues().minCoeff();
    EXPECT_GE(least, -1e-9 * now.norm());
    before = now;
  }
}

TEST(MotionInformation, IsNoneOfCamerasWithoutARoleForIt) {
  const Rig rig = rig_of({camera_of("corner", 0, 0, {0, 0, 0.7})});
  EXPECT_TRUE(information_of(rig, kDriven).isZero(0));
  const MotionSigma nothing = motion_sigma(information_of(rig, kDriven));
  EXPECT_FALSE(nothing.ahead_m || nothing.aside_m || nothing.heading_rad);
}

TEST(MotionInformation, FollowsTheNoiseAndTheNumberOfFeatures) {
  const Rig rig = rig_of({camera_of("floor", 0, 28, {0.02, 0, 0.75})});
  MotionInformationOptions noisy;
  noisy.feature_sigma_px = 1.5;
  MotionInformationOptions few;
  few.features = 50;
  const double sigma = motion_sigma(information_of(rig, kDriven)).heading_rad.value_or(0);
  constexpr double kPrior = 1e-4;  // relative: what stands for nothing known counts a little
  EXPECT_NEAR(motion_sigma(information_of(rig, kDriven, noisy)).heading_rad.value_or(0) / sigma, 3,
              3 * kPrior);
  EXPECT_NEAR(motion_sigma(information_of(rig, kDriven, few)).heading_rad.value_or(0) / sigma,
              std::sqrt(3.0), 2 * kPrior);
}

// Features on the floor that are seen with noise, and the motion fitted to them: its scatter is
// what was promised.
TEST(MotionInformation, IsWhatAFitToNoisyFeaturesHas) {
  const RigCamera camera = camera_of("floor", 0, 28, {0.02, 0, 0.75});
  const Rig rig = rig_of({camera});
  const RigSight sight(rig, Body());
  MotionInformationOptions options;
  const MotionSigma promised = motion_sigma(information_of(rig, kDriven, options));
  // the same places as the information is of: the middles of 12 x 9 parts of the picture
  std::vector<Vec2> first_px;
  std::vector<Vec3> p_body;
  for (int cell = 0; cell < 12 * 9; ++cell) {
    const Vec2 px((cell % 12 + 0.5) * 320 / 12 - 0.5, (cell / 12 + 0.5) * 240 / 9 - 0.5);
    const Vec3 d = *sight.cameras()[0].direction_body(px);
    if (d.z() >= 0) {
      continue;
    }
    const Vec3 eye = sight.cameras()[0].eye_body();
    const Vec3 p = eye - d * (eye.z() / d.z());
    if (sight.cameras()[0].maps(p.head<2>()) && p.head<2>().cwiseAbs().maxCoeff() < 2.75 &&
        sight.cameras()[0].sees(p - Vec3(0.25, 0, 0))) {
      first_px.push_back(px);
      p_body.push_back(p);
    }
  }
  ASSERT_GT(p_body.size(), 20U);
  options.features = 108;  // one at each
  const MotionSigma one_each = motion_sigma(information_of(rig, kDriven, options));
  const auto shown = [&](const Vec3& motion, const Vec3& p) {
    const Vec2 after = Pose2{motion.x(), motion.y(), motion.z()}.inverse() * Vec2(p.head<2>());
    return camera.intrinsics.project(sight.cameras()[0].in_camera({after.x(), after.y(), 0}));
  };
  Rng rng(5);
  constexpr int kDraws = 400;
  Vec3 sum2 = Vec3::Zero();
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<Vec2> seen_px;
    for (const Vec3& p : p_body) {
      const double both_px = std::sqrt(2.0) * 0.5;  // the first picture's noise is in the second
      seen_px.push_back(shown({0.25, 0, 0}, p) +
                        Vec2(rng.normal(0, both_px), rng.normal(0, both_px)));
    }
    Vec3 motion(0.25, 0, 0);
    for (int step = 0; step < 3; ++step) {  // Gauss and Newton
      Mat3 A = Mat3::Zero();
      Vec3 b = Vec3::Zero();
      for (std::size_t i = 0; i < p_body.size(); ++i) {
        Eigen::Matrix<double, 2, 3> J;
        for (int k = 0; k < 3; ++k) {
          J.col(k) =
              (shown(motion + 1e-6 * Vec3::Unit(k), p_body[i]) - shown(motion, p_body[i])) / 1e-6;
        }
        A += J.transpose() * J;
        b += J.transpose() * (seen_px[i] - shown(motion, p_body[i]));
      }
      motion += A.ldlt().solve(b);
    }
    sum2 += (motion - Vec3(0.25, 0, 0)).cwiseAbs2();
  }
  const Vec3 scatter = (sum2 / kDraws).cwiseSqrt();
  constexpr double kThreeSigma = 3 / 28.3;  // of a standard deviation of 400 draws
  EXPECT_NEAR(scatter.x() / one_each.ahead_m.value_or(0), 1, kThreeSigma);
  EXPECT_NEAR(scatter.y() / one_each.aside_m.value_or(0), 1, kThreeSigma);
  EXPECT_NEAR(scatter.z() / one_each.heading_rad.value_or(0), 1, kThreeSigma);
  EXPECT_LT(*promised.heading_rad, *one_each.heading_rad);
}

}  // namespace
}  // namespace panoptes
