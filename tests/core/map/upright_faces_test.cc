// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/upright_faces.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/camera/mounting.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

constexpr double kNoise_grey = 2;
constexpr double kWall_m = 1.6;

/// Level, beneath the floor camera.
RigCamera level_camera() {
  RigCamera camera = office_floor_camera();
  camera.floor.reset();
  camera.T_body_camera =
      mounted_camera(camera.T_body_camera.translation - Vec3(0, 0, 0.3), 0, deg_to_rad(5));
  return camera;
}

FloorProjection projection() { return project_floor(office_floor_camera(), Body{}); }

/// A wall across the way, of a brightness and a texture beside the floor's.
FloorScene walled(double brighter, double contrast) {
  FloorScene scene;
  scene.boxes.push_back({{kWall_m, -3}, {kWall_m + 1, 3}, 1.5, scene.carpet});
  Surface& wall = scene.boxes.front().surface;
  wall.bgr *= brighter;
  wall.contrast = contrast;
  wall.pattern = 7;
  return scene;
}

std::vector<std::optional<UprightFaces::Face>> faces_in(const FloorScene& scene,
                                                        const Levels* levels, FloorColour& colour) {
  const RigCamera camera = level_camera();
  Rng rng(3);
  const cv::Mat picture = draw(scene, camera, Pose2{}, rng);
  return UprightFaces::of(projection(), camera, kNoise_grey)->find(picture, levels, colour);
}

/// Of the rays that look ahead: the share that finds the wall, and of those the quarter of all that
/// are farthest off.
struct Found {
  double share = 0;
  double off_m = 0;
};
Found found(const std::vector<std::optional<UprightFaces::Face>>& faces) {
  std::vector<double> off_m;
  for (const auto& face : faces) {
    if (face) {
      off_m.push_back(std::abs(face->foot_view.x() - kWall_m));
    }
  }
  Found result;
  result.share = static_cast<double>(off_m.size()) / static_cast<double>(faces.size());
  if (!off_m.empty()) {
    const auto at = off_m.begin() + static_cast<std::ptrdiff_t>(off_m.size() * 3 / 4);
    std::nth_element(off_m.begin(), at, off_m.end());
    result.off_m = *at;
  }
  return result;
}

/// One that takes all greys like the floor's for floor.
FloorColour floor_colour() {
  FloorColour colour({}, 0.2);
  std::vector<Bgr> colours;
  for (int grey = 90; grey < 150; ++grey) {
    const auto level = static_cast<std::uint8_t>(grey);
    colours.push_back({level, level, level});
  }
  colour.learn(fit_colours(colours, 1));
  return colour;
}

TEST(UprightFaces, FindAPlainWallOfTheFloorsColourAtItsFoot) {
  FloorColour colour = floor_colour();
  const Found wall = found(faces_in(walled(1.12, 0), nullptr, colour));
  EXPECT_GT(wall.share, 0.7) << "the other rays leave this camera's picture";
  EXPECT_LT(wall.off_m, 0.15);
}

TEST(UprightFaces, FindATexturedWallOfTheFloorsColour) {
  FloorColour colour = floor_colour();
  const Levels levels = same_levels();
  const FloorScene scene = walled(1.12, 0.1);
  const Found by_colour = found(faces_in(scene, &levels, colour));
  EXPECT_GT(by_colour.share, 0.7);
  EXPECT_LT(by_colour.off_m, 0.2);
  // Texture has edges of its own, far over the foot.
  EXPECT_GT(found(faces_in(scene, nullptr, colour)).off_m, by_colour.off_m);
}

TEST(UprightFaces, LeaveTheFloorBeforeALowThing) {
  FloorColour colour = floor_colour();
  FloorScene scene = walled(1.12, 0);
  scene.boxes.front().height_m = 0.2;  // lower than the camera: it ends below the horizon
  scene.boxes.front().high.x() = kWall_m + 0.1;
  for (const auto& face : faces_in(scene, nullptr, colour)) {
    EXPECT_TRUE(!face || face->foot_view.norm() > kWall_m);
  }
}

TEST(UprightFaces, NeedACameraThatSeesTheHorizonAhead) {
  RigCamera camera = level_camera();
  EXPECT_TRUE(UprightFaces::of(projection(), camera, kNoise_grey).has_value());
  camera.T_body_camera = mounted_camera(camera.T_body_camera.translation, deg_to_rad(180), 0);
  EXPECT_FALSE(UprightFaces::of(projection(), camera, kNoise_grey).has_value()) << "looks back";
  camera.T_body_camera = mounted_camera(camera.T_body_camera.translation, 0, deg_to_rad(60));
  EXPECT_FALSE(UprightFaces::of(projection(), camera, kNoise_grey).has_value()) << "looks down";
}

}  // namespace
}  // namespace panoptes
