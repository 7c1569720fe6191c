// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/lens_parameters.h"

#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace panoptes {
namespace {

constexpr double kRoundoff_px = 1e-9;
constexpr double kStep = 1e-6;
constexpr double kCurvature = 1e-5;  // of central differences with such a step, relative

std::vector<Intrinsics> lenses() {
  const auto lens = [](const Distortion& distortion, double f_px) {
    return Intrinsics{640, 480, f_px, 1.01 * f_px, 322.3, 236.8, distortion};
  };
  return {lens(NoDistortion{}, 400), lens(BrownConrady{-0.28, 0.09, 0.0012, -0.0007, -0.012}, 400),
          lens(Equidistant{}, 200), lens(Equidistant{-0.02, 0.004, -0.001, 0.0002}, 200)};
}

Vec3 some_point(const Intrinsics& lens, Rng& rng) {
  if (std::holds_alternative<Equidistant>(lens.distortion)) {
    return {rng.normal(), rng.normal(), rng.normal()};  // beside and behind it as well
  }
  const double z = rng.uniform(0.3, 3);
  return {z * rng.uniform(-0.8, 0.8), z * rng.uniform(-0.6, 0.6), z};
}

TEST(LensParameters, GoThereAndBack) {
  for (const Intrinsics& lens : lenses()) {
    const Eigen::VectorXd numbers = lens_parameters(lens);
    EXPECT_EQ(lens_parameter_names(lens).size(), static_cast<std::size_t>(numbers.size()));
    Intrinsics other = lens;
    other.fx_px = 1;
    other.cy_px = 2;
    const Intrinsics again = with_parameters(other, numbers);
    EXPECT_EQ(again.distortion, lens.distortion);
    EXPECT_EQ(lens_parameters(again), numbers);
  }
  EXPECT_THAT(
      lens_parameter_names(lenses()[1]),
      testing::ElementsAre("fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k3"));
}

TEST(LensParameters, TheProjectionIsTheLens) {
  Rng rng(1);
  for (const Intrinsics& lens : lenses()) {
    for (int i = 0; i < 200; ++i) {
      const Vec3 p = some_point(lens, rng);
      EXPECT_LT((project_with_jacobian(lens, p).px - lens.project(p)).norm(), kRoundoff_px);
    }
  }
}

TEST(LensParameters, JacobiansAreDifferences) {
  Rng rng(2);
  for (const Intrinsics& lens : lenses()) {
    for (int i = 0; i < 100; ++i) {
      const Vec3 p = some_point(lens, rng);
      const Projection drawn = project_with_jacobian(lens, p);
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 step = kStep * Vec3::Unit(axis);
        const Vec2 difference = (lens.project(p + step) - lens.project(p - step)) / (2 * kStep);
        EXPECT_LT((drawn.px_by_point.col(axis) - difference).norm(),
                  kCurvature * (1 + drawn.px_by_point.norm()));
      }
      const Eigen::VectorXd numbers = lens_parameters(lens);
      for (Eigen::Index n = 0; n < numbers.size(); ++n) {
        const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(numbers.size(), n);
        const Vec2 difference = (with_parameters(lens, numbers + step).project(p) -
                                 with_parameters(lens, numbers - step).project(p)) /
                                (2 * kStep);
        EXPECT_LT((drawn.px_by_lens.col(n) - difference).norm(),
                  kCurvature * (1 + drawn.px_by_lens.col(n).norm()));
      }
    }
  }
}

TEST(LensParameters, OnTheAxisOfAFisheyeTheLimitIsTaken) {
  const Intrinsics lens = lenses()[3];
  const Projection on_axis = project_with_jacobian(lens, {0, 0, 2});
  const Projection beside = project_with_jacobian(lens, {1e-7, 1e-7, 2});
  constexpr double kBeside = 1e-4;
  EXPECT_LT((on_axis.px_by_point - beside.px_by_point).norm(), kBeside);
  EXPECT_LT((on_axis.px_by_lens - beside.px_by_lens).norm(), kBeside);
}

}  // namespace
}  // namespace panoptes
