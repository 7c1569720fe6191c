// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/homography.h"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_m = 1e-9;

// A floor seen by a tilted camera: pixels of a 320 x 240 picture to metres.
Mat3 floor_homography() {
  Mat3 H_px_body;
  H_px_body << 143, -191, 119.6, 90, 0, 257.6, 0.883, 0, 0.352;
  return H_px_body.inverse();
}

std::vector<PlanePair> marks(int count, double sigma_px, Rng& rng) {
  std::vector<PlanePair> pairs;
  const Mat3 H_px_body = floor_homography().inverse();
  for (int i = 0; i < count; ++i) {
    const Vec2 p_body(rng.uniform(0.5, 2.5), rng.uniform(-0.8, 0.8));
    const Vec2 px = (H_px_body * p_body.homogeneous()).hnormalized();
    pairs.push_back({px + Vec2(rng.normal(0, sigma_px), rng.normal(0, sigma_px)), p_body});
  }
  return pairs;
}

TEST(Homography, FourMarksDetermineIt) {
  Rng rng(1);
  const std::vector<PlanePair> square{
      {{40, 200}, {0, 0}}, {{280, 205}, {0, 0}}, {{100, 140}, {0, 0}}, {{230, 130}, {0, 0}}};
  std::vector<PlanePair> pairs = square;
  for (PlanePair& pair : pairs) {
    pair.to = *transfer(floor_homography(), pair.from);
  }
  const HomographyFit fit = fit_homography(pairs);
  ASSERT_TRUE(fit.H_to_from) << fit.fault;
  EXPECT_NEAR(fit.rms, 0, kRoundoff_m);
  EXPECT_FALSE(fit.leave_one_out);
  for (int i = 0; i < 50; ++i) {
    const Vec2 px(rng.uniform(0, 320), rng.uniform(130, 240));
    EXPECT_NEAR((*transfer(*fit.H_to_from, px) - *transfer(floor_homography(), px)).norm(), 0,
                1e-7);
  }
}

TEST(Homography, ManyNoisyMarksReportTheirError) {
  Rng rng(2);
  const HomographyFit fit = fit_homography(marks(30, 0.3, rng));
  ASSERT_TRUE(fit.H_to_from);
  ASSERT_TRUE(fit.leave_one_out);
  EXPECT_GT(*fit.leave_one_out, fit.rms);
  EXPECT_LT(*fit.leave_one_out, 0.05);  // 0.3 px are up to 1.5 cm at 2.5 m
}

TEST(Homography, RefusesWhatDoesNotDetermineIt) {
  Rng rng(3);
  const std::vector<PlanePair> four = marks(4, 0, rng);
  EXPECT_FALSE(fit_homography({four[0], four[1], four[2]}).H_to_from);
  EXPECT_FALSE(fit_homography({four[0], four[0], four[0], four[0]}).H_to_from);
  EXPECT_FALSE(fit_homography({four[0], four[1], four[2], four[2]}).H_to_from);
  std::vector<PlanePair> line;
  for (int i = 0; i < 5; ++i) {
    line.push_back({Vec2(100 + 10 * i, 200 - 5 * i), Vec2(0.5 + 0.1 * i, 0.2 * i)});
  }
  const HomographyFit fit = fit_homography(line);
  EXPECT_FALSE(fit.H_to_from);
  EXPECT_NE(fit.fault, "");
  std::vector<PlanePair> infinite = four;
  infinite[0].from.x() = std::nan("");
  EXPECT_FALSE(fit_homography(infinite).H_to_from);
}

TEST(Homography, KnowsItsHorizon) {
  const Mat3 H = floor_homography();
  const double sign = (H * Vec3(160, 230, 1)).z() > 0 ? 1 : -1;
  EXPECT_TRUE(transfer(sign * H, Vec2(160, 230)));
  EXPECT_FALSE(transfer(sign * H, Vec2(160, -200)));
  EXPECT_TRUE(clear_of_horizon(sign * H, Vec2(0, 120), Vec2(319, 239)));
  EXPECT_FALSE(clear_of_horizon(sign * H, Vec2(0, -200), Vec2(319, 239)));
}

}  // namespace
}  // namespace panoptes
