// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/start_bundle.h"

#include <algorithm>
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
          view.seen_px[number] += Vec2(rng.uniform(-25, 25), rng.uniform(-25, 25));
        }
      }
    }
    out.views.push_back(view);
  }
  return out;
}

/// How far the depths are off, as a share, the scale taken out: the median.
double depths_off(const Started& s, const StartDepths& found) {
  double both = 0;
  double own = 0;
  for (const auto& [number, per_m] : found.inverse_depth_per_m) {
    both += per_m * s.inverse_depth_per_m.at(number);
    own += per_m * per_m;
  }
  std::vector<double> off;
  for (const auto& [number, per_m] : found.inverse_depth_per_m) {
    off.push_back(std::abs(both / own * per_m / s.inverse_depth_per_m.at(number) - 1));
  }
  std::sort(off.begin(), off.end());
  return off[off.size() / 2];
}

TEST(StartBundle, FindsDepthsWithoutAGuess) {
  // 8 cm to the right, which a turn hides but for a few pixels
  const Started s = started(0.08, -0.03, 0, Rng(1));
  const auto found = start_depths({}, kLens, s.first_px, s.views);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->inverse_depth_per_m.size(), 24U);
  EXPECT_LT(depths_off(s, *found), 0.05);
  EXPECT_LT(found->known_ratio, 0.05);
  EXPECT_GT(found->parallax_px, 2);
}

TEST(StartBundle, KnowsHowWellItKnows) {
  double squares = 0;
  double known = 0;
  constexpr int kStarts = 30;
  for (int i = 0; i < kStarts; ++i) {
    const Started s = started(0.06, 0.01, 0, Rng(100 + i));
    const auto found = start_depths({}, kLens, s.first_px, s.views);
    ASSERT_TRUE(found);
    const double off = depths_off(s, *found) / 0.6745;  // of the median to one sigma
    squares += off * off / kStarts;
    known += found->known_ratio * found->known_ratio / kStarts;
  }
  EXPECT_GT(squares / known, 0.3);
  EXPECT_LT(squares / known, 3);
}

TEST(StartBundle, FalseMatchesPullHardlyAtAll) {
  for (const double shift_m : {0.03, 0.15}) {
    const Started s = started(shift_m, 0.05, 0.12, Rng(2));
    const auto found = start_depths({}, kLens, s.first_px, s.views);
    ASSERT_TRUE(found);
    EXPECT_LT(depths_off(s, *found), 0.1);
  }
}

TEST(StartBundle, ATurnAloneTellsNothingOfDepths) {
  const Started s = started(0, 0.1, 0, Rng(3));
  const auto found = start_depths({}, kLens, s.first_px, s.views);
  ASSERT_TRUE(found);
  EXPECT_LT(found->parallax_px, 3 * kNoise_px);
}

TEST(StartBundle, TheMeanIsTheMapsMetre) {
  const Started s = started(0.1, 0, 0, Rng(4));
  StartBundleOptions options;
  options.inverse_depth_per_m = 0.4;
  const auto found = start_depths(options, kLens, s.first_px, s.views);
  ASSERT_TRUE(found);
  double sum = 0;
  for (const auto& [number, per_m] : found->inverse_depth_per_m) {
    sum += per_m;
  }
  EXPECT_NEAR(sum / static_cast<double>(found->inverse_depth_per_m.size()), 0.4, 1e-3);
}

TEST(StartBundle, OfNothingIsNothing) { EXPECT_FALSE(start_depths({}, kLens, {}, {})); }

}  // namespace
}  // namespace panoptes
