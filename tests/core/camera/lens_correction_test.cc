// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/lens_correction.h"

#include <gtest/gtest.h>

#include "core/camera/rectify.h"

namespace panoptes {
namespace {

constexpr double kRoundoff = 1e-9;

const LensCorrection kOff{0.01, {1.5, -2}};

void expect_near(const LensCorrection& a, const LensCorrection& b, double ratio, double px) {
  EXPECT_NEAR(a.focal_ratio, b.focal_ratio, ratio);
  EXPECT_NEAR(a.centre_px.x(), b.centre_px.x(), px);
  EXPECT_NEAR(a.centre_px.y(), b.centre_px.y(), px);
}

TEST(LensCorrection, OfAPinholeIsWhatItsPicturesShow) {
  const Intrinsics lens = pinhole(320, 240, deg_to_rad(80));
  expect_near(straight_correction(lens, lens, corrected(lens, kOff)), kOff, kRoundoff, kRoundoff);
  expect_near(of_lens(kOff, lens, lens), kOff, kRoundoff, kRoundoff);
}

TEST(LensCorrection, OfALensThatBendsShowsNearlyTheSameAsItsStraightenedPictures) {
  constexpr double kLeft_px = 0.8;  // of shifts of 2.5 px, and a share of 1 % at 160 px
  for (const Distortion& distortion : std::vector<Distortion>{
           BrownConrady{-0.2, 0.03, 0.001, -0.001, 0}, Equidistant{-0.02, 0.002, 0, 0}}) {
    const Intrinsics lens = lens_of_view(320, 240, deg_to_rad(100), distortion);
    const Intrinsics straight = rectified(lens);
    const Intrinsics found = corrected(lens, of_lens(kOff, straight, lens));
    const Intrinsics meant = corrected(straight, kOff);
    for (const Vec2& px : {Vec2(20, 20), Vec2(160, 120), Vec2(300, 60), Vec2(80, 220)}) {
      const Vec2 drawn = found.project(meant.ray(px));
      EXPECT_LT((drawn - lens.project(straight.ray(px))).norm(), kLeft_px) << px.transpose();
    }
  }
}

TEST(LensCorrection, OfALensThatBendsAlittleComesBack) {
  constexpr double kLeft_px = 0.1;
  const Intrinsics lens = lens_of_view(320, 240, deg_to_rad(80), BrownConrady{-0.1, 0, 0, 0, 0});
  const Intrinsics straight = rectified(lens);
  const LensCorrection seen = straight_correction(straight, lens, corrected(lens, kOff));
  expect_near(of_lens(seen, straight, lens), kOff, 1e-3, kLeft_px);
}

TEST(LensCorrection, OfTooFewDirectionsIsNone) {
  const Intrinsics lens = pinhole(320, 240, deg_to_rad(80));
  expect_near(fitted_correction(lens, {{{0, 0, 1}, {100, 100}}}), {}, 0, 0);
}

}  // namespace
}  // namespace panoptes
