// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_calibration.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/calib/rig_verdict.h"
#include "core/camera/mounting.h"
#include "tests/support/driven_rose.h"
#include "tests/support/room_pictures.h"

namespace panoptes {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSubsetOf;

/// Two cameras that look away from each other, in a bare room that a robot drives a rose in.
class RigCalibrationTest : public testing::Test {
 protected:
  void SetUp() override {
    RoseShape rose;
    rose.legs = 6;
    rose.leg_m = 0.3;
    rose.turn_rad = 1.1;
    rose.period_s = 1.0 / 6;
    rose.noise_m = 0.005;
    drive_.emplace(rose, Rng(3));
    const Rng rng(4);
    for (const std::string name : {"ahead", "behind"}) {
      const bool is_ahead = name == "ahead";
      RigCamera truth;
      truth.intrinsics = lens_of_view(320, 240, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
      truth.T_body_camera = mounted_camera({is_ahead ? 0.15 : -0.15, 0.02, is_ahead ? 0.7 : 0.75},
                                           is_ahead ? 0.05 : std::numbers::pi - 0.1, 0.05);
      truth.sigma.focal_ratio = 0.001;
      truth.sigma.centre_px = 0.3;
      MappedCamera mapped{name, truth, {}, {}};
      mapped.believed.T_body_camera =
          displaced(truth.T_body_camera,
                    {Vec3(0.02, -0.03, 0.04), Vec3(0.02, -0.02, is_ahead ? 0.02 : -0.01)});
      // x right, y down, z ahead from x ahead, y left, z up
      const Pose3 T_room_start{
          Eigen::Quaterniond(Eigen::Matrix3d((Mat3() << 0, -1, 0, 0, 0, -1, 1, 0, 0).finished())),
          Vec3(0, 0.5, 0)};
      const RoomPainter painter(truth.intrinsics, 160, rng);  // one room for both
      Rng noise = rng.fork(name);
      MonoSlam slam({}, truth.intrinsics);
      MonoMapBuilder builder;
      pictures_.emplace_back();
      for (std::size_t i = 0; i < drive_->instants(); ++i) {
        const Pose3 T = T_room_start * on_floor(drive_->T_start_body(i)) * truth.T_body_camera;
        pictures_.back().push_back(painter.draw(T, noise));
        builder.add(drive_->instant(i), slam.step(pictures_.back().back(), drive_->instant(i)));
      }
      mapped.map = builder.map(slam);
      mapped.adjusted = adjust_map({}, truth.intrinsics, truth.sigma, mapped.map);
      truth_.push_back(truth);
      cameras_.push_back(mapped);
    }
    calibration_ = calibration_of(cameras_);
  }
  RigCalibration calibration_of(const std::vector<MappedCamera>& cameras) const {
    return calibrate_rig(
        {}, cameras, [this](Time at) { return drive_->wheels(at); },
        [&](std::size_t c, std::size_t frame) {
          const std::size_t given_up = pictures_[c].size() - cameras[c].map.frames.size();
          return pictures_[c][given_up + frame];
        },
        [](double) {});
  }
  void expect_a_camera_without_a_map_is_found() const;
  void expect_true(const RigCalibration& calibration) const;
  void expect_what_is_true() const;
  void expect_a_rig_file_with_it() const;
  void expect_swapped_pictures_are_named() const;
  void expect_a_scene_that_shows_turns_alone_is_named() const;

  std::optional<DrivenRose> drive_;
  std::optional<RigCalibration> calibration_;
  std::vector<std::vector<cv::Mat>> pictures_;
  std::vector<MappedCamera> cameras_;
  std::vector<RigCamera> truth_;
};

void RigCalibrationTest::expect_true(const RigCalibration& calibration) const {
  const RigBundleState& state = calibration.bundle.state;
  const Pose3 found = state.T_body_camera[0].inverse() * state.T_body_camera[1];
  const Pose3 truth = truth_[0].T_body_camera.inverse() * truth_[1].T_body_camera;
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), deg_to_rad(0.1));
  EXPECT_LT((found.translation - truth.translation).norm(), 0.01);
  for (std::size_t c = 0; c < truth_.size(); ++c) {
    const MountingOffset off = mounting_offset(truth_[c].T_body_camera, state.T_body_camera[c]);
    EXPECT_LT(off.rotation_rad.head<2>().norm(), deg_to_rad(0.2));
    EXPECT_LT(std::abs(off.rotation_rad.z()), deg_to_rad(0.7));
    EXPECT_LT(off.shift_m.head<2>().norm(), 0.01);
    EXPECT_GT(calibration.shared[c], 20);
  }
}

void RigCalibrationTest::expect_what_is_true() const {
  expect_true(*calibration_);
  EXPECT_GT(calibration_->bundle.observations_other, 200);
  EXPECT_EQ(judge_rig(cameras_, *calibration_).verdict, Verdict::kGood)
      << testing::PrintToString(judge_rig(cameras_, *calibration_).reasons);
}

void RigCalibrationTest::expect_a_rig_file_with_it() const {
  Rig file;
  for (const MappedCamera& camera : cameras_) {
    file.cameras[camera.name] = camera.believed;
  }
  const Rig rig = calibrated(file, *calibration_);
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    const RigCamera& camera = rig.cameras.at(cameras_[c].name);
    EXPECT_LT(camera.T_body_camera.rotation.angularDistance(
                  calibration_->bundle.state.T_body_camera[c].rotation),
              1e-9);
    EXPECT_LT(camera.sigma.rotation_rad.x(), deg_to_rad(0.1));
    EXPECT_LT(camera.sigma.position_m.x(), 0.005);
    EXPECT_GT(camera.sigma.position_m.z(), 0.005) << "no motion over a floor shows the height";
  }
}

void RigCalibrationTest::expect_swapped_pictures_are_named() const {
  std::vector<MappedCamera> swapped = cameras_;
  std::swap(swapped[0].believed, swapped[1].believed);
  const Judged judged = judge_rig(swapped, *calibration_);
  EXPECT_EQ(judged.verdict, Verdict::kPoor);
  EXPECT_THAT(judged.reasons, Contains(HasSubstr("are their pictures swapped?")));

  // What is written of it claims no more than was known before.
  Rig file;
  for (const MappedCamera& camera : swapped) {
    file.cameras[camera.name] = camera.believed;
  }
  const Rig found = calibrated(file, *calibration_);
  const Rig rig = believed_after(found, file, judged);
  EXPECT_THAT(rig.doubts, IsSubsetOf(judged.reasons));
  EXPECT_THAT(rig.doubts, Contains(HasSubstr("are their pictures swapped?")));
  EXPECT_EQ(rig.cameras.at("ahead").sigma.rotation_rad,
            file.cameras.at("ahead").sigma.rotation_rad);
  EXPECT_EQ(rig.cameras.at("ahead").T_body_camera.translation,
            found.cameras.at("ahead").T_body_camera.translation);
  EXPECT_THAT(believed_after(rig, file, Judged()).doubts, IsEmpty());
}

void RigCalibrationTest::expect_a_camera_without_a_map_is_found() const {
  std::vector<MappedCamera> cameras = cameras_;
  MappedCamera& blind = cameras[1];
  blind.adjusted = {};
  blind.map = {};
  for (std::size_t i = 0; i < drive_->instants(); ++i) {
    blind.map.frames.push_back({drive_->instant(i), {}, true});
  }
  const RigCalibration found = calibration_of(cameras);
  expect_true(found);
  EXPECT_THAT(found.by_others, ElementsAre("", HasSubstr("holds 0 points")));
  EXPECT_EQ(judge_rig(cameras, found).verdict, Verdict::kGood);
  cameras[0] = cameras[1];
  EXPECT_THROW(calibration_of(cameras), HandEyeError);
}

void RigCalibrationTest::expect_a_scene_that_shows_turns_alone_is_named() const {
  std::vector<MappedCamera> cameras = cameras_;
  Rng rng(5);
  for (MappedCamera& camera : cameras) {
    for (MonoMap::Frame& frame : camera.map.frames) {
      frame.T_map_camera.translation.setZero();
    }
    for (Pose3& T_map_camera : camera.adjusted.T_map_camera) {
      T_map_camera.translation = 0.001 * Vec3(rng.normal(), rng.normal(), rng.normal());
    }
  }
  EXPECT_THAT([&] { calibration_of(cameras); },
              testing::ThrowsMessage<HandEyeError>(
                  testing::AllOf(HasSubstr("ahead: the camera's path and the wheels' do not fit"),
                                 HasSubstr("too distant for anything but turns"))));
}

TEST_F(RigCalibrationTest, FindsHowCamerasThatLookAwayFromEachOtherAreMounted) {
  expect_what_is_true();
  expect_a_rig_file_with_it();
  expect_swapped_pictures_are_named();
  expect_a_camera_without_a_map_is_found();
  expect_a_scene_that_shows_turns_alone_is_named();
}

}  // namespace
}  // namespace panoptes
