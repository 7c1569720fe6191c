// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/ray_tracer.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "tests/sim/world/boxes.h"

namespace panoptes::sim {
namespace {

constexpr double kFar_m = 100;
constexpr double kRoundoff_m = 1e-4;  // of floats at 10 m, a thousand ulps for grazing rays

Vec3 random_point(Rng& rng, double half_m) {
  return {rng.uniform(-half_m, half_m), rng.uniform(-half_m, half_m), rng.uniform(-half_m, half_m)};
}

std::vector<RayTracer::Corners> corners_of(const std::vector<Triangle>& triangles) {
  std::vector<RayTracer::Corners> corners;
  for (const Triangle& t : triangles) {
    corners.push_back({t.corners[0].p_object, t.corners[1].p_object, t.corners[2].p_object});
  }
  return corners;
}

/// Against the plane of each triangle, in doubles.
RayTracer::Hit nearest_by_arithmetic(const std::vector<RayTracer::Corners>& triangles,
                                     const Vec3& from, const Vec3& direction) {
  RayTracer::Hit best;
  for (const RayTracer::Corners& t : triangles) {
    const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
    const double distance = normal.dot(t[0] - from) / normal.dot(direction);
    const Vec3 p = from + distance * direction;
    bool inside = distance > 0 && distance < best.distance_m;
    for (std::size_t i = 0; i < 3; ++i) {
      inside = inside && normal.dot((t[(i + 1) % 3] - t[i]).cross(p - t[i])) >= 0;
    }
    if (inside) {
      best = {distance, normal.dot(direction) > 0};
    }
  }
  return best;
}

TEST(RayTracer, FindsWhatArithmeticFinds) {
  Rng rng(5);
  std::vector<RayTracer::Corners> triangles;
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = random_point(rng, 5);
    triangles.push_back({p, p + random_point(rng, 1), p + random_point(rng, 1)});
  }
  const RayTracer tracer(triangles);
  int hits = 0;
  int differ = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 from = random_point(rng, 6);
    const Vec3 direction = random_point(rng, 1).normalized();
    const RayTracer::Hit expected = nearest_by_arithmetic(triangles, from, direction);
    const RayTracer::Hit found = tracer.first_hit(from, direction, 0, kFar_m);
    hits += std::isfinite(expected.distance_m) ? 1 : 0;
    // A ray along an edge may go by on the other side.
    if (std::isfinite(expected.distance_m) == std::isfinite(found.distance_m) &&
        (!std::isfinite(found.distance_m) ||
         std::abs(found.distance_m - expected.distance_m) < kRoundoff_m)) {
      if (std::isfinite(found.distance_m)) {
        EXPECT_EQ(found.back, expected.back);
        EXPECT_TRUE(tracer.blocked(from, direction, 0, found.distance_m + kRoundoff_m));
        EXPECT_FALSE(tracer.blocked(from, direction, 0, found.distance_m - kRoundoff_m));
        EXPECT_FALSE(tracer.blocked(from, direction, found.distance_m + kRoundoff_m,
                                    found.distance_m + 2 * kRoundoff_m));
      }
    } else {
      ++differ;
    }
  }
  EXPECT_GT(hits, 400);
  EXPECT_LE(differ, 2);
}

TEST(RayTracer, NothingSlipsOutOfABoxByItsEdges) {
  const RayTracer tracer(corners_of(box({-1, -2, 0}, {3, 2, 2.5})));
  Rng rng(6);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 from(rng.uniform(-0.9, 2.9), rng.uniform(-1.9, 1.9), rng.uniform(0.1, 2.4));
    // At a point of an edge or a side's diagonal.
    const Vec3 corner_a(rng.uniform(0, 1) < 0.5 ? -1 : 3, rng.uniform(0, 1) < 0.5 ? -2 : 2, 0);
    const Vec3 corner_b(corner_a.x(), rng.uniform(0, 1) < 0.5 ? -2 : 2, 2.5);
    const Vec3 at = corner_a + rng.uniform(0, 1) * (corner_b - corner_a);
    EXPECT_TRUE(tracer.first_hit(from, (at - from).normalized(), 0, kFar_m).back);
  }
}

TEST(RayTracer, AlongTheAxesToo) {
  const RayTracer tracer(corners_of(box({-1, -1, -1}, {1, 1, 1})));
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Vec3 from = Vec3(0.3, 0.2, 0.1);
      from[axis] = -3 * sign;
      Vec3 direction = Vec3::Zero();
      direction[axis] = sign;
      const RayTracer::Hit hit = tracer.first_hit(from, direction, 0, kFar_m);
      EXPECT_NEAR(hit.distance_m, 2, kRoundoff_m);
      EXPECT_FALSE(hit.back);
    }
  }
}

TEST(RayTracer, NoTrianglesHideNothing) {
  const RayTracer tracer({});
  EXPECT_FALSE(tracer.blocked({0, 0, 0}, {1, 0, 0}, 0, kFar_m));
}

TEST(RayTracer, TenThousandTrianglesInOnePlaceAreNoTrouble) {
  std::vector<RayTracer::Corners> triangles(10000, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)});
  const RayTracer tracer(triangles);
  EXPECT_NEAR(tracer.first_hit({0.2, 0.2, 1}, {0, 0, -1}, 0, kFar_m).distance_m, 1, kRoundoff_m);
}

}  // namespace
}  // namespace panoptes::sim
