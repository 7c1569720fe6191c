// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_by_maps.h"

#include <gmock/gmock.h>

#include "core/calib/rig_by_maps_verdict.h"
#include "tests/support/mapped_rig.h"

namespace panoptes {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

RigByMaps found_by(const std::vector<MappedCamera>& cameras, MapsJoined joined,
                   std::uint64_t seed = 1) {
  RigByMapsOptions options;
  options.joined = joined;
  options.every_s = 1;
  double done = 0;
  RigByMaps found = calibrate_by_maps(
      options, cameras, [](std::size_t, std::size_t) { return cv::Mat(); }, Rng(seed),
      [&done](double now) {
        EXPECT_GE(now, done);
        done = now;
      });
  EXPECT_EQ(done, 1);
  return found;
}

Pose3 true_relative(const std::vector<RigCamera>& rig, std::size_t camera) {
  return rig.front().T_body_camera.inverse() * rig[camera].T_body_camera;
}

double turn_off_deg(const std::vector<RigCamera>& rig, const RigByMaps& found, std::size_t c) {
  return rad_to_deg(
      found.state.T_body_camera[c].rotation.angularDistance(true_relative(rig, c).rotation));
}

Rig rig_of(const std::vector<MappedCamera>& cameras) {
  Rig rig;
  for (const MappedCamera& camera : cameras) {
    rig.cameras[camera.name] = camera.believed;
  }
  return rig;
}

TEST(RigByMaps, IsFoundUpToItsScale) {
  const std::vector<RigCamera> rig = cameras_about(4);
  MappedScene scene;
  scene.scale = {1, 2, 0.5, 1.3};
  const std::vector<MappedCamera> cameras = mapped_cameras(rig, scene, Rng(1));
  for (const MapsJoined joined : {MapsJoined::kChain, MapsJoined::kGraph}) {
    const RigByMaps found = found_by(cameras, joined);
    ASSERT_TRUE(found.is_told());
    EXPECT_TRUE(found.converged);
    EXPECT_NEAR(found.rms_after_px, std::sqrt(2.0) * scene.noise_px, 0.03);
    EXPECT_GT(found.rms_before_px, 1.5 * found.rms_after_px);
    EXPECT_GT(found.observations_other, 500);
    EXPECT_LT(found.left_out, 0.03 * found.observations);
    const Rig on_robot = rig_by_maps(rig_of(cameras), found);
    for (std::size_t c = 1; c < rig.size(); ++c) {
      constexpr double kMost_deg = 0.03;  // a fifth of a pixel
      EXPECT_LT(turn_off_deg(rig, found, c), kMost_deg);
      EXPECT_GT(found.shared[c], 30);
      const Pose3& T_body_camera = on_robot.cameras.at(cameras[c].name).T_body_camera;
      EXPECT_LT((T_body_camera.translation - rig[c].T_body_camera.translation).norm(), 0.003);
    }
    const Judged judged = judge_rig_by_maps(cameras, found);
    EXPECT_EQ(judged.verdict, Verdict::kGood) << judged.reasons.front();
  }
}

TEST(RigByMaps, IsFoundAmongFalseMatchesWithAnySeed) {
  const std::vector<RigCamera> rig = cameras_about(2);
  MappedScene scene;
  scene.false_looks = 0.37;  // 0.6 of those that look alike
  const std::vector<MappedCamera> cameras = mapped_cameras(rig, scene, Rng(2));
  for (const std::uint64_t seed : {1, 2, 3}) {
    const RigByMaps found = found_by(cameras, MapsJoined::kChain, seed);
    ASSERT_TRUE(found.is_told());
    EXPECT_LT(turn_off_deg(rig, found, 1), 0.06);
    const Judged judged = judge_rig_by_maps(cameras, found);
    EXPECT_EQ(judged.verdict, Verdict::kGood) << judged.reasons.front();
    EXPECT_THAT(judged.reasons, Contains(HasSubstr("and no other maps confirm it")));
    const RigByMaps again = found_by(cameras, MapsJoined::kChain, seed);
    EXPECT_EQ(again.state.T_body_camera[1].rotation.coeffs(),
              found.state.T_body_camera[1].rotation.coeffs());
  }
}

TEST(RigByMaps, WhatHasNothingInCommonIsRefused) {
  MappedScene scene;
  scene.common = false;
  const std::vector<MappedCamera> cameras = mapped_cameras(cameras_about(2), scene, Rng(3));
  const RigByMaps found = found_by(cameras, MapsJoined::kGraph);
  EXPECT_FALSE(found.is_told());
  const Judged judged = judge_rig_by_maps(cameras, found);
  EXPECT_EQ(judged.verdict, Verdict::kFailed);
  EXPECT_THAT(judged.reasons,
              AllOf(Contains(HasSubstr("the maps of camera_0 and camera_1 are not aligned: ")),
                    Contains(HasSubstr("camera_1: nothing leads from its map to that of camera_0")),
                    Contains("no camera is told beside another one")));
  const Rig believed = rig_of(cameras);
  EXPECT_EQ(rig_by_maps(believed, found).cameras.at("camera_1").T_body_camera.translation,
            believed.cameras.at("camera_1").T_body_camera.translation);
}

TEST(RigByMaps, PicturesThatAreNotTakenAtOnceAreTold) {
  MappedScene scene;
  scene.late_s = 0.02;
  const std::vector<MappedCamera> cameras = mapped_cameras(cameras_about(2), scene, Rng(4));
  const RigByMaps found = found_by(cameras, MapsJoined::kChain);
  const Judged judged = judge_rig_by_maps(cameras, found);
  EXPECT_EQ(judged.verdict, Verdict::kPoor);
  EXPECT_THAT(judged.reasons,
              Contains(HasSubstr("camera_1: its pictures are taken 20.0 ms beside those of")));
}

TEST(RigByMaps, AMapThatIsLaidOnAnotherWronglyIsNotCalledGood) {
  const std::vector<RigCamera> rig = cameras_about(2);
  MappedScene scene;
  scene.other_side = true;
  const std::vector<MappedCamera> cameras = mapped_cameras(rig, scene, Rng(5));
  const RigByMaps found = found_by(cameras, MapsJoined::kChain);
  ASSERT_TRUE(found.is_told());
  const Judged judged = judge_rig_by_maps(cameras, found);
  EXPECT_EQ(judged.verdict, Verdict::kPoor);
  EXPECT_THAT(judged.reasons,
              Contains(HasSubstr("camera_1: does not keep its place beside camera_0")));
}

TEST(RigByMaps, ACameraWithoutAMapIsLeftOut) {
  const std::vector<RigCamera> rig = cameras_about(3);
  std::vector<MappedCamera> cameras = mapped_cameras(rig, {}, Rng(6));
  cameras[1].map.points.clear();
  const RigByMaps found = found_by(cameras, MapsJoined::kGraph);
  ASSERT_TRUE(found.is_told());
  EXPECT_FALSE(found.seen_along[1]);
  EXPECT_LT(turn_off_deg(rig, found, 2), 0.05);
  const Judged judged = judge_rig_by_maps(cameras, found);
  EXPECT_EQ(judged.verdict, Verdict::kPoor);
  EXPECT_THAT(judged.reasons, Contains(HasSubstr("camera_1: nothing leads from its map")));
}

TEST(RigByMaps, CamerasWithoutPicturesTellNothing) {
  std::vector<MappedCamera> cameras = mapped_cameras(cameras_about(2), {}, Rng(7));
  for (MappedCamera& camera : cameras) {
    camera.map.points.clear();
    for (MonoMap::Frame& frame : camera.map.frames) {
      frame.lost = true;
    }
  }
  const RigByMaps found = found_by(cameras, MapsJoined::kChain);
  EXPECT_FALSE(found.is_told());
  EXPECT_EQ(judge_rig_by_maps(cameras, found).verdict, Verdict::kFailed);
}

}  // namespace
}  // namespace panoptes
