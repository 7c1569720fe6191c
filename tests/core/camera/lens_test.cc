// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "core/base/rng.h"
#include "core/camera/rig.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_px = 1e-8;
constexpr double kPi = std::numbers::pi;

Intrinsics lens(const Distortion& distortion, double f_px = 400) {
  return {640, 480, f_px, 1.01 * f_px, 322.3, 236.8, distortion};
}

std::vector<Intrinsics> lenses() {
  return {lens(NoDistortion{}),
          lens(BrownConrady{-0.28, 0.09, 0.0012, -0.0007, -0.012}),  // barrel
          lens(BrownConrady{0.12, -0.03, -0.002, 0.001, 0.01}),      // pincushion
          lens(BrownConrady{-0.2, 0.1, 0, 0, 0}),
          lens(Equidistant{}),
          lens(Equidistant{-0.02, 0.004, -0.001, 0.0002}, 200),
          lens(Equidistant{0.05, -0.01, 0.003, -0.0004}, 160)};
}

TEST(Lens, ADirectionProjectsToItsPixel) {
  Rng rng(1);
  for (const Intrinsics& camera : lenses()) {
    ASSERT_EQ(lens_fault(camera), "");
    for (int i = 0; i < 300; ++i) {
      const Vec2 px(rng.uniform(-0.5, 639.5), rng.uniform(-0.5, 479.5));
      const std::optional<Vec3> d = camera.direction(px);
      ASSERT_TRUE(d.has_value());
      EXPECT_NEAR(d->norm(), 1, 1e-12);
      EXPECT_LT((camera.project(*d * rng.uniform(0.1, 10)) - px).norm(), kRoundoff_px);
      EXPECT_TRUE(camera.sees(*d));
      if (d->z() > 0) {
        EXPECT_LT((camera.project(camera.ray(px)) - px).norm(), kRoundoff_px);
      }
    }
  }
}

TEST(Lens, AVisiblePointsPixelPointsAtIt) {
  Rng rng(2);
  for (const Intrinsics& camera : lenses()) {
    int seen = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 d = Vec3(rng.normal(), rng.normal(), rng.normal() + 1).normalized();
      if (camera.sees(d)) {
        ++seen;
        constexpr double kRoundoff = 1e-9;
        EXPECT_LT((camera.direction(camera.project(d)).value() - d).norm(), kRoundoff);
      }
    }
    EXPECT_GT(seen, 100);
  }
}

TEST(Lens, BrownConradyIsOpenCVs) {
  const BrownConrady d{-0.28, 0.09, 0.0012, -0.0007, -0.012};
  const Intrinsics camera = lens(d);
  const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(rng.uniform(-0.8, 0.8), rng.uniform(-0.6, 0.6), 1);
    std::vector<cv::Point2d> px;
    cv::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, cv::Vec3d(), cv::Vec3d(), K,
                      std::vector<double>{d.k1, d.k2, d.p1, d.p2, d.k3}, px);
    EXPECT_LT((camera.project(p) - Vec2(px[0].x, px[0].y)).norm(), kRoundoff_px);
  }
}

TEST(Lens, EquidistantIsOpenCVs) {
  const Equidistant d{-0.02, 0.004, -0.001, 0.0002};
  const Intrinsics camera = lens(d, 200);
  const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(rng.uniform(-2, 2), rng.uniform(-2, 2), 1);
    std::vector<cv::Point2d> px;
    cv::fisheye::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, px, cv::Vec3d(),
                               cv::Vec3d(), K, std::vector<double>{d.k1, d.k2, d.k3, d.k4});
    EXPECT_LT((camera.project(p) - Vec2(px[0].x, px[0].y)).norm(), kRoundoff_px);
  }
}

TEST(Lens, AFisheyeSeesBesideAndBehindItself) {
  const Intrinsics camera = lens_of_view(640, 640, deg_to_rad(220), Equidistant{});
  const Vec3 left = camera.direction({-0.5, 319.5}).value();
  EXPECT_NEAR(left.x(), -std::cos(deg_to_rad(20)), 1e-12);
  EXPECT_NEAR(left.z(), -std::sin(deg_to_rad(20)), 1e-12);
  EXPECT_FALSE(camera.sees(-Vec3::UnitZ()));
}

TEST(Lens, WhatLiesBeyondTheBendHasNoDirection) {
  // r (1 + k1 r^2) turns at r = 1 / sqrt(-3 k1) and reaches 2/3 of it.
  const double k1 = -0.3;
  const double turn = 1 / std::sqrt(-3 * k1);
  const Intrinsics camera{640, 480, 300, 300, 319.5, 239.5, BrownConrady{k1, 0, 0, 0, 0}};
  constexpr double kNear_px = 1e-3;
  const double edge_px = 300 * turn * 2 / 3;
  EXPECT_TRUE(camera.direction({319.5 + edge_px - kNear_px, 239.5}).has_value());
  EXPECT_FALSE(camera.direction({319.5 + edge_px + kNear_px, 239.5}).has_value());
  EXPECT_TRUE(camera.sees({0.9 * turn, 0, 1}));
  EXPECT_FALSE(camera.sees({1.1 * turn, 0, 1}));  // though the polynomial draws it in the picture
  EXPECT_NE(lens_fault(camera), "");
  // Another root of the same value lies beyond the bend: the near one is meant.
  const Vec3 d = camera.direction({319.5 + 0.9 * edge_px, 239.5}).value();
  EXPECT_LT(d.x() / d.z(), turn);
}

TEST(Lens, AnEquidistantOneMayBendBackToo) {
  // theta (1 + k1 theta^2) turns at 1 / sqrt(-3 k1) = 1.054 rad and reaches 0.7027.
  const Intrinsics camera{640, 480, 400, 400, 319.5, 239.5, Equidistant{-0.3, 0, 0, 0}};
  EXPECT_TRUE(camera.direction({319.5 + 400 * 0.70, 239.5}).has_value());
  EXPECT_FALSE(camera.direction({319.5 + 400 * 0.71, 239.5}).has_value());
  EXPECT_EQ(lens_fault(camera),
            "bends back inside the picture: what is more than 60.4 degrees off the axis is drawn "
            "nearer to the middle again, and the corners show nothing; narrow the field of view or "
            "correct the coefficients");
}

TEST(Lens, AFieldOfViewIsTheLenss) {
  for (const Distortion& d :
       std::vector<Distortion>{NoDistortion{}, BrownConrady{-0.2, 0.05, 0, 0, 0}, Equidistant{}}) {
    const Intrinsics camera = lens_of_view(640, 480, deg_to_rad(90), d);
    const Vec3 right = camera.direction({639.5, 239.5}).value();
    EXPECT_NEAR(std::atan2(right.x(), right.z()), kPi / 4, 1e-12);
  }
}

}  // namespace
}  // namespace panoptes
