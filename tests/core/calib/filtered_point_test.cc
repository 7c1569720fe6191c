// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/filtered_point.h"

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr double kStep = 1e-6;
constexpr double kCurvature = 1e-7;  // of functions of order 1, by differences over such a step
constexpr double kRoundoff_m = 1e-12;

Vec3 random_point(Rng& rng) { return {rng.normal(), rng.normal(), rng.normal()}; }

Pose3 random_pose(Rng& rng) { return {turned_by(random_point(rng)), random_point(rng)}; }

FilteredPoint random_ray(Rng& rng) {
  return seen_point(random_point(rng), random_point(rng), rng.uniform(0.2, 2));
}

TEST(FilteredPoint, LiesWhereItWasSeen) {
  Rng rng(1);
  for (int i = 0; i < 50; ++i) {
    const Vec3 from = random_point(rng);
    const Vec3 to = random_point(rng);
    const FilteredPoint point = seen_point(from, to - from, 1 / (to - from).norm());
    EXPECT_LT((point.p_map() - to).norm(), kRoundoff_m);
  }
}

TEST(FilteredPoint, OfNoDepthHasNoPlace) {
  EXPECT_FALSE(seen_point(Vec3::Zero(), Vec3::UnitZ(), -0.1).p_map().allFinite());
  EXPECT_FALSE(seen_point(Vec3::Zero(), Vec3::UnitZ(), 0).p_map().allFinite());
}

TEST(FilteredPoint, AnglesChangeWithDirectionsAsDifferencesTell) {
  Rng rng(2);
  for (int i = 0; i < 20; ++i) {
    const Vec3 direction = random_point(rng);
    const auto J = angles_by_direction(direction);
    for (int n = 0; n < 3; ++n) {
      const Vec3 step = kStep * Vec3::Unit(n);
      const FilteredPoint more = seen_point(Vec3::Zero(), direction + step, 1);
      const FilteredPoint less = seen_point(Vec3::Zero(), direction - step, 1);
      const Vec2 slope = (more.state.segment<2>(3) - less.state.segment<2>(3)) / (2 * kStep);
      EXPECT_LT((J.col(n) - slope).norm(), kCurvature * (1 + J.norm() * J.norm()));
    }
  }
}

TEST(FilteredPoint, MovesWithItsNumbersAsDifferencesTell) {
  Rng rng(3);
  for (int i = 0; i < 20; ++i) {
    const FilteredPoint ray = random_ray(rng);
    const PointOfRay out = point_of_ray(ray);
    for (int n = 0; n < 6; ++n) {
      FilteredPoint more = ray;
      FilteredPoint less = ray;
      more.state[n] += kStep;
      less.state[n] -= kStep;
      const Vec3 slope = (more.p_map() - less.p_map()) / (2 * kStep);
      EXPECT_LT((out.by_state.col(n) - slope).norm(), kCurvature * (1 + 10 * slope.norm()));
    }
  }
}

TEST(FilteredPoint, IsSeenTheSameByBothForms) {
  Rng rng(4);
  for (int i = 0; i < 20; ++i) {
    const Pose3 T_map_camera = random_pose(rng);
    const FilteredPoint ray = random_ray(rng);
    FilteredPoint point;
    point.state = ray.p_map();
    const Vec3 by_ray = seen_from(T_map_camera, ray).p_camera.normalized();
    const Vec3 by_point = seen_from(T_map_camera, point).p_camera.normalized();
    EXPECT_LT((by_ray - by_point).norm(), kRoundoff_m);
    EXPECT_LT((by_point - (T_map_camera.inverse() * ray.p_map()).normalized()).norm(), kRoundoff_m);
  }
}

TEST(FilteredPoint, IsSeenElsewhereAsDifferencesTell) {
  Rng rng(5);
  for (int i = 0; i < 40; ++i) {
    const Pose3 T = random_pose(rng);
    FilteredPoint point = random_ray(rng);
    if (i % 2 == 0) {
      point.state = Vec3(point.p_map());
    }
    const PointSeen seen = seen_from(T, point);
    const auto slope_of = [&](const auto& at) {
      return Vec3((at(kStep) - at(-kStep)) / (2 * kStep));
    };
    for (int n = 0; n < 3; ++n) {
      const Vec3 by_shift = slope_of([&](double step) {
        return seen_from({T.rotation, T.translation + step * Vec3::Unit(n)}, point).p_camera;
      });
      EXPECT_LT((seen.by_camera.col(n) - by_shift).norm(), kCurvature);
      const Vec3 by_turn = slope_of([&](double step) {
        return seen_from({T.rotation * turned_by(step * Vec3::Unit(n)), T.translation}, point)
            .p_camera;
      });
      EXPECT_LT((seen.by_camera.col(3 + n) - by_turn).norm(), kCurvature);
    }
    for (Eigen::Index n = 0; n < point.state.size(); ++n) {
      const Vec3 by_state = slope_of([&](double step) {
        FilteredPoint moved = point;
        moved.state[n] += step;
        return seen_from(T, moved).p_camera;
      });
      EXPECT_LT((seen.by_state.col(n) - by_state).norm(), kCurvature);
    }
  }
}

}  // namespace
}  // namespace panoptes
