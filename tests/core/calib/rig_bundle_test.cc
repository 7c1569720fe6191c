// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_bundle.h"

#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/camera/mounting.h"
#include "tests/support/driven_rose.h"

namespace panoptes {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kNoise_px = 0.1;

/// Two cameras that look away from each other, on a robot that drives a rose amid points.
struct Drive {
  std::vector<RigCamera> truth;
  std::vector<RigCamera> believed;
  std::vector<Vec3> points_start;
  DrivenRose rose;
  RigTracks tracks;
  RigBundleState start;
};

struct Scene {
  bool shares = true;  ///< each camera sees the other's points
  double false_share = 0;
};

Drive drive(const Scene& scene, const RoseShape& rose, Rng rng) {
  Drive out{{}, {}, {}, DrivenRose(rose, rng.fork("drive")), {}, {}};
  for (int c = 0; c < 2; ++c) {
    RigCamera camera;
    camera.intrinsics = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
    camera.T_body_camera = mounted_camera({c == 0 ? 0.15 : -0.15, 0.02, 0.7 + 0.05 * c},
                                          c == 0 ? 0.05 : std::numbers::pi - 0.1, 0.05);
    camera.clock_offset_s = 0.004 - 0.01 * c;
    camera.sigma.focal_ratio = 0.001;
    camera.sigma.centre_px = 0.3;
    camera.sigma.clock_s = 0.005;
    out.truth.push_back(camera);
    RigCamera off = camera;
    off.clock_offset_s = 0;
    off.T_body_camera =
        displaced(camera.T_body_camera, {0.02 * Vec3(rng.normal(), rng.normal(), rng.normal()),
                                         0.01 * Vec3(rng.normal(), rng.normal(), rng.normal())});
    off.intrinsics.fx_px *= 1 + 0.001 * rng.normal();
    off.intrinsics.fy_px = off.intrinsics.fx_px;
    off.intrinsics.cx_px += 0.3 * rng.normal();
    off.intrinsics.cy_px += 0.3 * rng.normal();
    out.believed.push_back(off);
  }
  constexpr std::size_t kEvery = 9;
  for (std::size_t i = 10; i + 10 < out.rose.instants(); i += kEvery) {
    const std::size_t instant = out.tracks.instants.size();
    out.tracks.instants.push_back(out.rose.instant(i));
    out.start.T_start_body.push_back(on_floor(out.rose.wheels(out.rose.instant(i))->T_odom_body));
    for (std::size_t c = 0; c < out.truth.size(); ++c) {
      out.tracks.views.push_back(
          {c, instant, out.rose.instant(i) + from_seconds(out.truth[c].clock_offset_s)});
    }
  }
  const Pose3 T_first = out.start.T_start_body.front().inverse();
  for (Pose3& T : out.start.T_start_body) {
    T = T_first * T;
  }
  const Pose2 first = out.rose.T_start_body(out.tracks.instants.front());
  constexpr int kPoints = 100;
  for (int p = 0; p < kPoints; ++p) {
    const double angle_rad = rng.uniform(0, 2 * std::numbers::pi);
    const double far_m = rng.uniform(1.5, 3);
    const Vec3 at(far_m * std::cos(angle_rad), far_m * std::sin(angle_rad), rng.uniform(0.2, 1.6));
    const auto of = static_cast<std::size_t>(p % 2);
    std::vector<RigSeen> seen;
    int own = 0;
    for (std::size_t v = 0; v < out.tracks.views.size(); ++v) {
      const RigView& view = out.tracks.views[v];
      const RigCamera& camera = out.truth[view.camera];
      const Pose3 T_start_camera =
          on_floor(first.inverse() *
                   out.rose.T_start_body(view.stamp - from_seconds(camera.clock_offset_s))) *
          camera.T_body_camera;
      const Vec3 p_camera = T_start_camera.inverse() * at;
      if (!camera.intrinsics.sees(p_camera) || (view.camera != of && !scene.shares)) {
        continue;
      }
      Vec2 px = camera.intrinsics.project(p_camera) + kNoise_px * Vec2(rng.normal(), rng.normal());
      if (rng.uniform() < scene.false_share) {
        px += Vec2(9, -7);
      }
      own += view.camera == of ? 1 : 0;
      seen.push_back({v, out.start.points_start.size(), px, view.camera == of, true});
    }
    if (own >= 2) {
      out.tracks.seen.insert(out.tracks.seen.end(), seen.begin(), seen.end());
      out.points_start.push_back(at);
      out.start.points_start.push_back(at + 0.02 * Vec3(rng.normal(), rng.normal(), rng.normal()));
    }
  }
  for (const RigCamera& camera : out.believed) {
    out.start.T_body_camera.push_back(camera.T_body_camera);
    out.start.lenses.push_back(camera.intrinsics);
    out.start.clock_offset_s.push_back(0);
  }
  return out;
}

RoseShape noisy() {
  RoseShape rose;
  rose.noise_m = 0.005;
  return rose;
}

RigBundle adjusted(Drive& of) {
  RigBundleOptions options;
  options.systematic_px = 0;  // of pictures
  return adjust_rig(
      options, of.believed, [&of](Time at) { return of.rose.wheels(at); }, of.tracks, of.start);
}

/// Turn and shift by which the second camera is off as the first one sees it.
Eigen::Matrix<double, 6, 1> relative_error(const Drive& of, const RigBundle& bundle) {
  const Pose3 found = bundle.state.T_body_camera[0].inverse() * bundle.state.T_body_camera[1];
  const Pose3 truth = of.truth[0].T_body_camera.inverse() * of.truth[1].T_body_camera;
  const Eigen::AngleAxisd off(found.rotation * truth.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> e;
  e << off.angle() * off.axis(), found.translation - truth.translation;
  return e;
}

/// What is told of a metre: how far points are from one another.
double metre(const Drive& of, const RigBundle& bundle) {
  const auto far_m = [](const std::vector<Vec3>& points) {
    double sum_m = 0;
    for (const Vec3& p : points) {
      sum_m += (p - points.front()).norm();
    }
    return sum_m;
  };
  return far_m(bundle.state.points_start) / far_m(of.points_start);
}

TEST(RigBundle, FindsTheRigAndHowWellItIsKnown) {
  double normalised = 0;
  double metres = 0;
  constexpr int kRuns = 6;
  for (int seed = 0; seed < kRuns; ++seed) {
    Drive of = drive({}, noisy(), Rng(20 + seed));
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
    normalised += e.dot(bundle.known.relative(bundle.state, 0, 1).ldlt().solve(e)) / 6;
  }
  // Wheels that roll a metre off by 5 mm, together some seven metres each run; the metre that their
  // prior has is 1.
  EXPECT_NEAR(metres, 1, 0.0015);
  // chi-squared of 6 times 6 numbers: three sigma either way
  EXPECT_GT(normalised / kRuns, 1 - 3 * std::sqrt(2.0 / (6 * kRuns)));
  EXPECT_LT(normalised / kRuns, 1 + 3 * std::sqrt(2.0 / (6 * kRuns)));
}

TEST(RigBundle, WhatIsFalseIsLeftOut) {
  Scene scene;
  scene.false_share = 0.1;
  Drive of = drive(scene, noisy(), Rng(31));
  const RigBundle bundle = adjusted(of);
  const auto all = static_cast<double>(of.tracks.seen.size());
  EXPECT_NEAR(bundle.left_out / all, 0.1, 0.03);
  EXPECT_LT(relative_error(of, bundle).head<3>().norm(), deg_to_rad(0.05));
}

TEST(RigBundle, NoMotionOverAFloorShowsTheHeight) {
  Drive of = drive({}, noisy(), Rng(32));
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
  Scene scene;
  scene.shares = false;
  Drive of = drive(scene, noisy(), Rng(33));
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
    Drive of = drive({}, spin, Rng(34 + seed));
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

}  // namespace
}  // namespace panoptes
