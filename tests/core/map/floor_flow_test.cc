// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_flow.h"

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "core/camera/mounting.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

constexpr double kKnock_rad = deg_to_rad(1.5);
constexpr double kKnock_m = 0.015;
// The claims of a drive of this length, one sigma, are 0.02 degrees of roll and pitch, 0.15 of yaw
// and 5 mm; of a turn of 1.5 degrees the first order lacks 0.06.
constexpr double kTurn_rad = deg_to_rad(0.2);
constexpr double kShift_m = 0.005;

FloorScene carpet(double contrast = 0.08) {
  FloorScene scene;
  scene.carpet = {Vec3(120, 110, 90), contrast, 1};
  return scene;
}

RigCamera believed_camera() {
  RigCamera camera = office_floor_camera();
  camera.T_body_camera = mounted_camera(Vec3(0.2, 0, 0.6), 0, deg_to_rad(36));
  return camera;
}

struct Shown {
  FloorEvidence evidence;
  int steps = 0;

  FloorState state() const {
    FloorState sigma;
    sigma << Vec3::Constant(deg_to_rad(5)), Vec3::Constant(0.05), 0.01;
    FloorInformation information = evidence.information;
    information.diagonal() += sigma.cwiseAbs2().cwiseInverse();
    return information.ldlt().solve(evidence.vector);
  }
};

// What is shown on a drive of straight pieces and turns by a camera that is off by so much.
Shown shown(const FloorScene& scene, const MountingOffset& off, std::int8_t floor = 8) {
  const RigCamera believed = believed_camera();
  RigCamera camera = believed;
  camera.T_body_camera = displaced(believed.T_body_camera, off);
  const auto projection = std::make_shared<FloorProjection>(project_floor(believed, Body{}));
  FloorFlow flow(projection, believed.intrinsics);
  const std::vector<std::int8_t> evidence(projection->sample.size(), floor);
  Rng rng(3);
  Shown shown;
  Pose2 T_scene_body;
  for (int k = 0; k < 18; ++k) {
    const cv::Mat picture = draw(scene, camera, T_scene_body, rng);
    if (const auto step = flow.add(picture, evidence, T_scene_body, Twist2{0.3, 0})) {
      shown.evidence += *step;
      ++shown.steps;
    }
    T_scene_body =
        T_scene_body * exp_twist(k % 2 == 0 ? Twist2{0.16, 0.02} : Twist2{0.04, deg_to_rad(12)}, 1);
  }
  return shown;
}

void expect_near(const FloorState& state, const MountingOffset& off) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(state[kFloorRoll + axis], off.rotation_rad[axis], kTurn_rad) << axis;
    EXPECT_NEAR(state[kFloorShift + axis], off.shift_m[axis], kShift_m) << axis;
  }
}

TEST(FloorFlow, OfACameraThatIsWhereItIsBelievedShowsNoError) {
  const Shown all = shown(carpet(), {});
  EXPECT_EQ(all.steps, 17);
  expect_near(all.state(), {});
}

TEST(FloorFlow, ShowsHowACameraIsTurnedAndShifted) {
  for (int axis = 0; axis < 3; ++axis) {
    MountingOffset turned;
    turned.rotation_rad[axis] = kKnock_rad;
    expect_near(shown(carpet(), turned).state(), turned);
    MountingOffset shifted;
    shifted.shift_m[axis] = kKnock_m;
    expect_near(shown(carpet(), shifted).state(), shifted);
  }
}

TEST(FloorFlow, WhatStandsOnTheFloorIsOutvoted) {
  FloorScene scene = carpet();
  scene.boxes.push_back({{0.9, -1.0}, {1.5, -0.4}, 0.5, {Vec3(120, 110, 90), 0.1, 6}});
  expect_near(shown(scene, {}).state(), {});
}

TEST(FloorFlow, AFloorWithoutTextureSaysNothing) { EXPECT_EQ(shown(carpet(0), {}).steps, 0); }

TEST(FloorFlow, WhatIsNotKnownToBeFloorSaysNothing) { EXPECT_EQ(shown(carpet(), {}, 0).steps, 0); }

TEST(FloorFlow, TheSamePicturesMakeTheSameBits) {
  const Shown once = shown(carpet(), {});
  const Shown again = shown(carpet(), {});
  EXPECT_EQ(once.evidence.information, again.evidence.information);
  EXPECT_EQ(once.evidence.vector, again.evidence.vector);
}

}  // namespace
}  // namespace panoptes
