// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/start_bundle.h"

#include <cmath>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

const Intrinsics kLens = lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.03, 0, 0, 0});
constexpr double kNoise_px = 0.15;

struct Started {
  std::map<int, Vec2> first_px;
  std::map<int, double> inverse_depth_per_m;  ///< true
  std::vector<StartView> views;
};

/// 24 points 1 to 4 m before a camera that goes to the right and turns, as far at the end.
Started started(double shift_m, double turn_rad, double false_share, Rng rng) {
  Started out;
  std::map<int, Vec3> points;
  for (int number = 0; number < 24; ++number) {
    const Vec2 px(60 + 104 * (number % 6), 60 + 120 * static_cast<double>(number / 6));
    const double far_m = rng.uniform(1, 4);
    out.first_px[number] = px;
    out.inverse_depth_per_m[number] = 1 / far_m;
    points[number] = far_m * kLens.direction(px).value();
  }
  constexpr int kViews = 8;
  for (int i = 1; i <= kViews; ++i) {
    const double share = static_cast<double>(i) / kViews;
    const Pose3 T_first_camera{turned_by(Vec3(0, share * turn_rad, 0)),
                               Vec3(share * shift_m, 0, 0)};
    StartView view;
    for (const auto& [number, p] : points) {
      const Vec3 p_camera = T_first_camera.inverse() * p;
      if (kLens.sees(p_camera)) {
        view.seen_px[number] =
            kLens.project(p_camera) + kNoise_px * Vec2(rng.normal(), rng.normal());
        if (rng.uniform() < false_share) {
          view.seen_px[number] += Vec2(6, -4);
        }
      }
    }
    out.views.push_back(view);
  }
  return out;
}

/// How far the depths are off, as a share, the scale taken out: the median.
double depths_off(const Started& s, const std::map<int, double>& found) {
  double both = 0;
  double own = 0;
  for (const auto& [number, per_m] : found) {
    both += per_m * s.inverse_depth_per_m.at(number);
    own += per_m * per_m;
  }
  std::vector<double> off;
  for (const auto& [number, per_m] : found) {
    off.push_back(std::abs(both / own * per_m / s.inverse_depth_per_m.at(number) - 1));
  }
  std::sort(off.begin(), off.end());
  return off[off.size() / 2];
}

TEST(StartBundle, FindsDepthsWithoutAGuess) {
  // 8 cm to the right, which a turn hides but for a few pixels
  const Started s = started(0.08, -0.03, 0, Rng(1));
  const auto found = start_inverse_depths({}, kLens, s.first_px, s.views);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->size(), 24U);
  EXPECT_LT(depths_off(s, *found), 0.05);
}

TEST(StartBundle, FalseMatchesPullNoMoreThanTheirShare) {
  const Started s = started(0.15, 0.05, 0.1, Rng(2));
  const auto found = start_inverse_depths({}, kLens, s.first_px, s.views);
  ASSERT_TRUE(found);
  EXPECT_LT(depths_off(s, *found), 0.08);
}

TEST(StartBundle, ATurnAloneTellsNothingOfDepths) {
  const Started s = started(0, 0.1, 0, Rng(3));
  const StartBundleOptions options;
  const auto found = start_inverse_depths(options, kLens, s.first_px, s.views);
  ASSERT_TRUE(found);
  for (const auto& [number, per_m] : *found) {
    EXPECT_NEAR(per_m, options.inverse_depth_per_m, 2 * options.inverse_depth_sigma);
  }
}

TEST(StartBundle, TheMeanIsTheMapsMetre) {
  const Started s = started(0.1, 0, 0, Rng(4));
  StartBundleOptions options;
  options.inverse_depth_per_m = 0.4;
  const auto found = start_inverse_depths(options, kLens, s.first_px, s.views);
  ASSERT_TRUE(found);
  double sum = 0;
  for (const auto& [number, per_m] : *found) {
    sum += per_m;
  }
  EXPECT_NEAR(sum / static_cast<double>(found->size()), 0.4, 1e-9);
}

TEST(StartBundle, OfNothingIsNothing) { EXPECT_FALSE(start_inverse_depths({}, kLens, {}, {})); }

}  // namespace
}  // namespace panoptes
