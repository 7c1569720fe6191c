// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_projection.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>

#include "core/base/error.h"
#include "tests/support/floor_scene.h"

namespace panoptes {
namespace {

using testing::HasSubstr;

constexpr double kRoundoff_m = 1e-9;

std::string fault_of(const RigCamera& camera) {
  try {
    project_floor(camera, Body{});
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(FloorProjection, EveryCellLooksAtThePixelThatSeesIt) {
  const RigCamera camera = office_floor_camera();
  const FloorProjection p = project_floor(camera, Body{});
  const Pose3 T_camera_body = camera.T_body_camera.inverse();
  int cells = 0;
  for (int row = 0; row < p.cell_rows; ++row) {
    for (int column = 0; column < p.cell_columns; ++column) {
      const std::int32_t s = p.sample[static_cast<std::size_t>(row * p.cell_columns + column)];
      if (s < 0) {
        continue;
      }
      ++cells;
      const Vec2 at = p.origin_view + p.cell_m * Vec2(column + 0.5, row + 0.5);
      const Vec2 px = camera.intrinsics.project(T_camera_body * Vec3(at.x(), at.y(), 0));
      const std::int32_t pixel = p.pixel[static_cast<std::size_t>(s)];
      // the nearest sample is within half a ray and half a row: a pixel each way where samples are
      // a pixel apart, two where three quarters of a cell are
      EXPECT_NEAR(pixel % 320, px.x(), 2.5);
      EXPECT_NEAR(pixel / 320, px.y(), 2.5);
    }
  }
  EXPECT_GT(cells, 80000);  // 0.19 to 3 m, 1.2 to 5.4 m wide
}

TEST(FloorProjection, KnowsTheBlindGapAndTheFoot) {
  const FloorProjection p = project_floor(office_floor_camera(), Body{});
  EXPECT_NEAR(p.foot_view.x(), 0.01, kRoundoff_m);
  EXPECT_NEAR(p.foot_view.y(), 0, kRoundoff_m);
  EXPECT_NEAR(p.height_m, 0.75, kRoundoff_m);
  EXPECT_NEAR(p.blind_zone_m, 0.2, 0.011);  // a cell
}

TEST(FloorProjection, FindsTheCameraFromFourMarks) {
  RigCamera camera = office_floor_camera();
  const Pose3 T_camera_body = camera.T_body_camera.inverse();
  for (const Vec2& mark : {Vec2(0.6, -0.4), Vec2(0.6, 0.4), Vec2(2, -1), Vec2(2.2, 1.1)}) {
    camera.floor->marks.push_back(
        {mark, camera.intrinsics.project(T_camera_body * Vec3(mark.x(), mark.y(), 0))});
  }
  const FloorProjection exact = project_floor(camera, Body{});
  EXPECT_NEAR(exact.height_m, 0.75, 1e-6);
  EXPECT_NEAR(exact.foot_view.x(), 0.01, 1e-6);
  // the believed mounting is not asked where there are marks
  camera.T_body_camera = mounted_camera(Vec3(0.01, 0, 0.75), 0, deg_to_rad(20));
  EXPECT_NEAR(project_floor(camera, Body{}).height_m, 0.75, 1e-6);
}

TEST(FloorProjection, WeighsFarCellsByTheFloorTheirPixelCovers) {
  const FloorProjection p = project_floor(office_floor_camera(), Body{});
  const auto middle = static_cast<std::size_t>(p.rays / 2);
  int last = FloorProjection::kFullWeight;
  for (std::size_t row = 0; row < static_cast<std::size_t>(p.rows); ++row) {
    const std::size_t i = row * static_cast<std::size_t>(p.rays) + middle;
    if (p.pixel[i] < 0) {
      continue;
    }
    EXPECT_LE(p.weight[i], last);
    last = p.weight[i];
    if (std::abs(p.range_m[i] - 2) < 0.02) {
      EXPECT_NEAR(p.depth_m[i], 0.03, 0.003);  // one row at 2 m with this camera
    }
  }
  EXPECT_LE(last, 3);
  EXPECT_GE(last, 1);
}

TEST(FloorProjection, MapsTheLowerHalfAlone) {
  RigCamera camera = office_floor_camera();
  camera.floor->rows = FloorView::Rows::kLowerHalf;
  const FloorProjection p = project_floor(camera, Body{});
  for (const std::int32_t pixel : p.pixel) {
    EXPECT_TRUE(pixel < 0 || pixel / 320 >= 120);
  }
}

TEST(FloorProjection, IsTheSameForACameraThatLooksAnotherWay) {
  RigCamera camera = office_floor_camera();
  camera.floor->marks.clear();
  const FloorProjection ahead = project_floor(camera, Body{});
  const double turn_rad = deg_to_rad(150);
  camera.T_body_camera = on_floor({0, 0, turn_rad}) * camera.T_body_camera;
  const FloorProjection behind = project_floor(camera, Body{});
  EXPECT_NEAR(behind.T_body_view.theta_rad, turn_rad, 1e-9);
  EXPECT_NEAR((behind.foot_view - ahead.foot_view).norm(), 0, 1e-9);
  EXPECT_NEAR(behind.front_m, ahead.front_m, 1e-9);
  EXPECT_EQ(behind.rays, ahead.rays);
  EXPECT_EQ(behind.rows, ahead.rows);
}

TEST(FloorProjection, RefusesWhatSeesNoFloor) {
  RigCamera camera = office_floor_camera();
  camera.T_body_camera = mounted_camera(Vec3(0, 0, 0.75), 0, deg_to_rad(-60));
  EXPECT_THAT(fault_of(camera), HasSubstr("sees no floor"));
  camera.floor.reset();
  EXPECT_THAT(fault_of(camera), HasSubstr("which part of its picture"));
}

TEST(FloorProjection, RefusesMarksOnALine) {
  RigCamera camera = office_floor_camera();
  for (int i = 0; i < 4; ++i) {
    camera.floor->marks.push_back({Vec2(0.5 + 0.2 * i, 0), Vec2(160, 200 - 20 * i)});
  }
  EXPECT_THAT(fault_of(camera), HasSubstr("no three on a line"));
}

}  // namespace
}  // namespace panoptes
