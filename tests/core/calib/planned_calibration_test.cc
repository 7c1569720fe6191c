// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/planned_calibration.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/camera/mounting.h"
#include "tests/support/driven_rose.h"

namespace panoptes {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

using NamedCameras = std::vector<std::pair<std::string, RigCamera>>;

/// Two cameras that look away from each other: they never see the same at once.
NamedCameras two_opposed() {
  NamedCameras cameras;
  for (const bool ahead : {true, false}) {
    RigCamera camera;
    camera.intrinsics = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
    camera.T_body_camera =
        mounted_camera({ahead ? 0.15 : -0.15, 0.02, 0.7}, ahead ? 0.05 : std::numbers::pi, 0.05);
    cameras.emplace_back(ahead ? "ahead" : "behind", camera);
  }
  return cameras;
}

DrivePath program(const MotionProgramOptions& options,
                  double longest_s = std::numeric_limits<double>::max()) {
  return driven_path(options, Body(), longest_s);
}

RigCalibration plan(const DrivePath& path) { return plan_calibration({}, two_opposed(), path); }

double sigma(const RigCalibration& of, Eigen::Index row) {
  return std::sqrt(of.bundle.known.covariance(row, row));
}

constexpr Eigen::Index kYaw = 2;

TEST(PlannedCalibration, AfterARoseOnlyTheHeightStaysOpen) {
  const RigCalibration rose = plan(program(Rose()));
  EXPECT_TRUE(rose.bundle.tells_metre);
  EXPECT_THAT(rose.bundle.known.unobservable, Each(ElementsAre("its height")));
  EXPECT_THAT(rose.shared, Each(testing::Gt(100))) << "each sees in turn what the other has seen";
  EXPECT_THAT(plan_advice(rose), ElementsAre(HasSubstr("measure it")));
  // What calibrated roses tell (core/README.md), within a factor of two.
  EXPECT_NEAR(std::log2(rad_to_deg(sigma(rose, kYaw)) / 0.030), 0, 1);
  EXPECT_NEAR(std::log2(1000 * sigma(rose, 3) / 0.87), 0, 1);
  EXPECT_NEAR(std::log2(1000 * sigma(rose, 4) / 1.1), 0, 1);
}

TEST(PlannedCalibration, ALongerDriveIsSurer) {
  const RigCalibration part = plan(program(Rose(), 20));
  const RigCalibration whole = plan(program(Rose()));
  for (const Eigen::Index row :
       {Eigen::Index{0}, Eigen::Index{1}, kYaw, Eigen::Index{3}, Eigen::Index{4}}) {
    EXPECT_LT(sigma(whole, row), sigma(part, row)) << row;
  }
}

TEST(PlannedCalibration, ATurnOnTheSpotShowsNoYawAndNoMetre) {
  const RigCalibration spin = plan(program(Sawtooth()));
  EXPECT_FALSE(spin.bundle.tells_metre);
  EXPECT_THAT(spin.bundle.known.unobservable, Each(Contains("its yaw")));
  EXPECT_THAT(plan_advice(spin),
              Contains(AllOf(HasSubstr("shows no metre"), HasSubstr("or a rose"))));
}

TEST(PlannedCalibration, WhatALineAndACircleLeaveOpenIsNamed) {
  RoseShape line;
  line.legs = 4;
  line.leg_m = 1;
  line.turn_rad = 0;
  const RigCalibration straight = plan(DrivenRose(line, Rng(1)).path());
  EXPECT_TRUE(straight.bundle.tells_metre);
  EXPECT_THAT(straight.bundle.known.unobservable,
              Each(AllOf(Contains("its roll"), Contains("its place along x"),
                         Contains("its place along y"), Not(Contains("its yaw")))));
  EXPECT_THAT(plan_advice(straight), Contains(HasSubstr("its roll (ahead, behind)")));

  RoseShape round;
  round.legs = 3;
  round.leg_m = std::numbers::pi;
  round.turn_rad = 0;
  round.leg_turn_rad = 2 * std::numbers::pi;
  round.back = false;
  const RigCalibration circle = plan(DrivenRose(round, Rng(1)).path());
  EXPECT_THAT(circle.bundle.known.unobservable,
              Each(AllOf(Contains("its yaw"), Contains("its place along x"),
                         Contains("its place along y"), Not(Contains("its roll")))));
}

TEST(PlannedCalibration, ARobotThatStandsShowsNothing) {
  const RigCalibration none = plan(DrivePath({Pose2(), Pose2()}, 1));
  EXPECT_THAT(none.bundle.known.unobservable, Each(testing::SizeIs(6)));
  EXPECT_NEAR(sigma(none, kYaw), two_opposed().front().second.sigma.rotation_rad.z(), 1e-9);
}

TEST(PlannedCalibration, ItIsTheSameBitsEveryTime) {
  const DrivePath path = program(Rose(), 20);
  const RigCalibration once = plan(path);
  const RigCalibration again = plan(path);
  EXPECT_EQ(once.bundle.known.covariance, again.bundle.known.covariance);
  EXPECT_EQ(once.tracks.seen.size(), again.tracks.seen.size());
}

TEST(PlannedCalibration, ARigWithoutCamerasIsRefused) {
  EXPECT_THROW(plan_calibration({}, {}, program(Rose(), 5)), CheckError);
}

}  // namespace
}  // namespace panoptes
