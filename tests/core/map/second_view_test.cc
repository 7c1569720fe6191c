// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/second_view.h"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "core/camera/mounting.h"
#include "core/geometry/pose3.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

/// Level, beneath the floor camera.
RigCamera level_below() {
  RigCamera camera = office_floor_camera();
  camera.floor.reset();
  camera.T_body_camera =
      mounted_camera(camera.T_body_camera.translation - Vec3(0, 0, 0.3), 0, deg_to_rad(5));
  return camera;
}

FloorProjection floor_projection() { return project_floor(office_floor_camera(), Body{}); }

/// Where the ray of a pixel meets the floor, seen from a foot.
double range_of(const RigCamera& camera, std::int32_t pixel, const Vec2& foot) {
  const int width = camera.intrinsics.width_px;
  const Vec3 ray =
      camera.T_body_camera.rotation * camera.intrinsics.ray(Vec2(pixel % width, pixel / width));
  const Vec3 c = camera.T_body_camera.translation;
  return (Vec2((c - c.z() / ray.z() * ray).head<2>()) - foot).norm();
}

TEST(SecondView, SamplesLieWhereThePixelsMeetTheFloor) {
  const FloorProjection projection = floor_projection();
  const RigCamera camera = level_below();
  const std::optional<SecondView> view = second_view(projection, camera);
  ASSERT_TRUE(view.has_value());
  int seen = 0;
  for (std::size_t i = 0; i < view->pixel.size(); ++i) {
    if (view->pixel[i] >= 0) {
      const double off_m = range_of(camera, view->pixel[i], view->foot_view) -
                           static_cast<double>(projection.range_m[i]);
      EXPECT_LT(std::abs(off_m), 0.75 * static_cast<double>(view->depth_m[i]) + 0.01);
      ++seen;
    }
  }
  EXPECT_GT(seen, static_cast<int>(view->pixel.size()) / 4);
  EXPECT_GE(view->pairs.size(), 100U);
}

TEST(SecondView, ACameraThatSeesNoneOfTheFloorOrFromTheSameHeightIsNone) {
  const FloorProjection projection = floor_projection();
  RigCamera camera = level_below();
  camera.T_body_camera = mounted_camera(camera.T_body_camera.translation, deg_to_rad(180), 0);
  EXPECT_FALSE(second_view(projection, camera).has_value()) << "looks back";
  EXPECT_FALSE(second_view(projection, office_floor_camera()).has_value()) << "the same";
}

TEST(SecondView, RangesChangeWithTheMountingAsIsSaid) {
  const FloorProjection projection = floor_projection();
  const RigCamera camera = level_below();
  const std::optional<SecondView> view = second_view(projection, camera);
  ASSERT_TRUE(view.has_value());
  RigCamera tilted = camera;
  const double tilt_rad = deg_to_rad(0.2);
  tilted.T_body_camera = displaced(camera.T_body_camera, {.rotation_rad = {0, tilt_rad, 0}});
  RigCamera raised = camera;
  raised.T_body_camera = displaced(camera.T_body_camera, {.shift_m = {0, 0, 0.004}});
  for (std::size_t i = 0; i < view->pixel.size(); i += 97) {
    if (view->pixel[i] < 0) {
      continue;
    }
    const double range_m = range_of(camera, view->pixel[i], view->foot_view);
    if (range_m > 2.5) {
      continue;
    }
    const double angle = projection.first_ray_rad +
                         static_cast<double>(i % static_cast<std::size_t>(projection.rays)) *
                             projection.ray_step_rad;
    const Vec3 by = view->range_error(range_m, angle);
    const double nearer_m = range_m - range_of(tilted, view->pixel[i], view->foot_view);
    EXPECT_NEAR(nearer_m, tilt_rad * by.y(), 0.15 * tilt_rad * by.y());
    const double farther_m = range_of(raised, view->pixel[i], view->foot_view) - range_m;
    EXPECT_NEAR(farther_m, 0.004 / view->height_m * by.x(), 0.001);
  }
}

TEST(SecondView, AnotherExposureIsEvenedOut) {
  const RigCamera floor_camera = office_floor_camera();
  const RigCamera camera = level_below();
  const FloorProjection projection = floor_projection();
  const std::optional<SecondView> view = second_view(projection, camera);
  ASSERT_TRUE(view.has_value());
  FloorScene scene;
  scene.carpet.bgr = Vec3(90, 110, 150);
  scene.boxes.push_back({{1.6, -0.3}, {2.4, 0.3}, 0.7, {{160, 90, 60}, 0.1, 5}});
  Rng rng(2);
  const cv::Mat picture = draw(scene, floor_camera, Pose2{}, rng);
  cv::Mat darker;
  draw(scene, camera, Pose2{}, rng).convertTo(darker, -1, 0.55);
  FloorColour colour({}, 0.2);
  std::vector<Bgr> colours;
  std::vector<std::int8_t> known(projection.pixel.size(), 0);
  for (std::size_t i = 0; i < known.size(); ++i) {
    const bool clear = projection.range_m[i] < 1.2F;
    if (clear && projection.pixel[i] >= 0) {
      const std::uint8_t* p = picture.data + 3 * static_cast<std::ptrdiff_t>(projection.pixel[i]);
      colours.push_back({p[0], p[1], p[2]});
      known[i] = FloorColour::kClip;
    }
  }
  colour.learn(fit_colours(colours, 3));

  const std::optional<Levels> levels = levels_alike(*view, darker, projection, picture, known);
  ASSERT_TRUE(levels.has_value());
  const std::vector<std::int8_t> rated = rate_second(*view, darker, *levels, colour);
  ASSERT_EQ(rated.size(), known.size());
  int floor = 0;
  int floor_seen = 0;
  int box = 0;
  int box_seen = 0;
  for (std::size_t i = 0; i < rated.size(); ++i) {
    if (view->pixel[i] < 0) {
      continue;
    }
    const double angle = projection.first_ray_rad +
                         static_cast<double>(i % static_cast<std::size_t>(projection.rays)) *
                             projection.ray_step_rad;
    const Vec2 at = view->foot_view + static_cast<double>(projection.range_m[i]) *
                                          Vec2(std::cos(angle), std::sin(angle));
    if (at.x() < 1.5) {
      ++floor_seen;
      floor += rated[i] > 0 ? 1 : 0;
    } else if (at.x() > 1.7 && std::abs(at.y()) < 0.25) {
      ++box_seen;
      box += rated[i] < 0 ? 1 : 0;
    }
  }
  ASSERT_GT(floor_seen, 500);
  ASSERT_GT(box_seen, 500);
  EXPECT_GT(floor, 0.95 * floor_seen);
  EXPECT_GT(box, 0.95 * box_seen);
  EXPECT_FALSE(
      levels_alike(*view, darker, projection, picture, std::vector<std::int8_t>(known.size(), 0))
          .has_value())
      << "no floor is known";
}

}  // namespace
}  // namespace panoptes
