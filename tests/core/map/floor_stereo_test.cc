// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_stereo.h"

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "core/camera/mounting.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

constexpr double kBox_m = 1.2;  // its side that faces the robot

RigCamera level_camera(double tilt_deg = 5, double lower_m = 0.3) {
  RigCamera camera = office_floor_camera();
  camera.floor.reset();
  camera.T_body_camera = mounted_camera(camera.T_body_camera.translation - Vec3(0, 0, lower_m), 0,
                                        deg_to_rad(tilt_deg));
  camera.sigma.rotation_rad = Vec3::Constant(deg_to_rad(1));
  camera.sigma.position_m = Vec3::Constant(0.005);
  return camera;
}

/// A box of the floor's own colour and texture.
FloorScene scene_with_box() {
  FloorScene scene;
  scene.boxes.push_back({{kBox_m, -0.3}, {kBox_m + 0.5, 0.3}, 0.6, scene.carpet});
  scene.boxes.front().surface.pattern = 7;
  return scene;
}

/// What all that looks like floor shows from some places.
struct Looker {
  std::shared_ptr<const FloorProjection> projection =
      std::make_shared<FloorProjection>(project_floor(office_floor_camera(), Body{}));
  std::optional<FloorStereo> stereo;
  Rng rng{3};

  explicit Looker(const RigCamera& believed)
      : stereo(FloorStereo::of(projection, office_floor_camera().intrinsics, believed)) {}

  std::vector<UprightPoint> look(const FloorScene& scene, const RigCamera& second,
                                 const Pose2& T_scene_body) {
    const cv::Mat bgr = draw(scene, office_floor_camera(), T_scene_body, rng);
    const cv::Mat second_bgr = draw(scene, second, T_scene_body, rng);
    const std::vector<std::int8_t> floor(projection->pixel.size(), 8);
    const std::vector<std::int16_t> first(static_cast<std::size_t>(projection->rays),
                                          static_cast<std::int16_t>(projection->rows));
    return stereo->find({bgr, floor, first}, second_bgr, same_levels(),
                        T_scene_body * projection->T_body_view);
  }
};

/// A few places from which the box, if it is there, is seen.
std::vector<Pose2> places() {
  return {Pose2(0, 0, 0),       Pose2(0, 0.1, 0), Pose2(0.05, 0.05, 0.1), Pose2(0, -0.1, 0),
          Pose2(-0.1, 0, -0.1), Pose2(0.1, 0, 0), Pose2(-0.05, 0.1, 0),   Pose2(0.05, -0.1, 0.1)};
}

/// Points on the front of the box, and others.
void expect_box_found(const RigCamera& second) {
  Looker looker(second);
  ASSERT_TRUE(looker.stereo.has_value());
  int found = 0;
  int away = 0;
  for (const Pose2& T_scene_body : places()) {
    for (const UprightPoint& point : looker.look(scene_with_box(), second, T_scene_body)) {
      const bool at_box = std::abs(point.p_odom.x() - kBox_m) < 0.08 &&
                          std::abs(point.p_odom.y()) < 0.38 && point.height_m < 0.6;
      ++(at_box ? found : away);
    }
  }
  EXPECT_GE(found, 24);
  EXPECT_LE(10 * away, found);
}

TEST(FloorStereo, FindsWhatStandsAndLooksLikeFloor) { expect_box_found(level_camera()); }

TEST(FloorStereo, DoesSoWhereTheCamerasStandOverOtherPlaces) {
  RigCamera second = level_camera();
  second.T_body_camera.translation += Vec3(0.1, -0.08, 0);
  expect_box_found(second);
  second = level_camera(20, -0.3);
  expect_box_found(second);  // above the floor camera
}

TEST(FloorStereo, FindsNothingOnABareFloor) {
  Looker looker(level_camera());
  for (const Pose2& T_scene_body : places()) {
    EXPECT_TRUE(looker.look(FloorScene{}, level_camera(), T_scene_body).empty());
  }
}

TEST(FloorStereo, LearnsFromTheFloorHowTheSecondCameraIsTilted) {
  const RigCamera truth = level_camera(5.8);
  Looker looker(level_camera());
  for (const Pose2& T_scene_body : places()) {
    looker.look(FloorScene{}, truth, T_scene_body);
  }
  for (const Pose2& T_scene_body : places()) {
    EXPECT_TRUE(looker.look(FloorScene{}, truth, T_scene_body).empty());
  }
  EXPECT_FALSE(looker.look(scene_with_box(), truth, Pose2{}).empty());
}

TEST(FloorStereo, SaysNothingOfWhatHasNoTexture) {
  FloorScene scene = scene_with_box();
  scene.boxes.front().surface.contrast = 0;
  Looker looker(level_camera());
  for (const Pose2& T_scene_body : places()) {
    for (const UprightPoint& point : looker.look(scene, level_camera(), T_scene_body)) {
      EXPECT_GT(std::abs(point.p_odom.y()), 0.2) << "but of its edges";
    }
  }
  EXPECT_FALSE(looker.look(scene_with_box(), level_camera(), Pose2{}).empty());
}

TEST(FloorStereo, SaysNothingWhereTheTwoPicturesOfTheFloorDiffer) {
  // Of a floor that is not what the second camera shows.
  Looker looker(level_camera());
  for (const Pose2& T_scene_body : places()) {
    EXPECT_TRUE(looker.look(scene_with_box(), level_camera(11), T_scene_body).empty());
  }
}

TEST(FloorStereo, NeedsACameraThatSeesTheSameFloorFromAnotherHeight) {
  const auto projection =
      std::make_shared<FloorProjection>(project_floor(office_floor_camera(), Body{}));
  const Intrinsics lens = office_floor_camera().intrinsics;
  EXPECT_TRUE(FloorStereo::of(projection, lens, level_camera()).has_value());
  EXPECT_FALSE(FloorStereo::of(projection, lens, level_camera(5, 0)).has_value()) << "as high";
  RigCamera back = level_camera();
  back.T_body_camera = mounted_camera(back.T_body_camera.translation, deg_to_rad(180), 0);
  EXPECT_FALSE(FloorStereo::of(projection, lens, back).has_value()) << "looks back";
}

}  // namespace
}  // namespace panoptes
