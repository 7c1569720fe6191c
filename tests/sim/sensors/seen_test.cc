// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/seen.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "sim/sensors/floor_pixels.h"

namespace panoptes::sim {
namespace {

RigCamera floor_camera() {
  RigCamera camera;
  camera.roles = {"floor"};
  camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
  camera.T_body_camera = mounted_camera({0.02, 0, 0.75}, 0, deg_to_rad(28));
  camera.floor = FloorView{};
  return camera;
}

TruthLayer empty_layer() {
  TruthLayer layer;
  layer.cell_m = 0.05;
  layer.origin = {-5, -5};
  layer.columns = 200;
  layer.rows = 200;
  layer.cells.resize(40'000);
  return layer;
}

// Everything nearer than `wall_m` ahead of the body's middle is floor, the rest a wall.
cv::Mat label_before_wall(const RigCamera& camera, double wall_m) {
  cv::Mat label(240, 320, CV_8UC1);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      const auto p_body = floor_under(camera, Vec2(u, v));
      label.at<std::uint8_t>(v, u) = p_body && p_body->x() < wall_m ? 255 : 0;
    }
  }
  return label;
}

TEST(FloorUnder, InvertsTheProjection) {
  const RigCamera camera = floor_camera();
  const Vec2 p_body(1.3, -0.4);
  const Vec3 p_camera = camera.T_body_camera.inverse() * Vec3(p_body.x(), p_body.y(), 0);
  const auto back = floor_under(camera, camera.intrinsics.project(p_camera));
  ASSERT_TRUE(back);
  constexpr double kRoundoff_m = 1e-12;
  EXPECT_NEAR((*back - p_body).norm(), 0, kRoundoff_m);
  EXPECT_FALSE(floor_under(camera, Vec2(160, 0))) << "above the horizon";
}

TEST(SeenFloor, MarksTheFloorUpToTheFootOfAWallWithinRange) {
  const RigCamera camera = floor_camera();
  const Body body;
  const SeenFloor watcher(camera, body);
  for (const Pose2 pose : {Pose2{0, 0, 0}, Pose2{1, -0.5, 2.1}}) {
    TruthLayer seen = empty_layer();
    TruthLayer wall = empty_layer();
    const Vec2 foot = pose * Vec2(1.52, 0);
    wall(wall.column(foot), wall.row(foot)) = 1;
    watcher.mark(label_before_wall(camera, 1.52), pose, wall, seen);
    const auto seen_at = [&](double x_body, double y_body) {
      return seen.at(pose * Vec2(x_body, y_body));
    };
    EXPECT_FALSE(seen_at(0.3, 0)) << "the blind zone";
    EXPECT_TRUE(seen_at(0.55, 0));
    EXPECT_TRUE(seen_at(1.2, 0.5));
    EXPECT_TRUE(seen_at(1.52, 0)) << "the foot";
    EXPECT_FALSE(seen_at(1.55, 0.5)) << "something that hangs over a floor that is not seen";
    EXPECT_FALSE(seen_at(1.65, 0)) << "behind the wall";
    EXPECT_FALSE(seen_at(1.2, 2)) << "beside the picture";
  }
}

TEST(SeenFloor, IsCutAtItsRange) {
  const RigCamera camera = floor_camera();
  TruthLayer seen = empty_layer();
  const SeenFloor watcher(camera, Body{});
  watcher.mark(label_before_wall(camera, 1e9), {}, empty_layer(), seen);
  EXPECT_TRUE(seen.at({3.2, 0}));
  EXPECT_FALSE(seen.at({3.35, 0}));
}

TEST(SeenFloor, MarksTheFirstFootOfAColumnOnly) {
  const RigCamera camera = floor_camera();
  cv::Mat label = label_before_wall(camera, 1e9);
  // A thin thing across the picture at rows 150 to 153, a second one at rows 120 to 123.
  label.rowRange(150, 154).setTo(0);
  label.rowRange(120, 124).setTo(0);
  TruthLayer seen = empty_layer();
  seen.cell_m = 0.01;  // finer than the things
  seen.columns = seen.rows = 1000;
  seen.cells.assign(1'000'000, 0);
  TruthLayer full = seen;
  full.cells.assign(full.cells.size(), 1);
  SeenFloor(camera, Body{}).mark(label, {}, full, seen);
  EXPECT_TRUE(seen.at(*floor_under(camera, {160, 140})))
      << "floor beyond the thing is seen as well";
  EXPECT_TRUE(seen.at(*floor_under(camera, {160, 153}))) << "its foot";
  EXPECT_FALSE(seen.at(*floor_under(camera, {160, 151})));
  EXPECT_FALSE(seen.at(*floor_under(camera, {160, 123}))) << "a second foot";
}

TEST(SeenFloor, LowerHalfMapsTheLowerRowsOnly) {
  RigCamera camera = floor_camera();
  camera.floor->rows = FloorView::Rows::kLowerHalf;
  TruthLayer seen = empty_layer();
  SeenFloor(camera, Body{})
      .mark(cv::Mat(240, 320, CV_8UC1, cv::Scalar(255)), {}, empty_layer(), seen);
  EXPECT_TRUE(seen.at(*floor_under(camera, {160, 122})));
  EXPECT_FALSE(seen.at(*floor_under(camera, {160, 112})));
}

}  // namespace
}  // namespace panoptes::sim
