// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_bundle.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/calib/joint_of_rig.h"
#include "core/camera/mounting.h"
#include "tests/support/driven_rig.h"

namespace panoptes {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::IsEmpty;
using ::testing::Not;

/// Two cameras that look away from each other.
std::vector<RigCamera> two_cameras() {
  std::vector<RigCamera> rig;
  for (int c = 0; c < 2; ++c) {
    RigCamera camera;
    camera.intrinsics = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
    camera.T_body_camera = mounted_camera({c == 0 ? 0.15 : -0.15, 0.02, 0.7 + 0.05 * c},
                                          c == 0 ? 0.05 : std::numbers::pi - 0.1, 0.05);
    camera.clock_offset_s = 0.004 - 0.01 * c;
    camera.sigma.rotation_rad.setConstant(0.02);
    camera.sigma.focal_ratio = 0.001;
    camera.sigma.centre_px = 0.3;
    camera.sigma.clock_s = 0.005;
    rig.push_back(camera);
  }
  return rig;
}

DrivenRig drive(const DrivenScene& scene, const RoseShape& rose, Rng rng) {
  return driven_rig(two_cameras(), scene, rose, rng);
}

RoseShape noisy() {
  RoseShape rose;
  rose.noise_m = 0.005;
  return rose;
}

/// What is told of a metre: how far points are from one another.
double metre(const DrivenRig& of, const RigBundle& bundle) {
  const auto far_m = [](const std::vector<Vec3>& points) {
    double sum_m = 0;
    for (const Vec3& p : points) {
      sum_m += (p - points.front()).norm();
    }
    return sum_m;
  };
  return far_m(bundle.state.points_start) / far_m(of.points_start);
}

/// What the second camera is off by as the first one sees it, squared, a dimension.
double normalised_error(const DrivenRig& of, const RigBundle& bundle) {
  const auto e = relative_error(of, bundle);
  return e.dot(bundle.known.relative(bundle.state, 0, 1).ldlt().solve(e)) / 6;
}

TEST(RigBundle, FindsTheRigAndHowWellItIsKnown) {
  double normalised = 0;
  double metres = 0;
  constexpr int kRuns = 6;
  for (int seed = 0; seed < kRuns; ++seed) {
    DrivenRig of = drive({}, noisy(), Rng(20 + seed));
    const RigBundle bundle = adjusted(of);
    const auto e = relative_error(of, bundle);
    EXPECT_TRUE(bundle.converged);
    EXPECT_LT(e.head<3>().norm(), deg_to_rad(0.05));
    EXPECT_LT(e.tail<3>().norm(), 0.005);
    for (std::size_t c = 0; c < of.truth.size(); ++c) {
      const MountingOffset off =
          mounting_offset(of.truth[c].T_body_camera, bundle.state.T_body_camera[c]);
      EXPECT_LT(off.rotation_rad.head<2>().norm(), deg_to_rad(0.1));
      EXPECT_LT(std::abs(off.rotation_rad.z()), deg_to_rad(0.5));
      EXPECT_LT(off.shift_m.head<2>().norm(), 0.008);
      EXPECT_NEAR(bundle.state.clock_offset_s[c], of.truth[c].clock_offset_s, 0.004);
    }
    metres += metre(of, bundle) / kRuns;
    normalised += normalised_error(of, bundle);
  }
  // Wheels that roll a metre off by 5 mm, together some seven metres each run; the metre that their
  // prior has is 1.
  EXPECT_NEAR(metres, 1, 0.0015);
  // chi-squared of 6 times 6 numbers: three sigma either way
  EXPECT_GT(normalised / kRuns, 1 - 3 * std::sqrt(2.0 / (6 * kRuns)));
  EXPECT_LT(normalised / kRuns, 1 + 3 * std::sqrt(2.0 / (6 * kRuns)));
}

TEST(RigBundle, WhatIsFalseIsLeftOut) {
  DrivenScene scene;
  scene.false_share = 0.1;
  DrivenRig of = drive(scene, noisy(), Rng(31));
  const RigBundle bundle = adjusted(of);
  const auto all = static_cast<double>(of.tracks.seen.size());
  EXPECT_NEAR(bundle.left_out / all, 0.1, 0.03);
  EXPECT_LT(relative_error(of, bundle).head<3>().norm(), deg_to_rad(0.05));
}

TEST(RigBundle, NoMotionOverAFloorShowsTheHeight) {
  DrivenRig of = drive({}, noisy(), Rng(32));
  const RigBundle bundle = adjusted(of);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_THAT(bundle.known.unobservable[c], ElementsAre("its height"));
  }
  const auto mean_height = [](const Pose3& a, const Pose3& b) {
    return (a.translation.z() + b.translation.z()) / 2;
  };
  EXPECT_NEAR(mean_height(bundle.state.T_body_camera[0], bundle.state.T_body_camera[1]),
              mean_height(of.believed[0].T_body_camera, of.believed[1].T_body_camera), 1e-9)
      << "it stays as it was believed";
  const auto height = bundle.known.camera[0] + 5;
  EXPECT_NEAR(std::sqrt(bundle.known.covariance(height, height)),
              of.believed[0].sigma.position_m.z() / std::sqrt(2.0), 1e-3);
}

TEST(RigBundle, CamerasThatShareNothingKeepTheirHeights) {
  DrivenScene scene;
  scene.shares = false;
  DrivenRig of = drive(scene, noisy(), Rng(33));
  const RigBundle bundle = adjusted(of);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_NEAR(bundle.state.T_body_camera[c].translation.z(),
                of.believed[c].T_body_camera.translation.z(), 1e-9);
    EXPECT_THAT(bundle.known.unobservable[c], Contains("its height"));
  }
  const auto e = relative_error(of, bundle);
  EXPECT_LT(e.head<3>().norm(), deg_to_rad(0.3)) << "the wheels tell the rest of it";
}

TEST(RigBundle, ATurnOnTheSpotShowsNeitherYawNorPlace) {
  RoseShape spin = noisy();
  spin.leg_m = 0;
  for (int seed = 0; seed < 3; ++seed) {
    DrivenRig of = drive({}, spin, Rng(34 + seed));
    const RigBundle bundle = adjusted(of);
    EXPECT_TRUE(bundle.converged);
    EXPECT_FALSE(bundle.tells_metre);
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_THAT(bundle.known.unobservable[c],
                  AllOf(Contains("its yaw"), Contains("its place along x"),
                        Not(Contains("its roll")), Not(Contains("its pitch"))));
      const double off_m =
          (bundle.state.T_body_camera[c].translation - of.believed[c].T_body_camera.translation)
              .head<2>()
              .norm();
      EXPECT_LT(off_m, 0.04) << "the metre is the one that is believed";
    }
    EXPECT_LT(relative_error(of, bundle).head<3>().norm(), deg_to_rad(0.1));
  }
}

TEST(RigBundle, KnowsThatWhatIsSeenOfAPointMayBeOffTogether) {
  double normalised = 0;
  constexpr int kRuns = 6;
  for (int seed = 0; seed < kRuns; ++seed) {
    DrivenRig of = drive({.noise_px = 0.05, .wander_px = 0.2}, noisy(), Rng(40 + seed));
    const RigBundle bundle = adjusted(of);
    normalised += normalised_error(of, bundle) / kRuns;
  }
  // As if all noise were independent it would be 2.1.
  EXPECT_LT(normalised, 1.4);
  EXPECT_GT(normalised, 0.4);
}

TEST(RigBundle, LearnsByHowMuchPointsSlideWhenTheyAreSeenFromElsewhere) {
  double normalised = 0;
  constexpr int kRuns = 3;
  for (int seed = 0; seed < kRuns; ++seed) {
    DrivenRig of = drive({.noise_px = 0.05, .slide_px = 1}, noisy(), Rng(40 + seed));
    const RigBundle bundle = adjusted(of);
    normalised += normalised_error(of, bundle) / kRuns;
    EXPECT_NEAR(bundle.slide_rad * of.truth[0].intrinsics.fx_px, 1, 0.35) << seed;
  }
  EXPECT_LT(normalised, 1.4);
  EXPECT_GT(normalised, 0.4);
}

TEST(RigBundle, WithoutWheelsAllIsToldUpToWhereTheBodyIsAndToScale) {
  RigBundleOptions options;
  options.systematic_lens_px = 0;
  options.systematic_distortion_px = 0;
  options.systematic_mounting_px = 0;
  options.has_wheels = false;
  double normalised = 0;
  constexpr int kRuns = 6;
  for (int seed = 0; seed < kRuns; ++seed) {
    DrivenRig of = drive({}, noisy(), Rng(60 + seed));
    const RigBundle bundle = adjust_rig(
        options, of.believed, [&of](Time at) { return of.rose.wheels(at); }, of.tracks, of.start);
    EXPECT_TRUE(bundle.converged);
    EXPECT_FALSE(bundle.tells_metre);
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_THAT(bundle.known.unobservable[c],
                  ElementsAre("its yaw", "its place along x", "its place along y", "its height"));
      const auto off = body_error(of, bundle, c);
      EXPECT_LT(off.head<2>().norm(), deg_to_rad(0.1)) << "the floor tells roll and pitch";
    }
    const std::vector<Pose3>& all = bundle.state.T_body_camera;
    const Vec3 found = (all[0].inverse() * all[1]).translation;
    const Vec3 truth =
        (of.truth[0].T_body_camera.inverse() * of.truth[1].T_body_camera).translation;
    EXPECT_LT((found.normalized() - truth.normalized()).norm(), 0.01);
    const Vec3 believed =
        (of.believed[0].T_body_camera.inverse() * of.believed[1].T_body_camera).translation;
    EXPECT_NEAR(found.norm() / believed.norm(), 1, 0.05) << "a metre is the one that is believed";
    EXPECT_NEAR(metre(of, bundle), found.norm() / truth.norm(), 0.005);
    const auto e = relative_error(of, bundle);
    EXPECT_LT(e.head<3>().norm(), deg_to_rad(0.05));
    const std::vector<double>& clocks = bundle.state.clock_offset_s;
    EXPECT_NEAR(clocks[0] + clocks[1],
                of.believed[0].clock_offset_s + of.believed[1].clock_offset_s, 1e-4)
        << "nothing tells what both are off by";
    normalised += normalised_error(of, bundle);
  }
  EXPECT_GT(normalised / kRuns, 1 - 3 * std::sqrt(2.0 / (6 * kRuns)));
  EXPECT_LT(normalised / kRuns, 1 + 3 * std::sqrt(2.0 / (6 * kRuns)));
}

TEST(RigBundle, CalibratedAgainItKnowsWhatNoRunShowsNoBetter) {
  RigBundleOptions options;
  DrivenRig of = drive({}, noisy(), Rng(70));
  const WheelReadings wheels = [&of](Time at) { return of.rose.wheels(at); };
  RigCalibration once;
  once.cameras = {"a", "b"};
  once.bundle = adjust_rig(options, of.believed, wheels, of.tracks, of.start);
  const RigCovariance& known = once.bundle.known;
  const Eigen::VectorXd sigma = known.covariance.diagonal().cwiseSqrt();
  for (std::size_t c = 0; c < 2; ++c) {
    RigCamera& camera = of.believed[c];
    camera.T_body_camera = once.bundle.state.T_body_camera[c];
    camera.intrinsics = once.bundle.state.lenses[c];
    camera.clock_offset_s = once.bundle.state.clock_offset_s[c];
    camera.sigma.rotation_rad = sigma.segment<3>(known.camera[c]);
    camera.sigma.position_m = sigma.segment<3>(known.camera[c] + 3);
    camera.sigma.focal_ratio = sigma[known.camera[c] + 6] / camera.intrinsics.fx_px;
    camera.sigma.centre_px = sigma[known.camera[c] + 8];
    camera.sigma.clock_s = sigma[known.wheels - (c == 0 ? known.wheels - known.camera[1] : 0) - 1];
  }
  DrivenRig other = drive({}, noisy(), Rng(71));
  other.believed = of.believed;
  const auto z_again_m = [&] {
    RigTracks tracks = other.tracks;
    const RigBundle again = adjust_rig(
        options, other.believed, [&other](Time at) { return other.rose.wheels(at); }, tracks,
        other.start);
    const Eigen::Index z = again.known.camera[0] + 5;
    return std::sqrt(again.known.covariance(z, z));
  };
  const double z_m = of.believed[0].sigma.position_m.z();
  EXPECT_LT(z_again_m(), 0.8 * z_m) << "as if the heights of both had been told by themselves";
  options.before = covariance_before(once.cameras, other.believed, joint_covariance(once));
  EXPECT_NEAR(z_again_m(), z_m, 0.02 * z_m);
}

TEST(RigBundle, ALensThatIsKnownBeforeLeavesMountingsNoLessSure) {
  DrivenRig of = drive({}, noisy(), Rng(72));
  const auto rotation_rad = [&of] {
    RigTracks tracks = of.tracks;
    const RigBundle bundle = adjust_rig(
        RigBundleOptions(), of.believed, [&of](Time at) { return of.rose.wheels(at); }, tracks,
        of.start);
    return Vec3(bundle.known.covariance.diagonal().head<3>().cwiseSqrt());
  };
  const Vec3 usual_rad = rotation_rad();
  for (std::size_t c = 0; c < 2; ++c) {
    of.believed[c].intrinsics = of.start.lenses[c] = of.truth[c].intrinsics;
    of.believed[c].sigma.focal_ratio = 1e-6;
    of.believed[c].sigma.centre_px = 1e-3;
  }
  EXPECT_LT((rotation_rad() - 1.2 * usual_rad).maxCoeff(), 0);
}

TEST(RigBundle, EndsWithWhatAStepThrows) {
  DrivenRig of = drive({}, noisy(), Rng(1));
  RigBundleOptions options;
  int steps = 0;
  options.each_step = [&] {
    if (++steps == 3) {
      throw std::runtime_error("enough");
    }
  };
  EXPECT_THROW(
      adjust_rig(
          options, of.believed, [&of](Time at) { return of.rose.wheels(at); }, of.tracks, of.start),
      std::runtime_error);
  EXPECT_EQ(steps, 3);
}

/// What is named of both cameras, and that it stays where the believed mountings leave it: within
/// three of the sigmas that are told.
void expect_open(const RigBundle& bundle, const DrivenRig& of,
                 const std::vector<std::string>& named) {
  EXPECT_TRUE(bundle.converged);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_THAT(bundle.known.unobservable[c], ElementsAreArray(named)) << "camera " << c;
    const auto off = body_error(of, bundle, c);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const Eigen::Index at = bundle.known.camera[c] + k;
      EXPECT_LT(std::abs(off[k]), 3 * std::sqrt(bundle.known.covariance(at, at)))
          << "camera " << c << ", number " << k;
    }
  }
}

TEST(RigBundle, ADriveWithoutTurnsShowsNeitherRollNorPlace) {
  RoseShape straight = noisy();
  straight.legs = 4;
  straight.leg_m = 1;
  straight.turn_rad = 0;
  for (int seed = 0; seed < 2; ++seed) {
    DrivenRig of = drive({}, straight, Rng(40 + seed));
    const RigBundle bundle = adjusted(of);
    expect_open(bundle, of, {"its roll", "its place along x", "its place along y", "its height"});
    const Eigen::Index roll = bundle.known.camera[0];
    EXPECT_LT(std::sqrt(bundle.known.covariance(roll, roll)),
              1.001 * of.believed[0].sigma.rotation_rad.x());
  }
}

TEST(RigBundle, ACircleLeavesYawAndPlaceOpenTogether) {
  RoseShape circle = noisy();
  circle.legs = 2;
  circle.leg_m = std::numbers::pi;
  circle.turn_rad = 0;
  circle.leg_turn_rad = 2 * std::numbers::pi;
  circle.back = false;
  for (int seed = 0; seed < 2; ++seed) {
    DrivenRig of = drive({}, circle, Rng(42 + seed));
    expect_open(adjusted(of), of,
                {"its yaw", "its place along x", "its place along y", "its height"});
  }
}

TEST(RigBundle, WhatIsTooFarShowsRotationsAlone) {
  DrivenScene distant;
  distant.near_m = 20000;
  distant.far_m = 50000;
  DrivenRig of = drive(distant, noisy(), Rng(44));
  const RigBundle bundle = adjusted(of);
  expect_open(bundle, of, {"its yaw", "its place along x", "its place along y", "its height"});
  EXPECT_LT(relative_error(of, bundle).head<3>().norm(), deg_to_rad(0.1));
  const Eigen::Index x = bundle.known.camera[0] + 3;
  EXPECT_NEAR(std::sqrt(bundle.known.covariance(x, x)), of.believed[0].sigma.position_m.x(), 0.002);
}

}  // namespace
}  // namespace panoptes
