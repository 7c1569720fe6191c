// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_verdict.h"

#include <numbers>
#include <utility>

#include <gmock/gmock.h>

#include "core/calib/rig_costs.h"
#include "core/camera/mounting.h"
#include "tests/support/good_map.h"

namespace panoptes {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct JudgedRig {
  std::vector<MappedCamera> cameras;
  RigCalibration calibration;

  Judged judged() const { return judge_rig(cameras, calibration); }
};

/// Two cameras back to back of which all is as it was believed.
JudgedRig as_believed() {
  JudgedRig rig;
  RigBundle& bundle = rig.calibration.bundle;
  for (const double yaw_rad : {0.0, std::numbers::pi}) {
    MappedCamera camera;
    camera.name = yaw_rad == 0 ? "ahead" : "behind";
    camera.believed.intrinsics = pinhole(640, 480, deg_to_rad(80));
    camera.believed.T_body_camera =
        mounted_camera({yaw_rad == 0 ? 0.15 : -0.15, 0, 0.7}, yaw_rad, 0);
    camera.map = good_map();
    camera.adjusted = good_keyframes(camera.believed);
    bundle.state.T_body_camera.push_back(camera.believed.T_body_camera);
    bundle.state.lenses.push_back(camera.believed.intrinsics);
    bundle.state.clock_offset_s.push_back(0);
    PlanarHandEye alone;
    alone.T_body_camera = camera.believed.T_body_camera;
    rig.calibration.cameras.push_back(camera.name);
    rig.calibration.hand_eye.emplace_back(alone);
    rig.calibration.by_others.emplace_back();
    rig.calibration.shared.push_back(100);
    rig.calibration.tracks.views.push_back({rig.cameras.size(), 0, {}});
    rig.cameras.push_back(std::move(camera));
  }
  rig.calibration.tracks.instants.resize(100);
  rig.calibration.tracks.seen.resize(200);
  for (std::size_t i = 0; i < 100; ++i) {
    rig.calibration.tracks.seen[i].view = 1;
  }
  bundle.observations = 200;
  bundle.converged = true;
  return rig;
}

TEST(RigVerdict, IsGoodWhereNothingIsWrong) {
  EXPECT_EQ(as_believed().judged().verdict, Verdict::kGood);
  EXPECT_THAT(as_believed().judged().reasons, IsEmpty());
}

TEST(RigVerdict, ARecordingThatEndsEarlyIsSaid) {
  JudgedRig rig = as_believed();
  std::vector<MonoMap::Frame>& frames = rig.cameras[1].map.frames;
  const std::size_t before = frames.size();
  frames.resize(before * 9 / 10);
  EXPECT_THAT(rig.judged().reasons, ElementsAre(AllOf(HasSubstr("behind: its pictures end "),
                                                      HasSubstr(" s before those of others"))));
}

TEST(RigVerdict, SwappedPicturesAreNamed) {
  JudgedRig rig = as_believed();
  std::vector<Pose3>& found = rig.calibration.bundle.state.T_body_camera;
  std::swap(found[0], found[1]);
  EXPECT_EQ(rig.judged().verdict, Verdict::kPoor);
  EXPECT_THAT(rig.judged().reasons, Contains(HasSubstr("it looks as behind is said to")));
}

// Mirrored pictures show the directions (-x, y, z): with the mounting that is found, those are the
// true ones mirrored in the floor.
TEST(RigVerdict, MirroredPicturesAreNamed) {
  JudgedRig rig = as_believed();
  const Pose3 tilted = mounted_camera({-0.15, 0, 0.7}, std::numbers::pi, deg_to_rad(30));
  rig.cameras[1].believed.T_body_camera = tilted;
  Pose3& found = rig.calibration.bundle.state.T_body_camera[1];
  found = mounted_camera({-0.15, 0, 0.7}, std::numbers::pi, -deg_to_rad(30));
  found.rotation = found.rotation * Eigen::AngleAxisd(deg_to_rad(179), Vec3::UnitZ());
  const Vec3 in_mirror = found.rotation * Vec3(-0.3, 0.2, 1);
  const Vec3 truly = tilted.rotation * Vec3(0.3, 0.2, 1);
  ASSERT_NEAR((in_mirror - Vec3(truly.x(), truly.y(), -truly.z())).norm(), 0, 0.02);
  EXPECT_EQ(rig.judged().verdict, Verdict::kPoor);
  EXPECT_THAT(rig.judged().reasons, Contains(AllOf(HasSubstr("behind: is mounted "),
                                                   HasSubstr("are its pictures mirrored"))));
}

TEST(RigVerdict, ACameraThatContradictsTheOthersIsNamed) {
  JudgedRig rig = as_believed();
  for (std::size_t i = 0; i < 20; ++i) {
    rig.calibration.tracks.seen[i].believed = false;
  }
  EXPECT_EQ(rig.judged().verdict, Verdict::kPoor);
  EXPECT_THAT(rig.judged().reasons,
              Contains(HasSubstr("behind: contradicts the others: 20 of 100")));
}

TEST(RigVerdict, AnotherLensIsNamed) {
  JudgedRig rig = as_believed();
  rig.calibration.bundle.state.lenses[1].fx_px *= 1.2;
  EXPECT_EQ(rig.judged().verdict, Verdict::kPoor);
  EXPECT_THAT(rig.judged().reasons,
              Contains(HasSubstr("behind: its pictures are of another lens")));

  JudgedRig ratio = as_believed();
  const double one_sigma = kFocalApart * ratio.cameras[1].believed.sigma.focal_ratio;
  double& fy_px = ratio.calibration.bundle.state.lenses[1].fy_px;
  fy_px *= 1 + 3 * one_sigma;
  EXPECT_EQ(ratio.judged().verdict, Verdict::kGood);
  fy_px *= 1 + 2 * one_sigma;
  EXPECT_EQ(ratio.judged().verdict, Verdict::kPoor);
  EXPECT_THAT(ratio.judged().reasons,
              Contains(HasSubstr("behind: its pictures are of another lens: the ratio")));
}

TEST(RigVerdict, WhatAMapAloneLeavesInDoubtOtherCamerasSettle) {
  JudgedRig rig = as_believed();
  rig.cameras[0].map.frames[50].lost = true;
  rig.cameras[0].map.lost_s = 0.1;
  EXPECT_EQ(rig.judged().verdict, Verdict::kGood);
  EXPECT_THAT(rig.judged().reasons, Contains(HasSubstr("ahead: its own map: it was lost")));
  rig.calibration.shared[0] = 30;
  EXPECT_EQ(rig.judged().verdict, Verdict::kPoor);
  rig.calibration.shared[0] = 100;
  rig.cameras[0].map.lost_s = 3;  // of 10 s
  EXPECT_EQ(rig.judged().verdict, Verdict::kPoor);
}

TEST(RigVerdict, ACameraWithoutAMapIsJudgedByThePointsOfOthers) {
  JudgedRig rig = as_believed();
  rig.cameras[1].adjusted = {};
  rig.calibration.hand_eye[1].reset();
  rig.calibration.by_others[1] = "it is covered";
  rig.calibration.shared[1] = 60;
  EXPECT_EQ(rig.judged().verdict, Verdict::kGood);
  EXPECT_THAT(rig.judged().doubts, IsEmpty()) << "it is said, and nothing is held against it";
  rig.calibration.shared[1] = 59;
  const Judged judged = rig.judged();
  EXPECT_EQ(judged.verdict, Verdict::kPoor);
  EXPECT_THAT(judged.reasons, ElementsAre(AllOf(HasSubstr("it is covered"), HasSubstr("59 points"),
                                                HasSubstr("than 60"))));
}

TEST(RigVerdict, WheelsThatContradictThePicturesAreNamed) {
  JudgedRig rig = as_believed();
  rig.calibration.bundle.state.wheel_errors[kTurnError] = 0.2;
  EXPECT_EQ(rig.judged().verdict, Verdict::kPoor);
  EXPECT_THAT(rig.judged().reasons, Contains(HasSubstr("the turn by +20.0 %")));
}

}  // namespace
}  // namespace panoptes
