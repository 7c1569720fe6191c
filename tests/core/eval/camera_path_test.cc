// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/camera_path.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-9;

/// A tilted camera beside the axis of a robot that drives a circle of 1 m.
std::vector<Pose3> circle() {
  std::vector<Pose3> poses;
  for (int i = 0; i < 100; ++i) {
    const double angle_rad = 0.05 * i;
    poses.push_back(on_floor({std::cos(angle_rad), std::sin(angle_rad), angle_rad + M_PI / 2}) *
                    mounted_camera({0.1, 0.05, 0.7}, 0.3, 0.2));
  }
  return poses;
}

/// As a filter has it that calls its first camera the map and 0.5 m a metre.
std::vector<Pose3> as_map(const std::vector<Pose3>& T_scene_camera, double scale) {
  std::vector<Pose3> poses;
  for (const Pose3& T : T_scene_camera) {
    poses.push_back(T_scene_camera.front().inverse() * T);
    poses.back().translation /= scale;
  }
  return poses;
}

TEST(CameraPath, ThatIsRightButForItsScaleHasNoErrors) {
  const CameraPathErrors errors = camera_path_errors(as_map(circle(), 0.5), circle());
  EXPECT_NEAR(errors.scale, 0.5, kRoundoff);
  EXPECT_NEAR(errors.position_rms_m, 0, kRoundoff);
  EXPECT_NEAR(errors.heading_error_rad.back(), 0, kRoundoff);
  EXPECT_NEAR(errors.path_m, 99 * 0.05 * std::hypot(1 - 0.05, 0.1), 0.01);
}

TEST(CameraPath, HeadingIsAboutTheVerticalWhicheverWayTheCameraLooks) {
  std::vector<Pose3> path = as_map(circle(), 1);
  const Vec3 up_camera = circle().back().rotation.conjugate() * Vec3::UnitZ();
  const Eigen::Quaterniond before = path.back().rotation;
  path.back().rotation = before * turned_by(-0.02 * up_camera);
  EXPECT_NEAR(camera_path_errors(path, circle()).heading_error_rad.back(), 0.02, kRoundoff);
  path.back().rotation = before * turned_by(0.02 * up_camera.unitOrthogonal());  // a tilt
  EXPECT_NEAR(camera_path_errors(path, circle()).heading_error_rad.back(), 0, kRoundoff);
}

TEST(CameraPath, OneWrongPlaceIsTold) {
  std::vector<Pose3> path = as_map(circle(), 1);
  path[50].translation += Vec3(0, 0.1, 0);
  const CameraPathErrors errors = camera_path_errors(path, circle());
  EXPECT_NEAR(errors.position_rms_m, 0.1 / std::sqrt(100), 0.001);
}

TEST(CameraPath, OfNothingHasNoErrors) {
  EXPECT_TRUE(camera_path_errors({}, {}).heading_error_rad.empty());
}

}  // namespace
}  // namespace panoptes
