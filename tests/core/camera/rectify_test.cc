// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/rectify.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_px = 1e-6;

Rig rig_of(const Intrinsics& lens) {
  Rig rig;
  rig.cameras["a"].intrinsics = lens;
  return rig;
}

// Smooth in the direction looked at, so that no pixel's size matters.
cv::Vec3b colour_of(const Vec3& d) {
  return {cv::saturate_cast<std::uint8_t>(128 + 100 * std::sin(3 * d.x())),
          cv::saturate_cast<std::uint8_t>(128 + 100 * std::sin(4 * d.y())),
          cv::saturate_cast<std::uint8_t>(128 + 100 * d.z())};
}

cv::Mat drawn(const Intrinsics& lens) {
  cv::Mat bgr(lens.height_px, lens.width_px, CV_8UC3);
  for (int v = 0; v < lens.height_px; ++v) {
    for (int u = 0; u < lens.width_px; ++u) {
      bgr.at<cv::Vec3b>(v, u) = colour_of(lens.direction(Vec2(u, v)).value());
    }
  }
  return bgr;
}

TEST(Rectifier, GivesWhatAPinholeWouldHaveSeen) {
  for (const Distortion& d :
       std::vector<Distortion>{BrownConrady{-0.28, 0.09, 0.001, -0.001, 0},
                               BrownConrady{0.1, 0, 0, 0, 0}, Equidistant{0.02, -0.003, 0, 0}}) {
    const Intrinsics lens = lens_of_view(320, 240, deg_to_rad(85), d);
    const Rectifier rectifier(rig_of(lens));
    ASSERT_TRUE(rectifier.bends());
    const Intrinsics& straight = rectifier.rig().cameras.at("a").intrinsics;
    EXPECT_TRUE(straight.is_pinhole());
    EXPECT_EQ(straight.width_px, 320);
    Observation seen;
    seen.pictures["a"] = {time_at(3), drawn(lens)};
    const Picture out = rectifier.rectified(seen).pictures.at("a");
    EXPECT_EQ(out.stamp, time_at(3));
    constexpr double kGreyLevels = 3;  // two roundings and a 64th of a pixel
    EXPECT_LE(cv::norm(out.bgr, drawn(straight), cv::NORM_INF), kGreyLevels);
  }
}

TEST(Rectifier, TellsSigmasInItsOwnPixels) {
  const Intrinsics lens = lens_of_view(320, 240, deg_to_rad(90), Equidistant{});
  const Rectifier rectifier(rig_of(lens));
  const RigCamera& straight = rectifier.rig().cameras.at("a");
  EXPECT_NEAR(straight.sigma.centre_px / straight.intrinsics.fx_px,
              rig_of(lens).cameras.at("a").sigma.centre_px / lens.fx_px, 1e-12);
}

TEST(Rectifier, LeavesPicturesOfPinholesAlone) {
  Rig rig = rig_of(pinhole(320, 240, deg_to_rad(80)));
  rig.cameras["a"].floor.emplace().marks = {{{1, 0}, {10.5, 20}}};
  const Rectifier rectifier(rig);
  EXPECT_FALSE(rectifier.bends());
  EXPECT_EQ(rectifier.rig().cameras.at("a").floor->marks[0].px, Vec2(10.5, 20));
  Observation seen;
  seen.pictures["a"] = {Time{}, cv::Mat(240, 320, CV_8UC3)};
  EXPECT_EQ(rectifier.rectified(seen).pictures.at("a").bgr.data, seen.pictures.at("a").bgr.data);
}

TEST(Rectifier, MovesFloorMarksWithThePicture) {
  const Intrinsics lens = lens_of_view(320, 240, deg_to_rad(90), Equidistant{});
  Rig rig = rig_of(lens);
  Rng rng(1);
  std::vector<Vec3> rays;
  FloorView floor;
  for (int i = 0; i < 4; ++i) {
    rays.emplace_back(rng.uniform(-0.5, 0.5), rng.uniform(-0.4, 0.4), 1);
    floor.marks.push_back({Vec2(i, i), lens.project(rays.back())});
  }
  rig.cameras["a"].floor = floor;
  const Rectifier rectifier(rig);
  const RigCamera& straight = rectifier.rig().cameras.at("a");
  ASSERT_EQ(straight.floor->marks.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((straight.floor->marks[i].px - straight.intrinsics.project(rays[i])).norm(),
              kRoundoff_px);
  }
}

TEST(Rectified, IsAsWideAsTheLensAllowsAndNoWider) {
  // A fisheye of 190 degrees: cut at 55 degrees off the axis.
  const Intrinsics fisheye = rectified(lens_of_view(320, 240, deg_to_rad(190), Equidistant{}));
  EXPECT_NEAR(std::atan(159.5 / fisheye.fx_px), deg_to_rad(55), 1e-9);
  // A barrel: its sides' middles are the nearest, so there the two pictures meet.
  const Intrinsics barrel =
      lens_of_view(320, 240, deg_to_rad(80), BrownConrady{-0.2, 0.02, 0, 0, 0});
  const Intrinsics straight = rectified(barrel);
  double nearest_px = 1e9;
  for (const Vec2& px : {Vec2(0, 119.5), Vec2(159.5, 0), Vec2(319, 119.5), Vec2(159.5, 239)}) {
    const Vec2 raw = barrel.project(straight.ray(px));
    nearest_px = std::min({nearest_px, raw.x(), raw.y(), 319 - raw.x(), 239 - raw.y()});
  }
  EXPECT_NEAR(nearest_px, 0, 0.01);  // half-integer places stand for the nearest pixel's
}

}  // namespace
}  // namespace panoptes
