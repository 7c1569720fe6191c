// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/hull_shadow.h"

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/eval/rig_sight.h"

namespace panoptes {
namespace {

Vec3 drawn(Rng& rng, double reach_m) {
  return {rng.uniform(-reach_m, reach_m), rng.uniform(-reach_m, reach_m),
          rng.uniform(-reach_m, reach_m)};
}

/// How far along the line from eye to p a face is met, as a share; infinite where it is not.
/// `margin` widens the face, or with a negative sign narrows it, by a share of its size.
double meets(const Face& face, const Vec3& eye, const Vec3& p, double margin) {
  Mat3 A;
  A << face[1] - face[0], face[2] - face[0], eye - p;
  const Vec3 x = A.inverse() * (eye - face[0]);
  const bool inside = x[0] >= -margin && x[1] >= -margin && x[0] + x[1] <= 1 + margin;
  return inside && x[2] > 0 ? x[2] : std::numeric_limits<double>::infinity();
}

TEST(HullShadow, IsWhatALineThroughAFaceIs) {
  Rng rng(5);
  constexpr double kCell = 0.03;  // of a face's size, more than a cell of the shadow is wide
  int hidden = 0;
  int told = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 eye = drawn(rng, 1);
    const std::vector<Face> faces = {{drawn(rng, 2), drawn(rng, 2), drawn(rng, 2)}};
    const HullShadow shadow(faces, eye);
    for (int k = 0; k < 20; ++k) {
      const Vec3 p = drawn(rng, 4);
      const double wide = meets(faces[0], eye, p, kCell);
      const double narrow = meets(faces[0], eye, p, -kCell);
      const bool near_the_end = std::abs(wide - 1) < 0.05 || wide * (p - eye).norm() < 0.2;
      if (std::isfinite(wide) != std::isfinite(narrow) || near_the_end) {
        continue;  // grazed
      }
      ++told;
      hidden += narrow < 1 ? 1 : 0;
      EXPECT_EQ(shadow.hides(p), narrow < 1)
          << i << " eye " << eye.transpose() << " p " << p.transpose();
    }
  }
  EXPECT_GT(hidden, 100);
  EXPECT_GT(told, 5000);
}

/// The outside of a cylinder about the middle of the body, standing on the floor.
std::vector<Face> cylinder(double radius_m, double height_m) {
  constexpr int kSides = 180;
  std::vector<Face> faces;
  for (int k = 0; k < kSides; ++k) {
    const auto at = [&](int side, double r, double z) {
      const double angle = 2 * std::numbers::pi * side / kSides;
      return Vec3(r * std::cos(angle), r * std::sin(angle), z);
    };
    faces.push_back({at(k, radius_m, 0), at(k + 1, radius_m, 0), at(k + 1, radius_m, height_m)});
    faces.push_back({at(k, radius_m, 0), at(k + 1, radius_m, height_m), at(k, radius_m, height_m)});
    faces.push_back({at(k, radius_m, height_m), at(k + 1, radius_m, height_m), {0, 0, height_m}});
  }
  return faces;
}

TEST(HullShadow, OfACylinderIsThatOfTheHull) {
  const Body body;
  Body thin = body;
  thin.radius_m -= 0.01;
  thin.hull_height_m -= 0.01;
  Body thick = body;
  thick.radius_m += 0.01;
  thick.hull_height_m += 0.01;
  const std::vector<Face> faces = cylinder(body.radius_m, body.hull_height_m);
  Rng rng(7);
  int hidden = 0;
  for (int i = 0; i < 60; ++i) {
    const Vec3 eye(rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(0.3, 0.9));
    const HullShadow shadow(faces, eye);
    for (int k = 0; k < 200; ++k) {
      const Vec3 p(rng.uniform(-0.7, 0.7), rng.uniform(-0.7, 0.7), rng.uniform(0, 0.1));
      if (hidden_by_hull(thin, eye, p) == hidden_by_hull(thick, eye, p) &&
          p.head<2>().norm() > thick.radius_m) {
        EXPECT_EQ(shadow.hides(p), hidden_by_hull(body, eye, p))
            << "eye " << eye.transpose() << " p " << p.transpose();
        hidden += shadow.hides(p) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(hidden, 300);
}

TEST(InsideHull, IsWhereTheFacesAreAllAround) {
  std::vector<Face> faces = cylinder(0.25, 0.24);  // open below
  EXPECT_TRUE(inside_hull(faces, {0.1, 0.05, 0.1}));
  EXPECT_FALSE(inside_hull(faces, {0.1, 0.05, 0.3}));
  EXPECT_FALSE(inside_hull(faces, {0.4, 0, 0.1}));
  for (const Face& face : cylinder(0.02, 0.04)) {  // a housing
    const Vec3 at(0.4, 0, 0.28);
    faces.push_back({face[0] + at, face[1] + at, face[2] + at});
  }
  EXPECT_FALSE(inside_hull(faces, {0.4, 0, 0.3}));
}

TEST(HullShadow, ACamerasOwnHousingHidesNothing) {
  const Vec3 eye(0, 0, 0.5);
  const auto plate = [&](double before_m) {
    const double x = eye.x() + before_m;
    return Face{Vec3(x, -1, 0), Vec3(x, 1, 0), Vec3(x, 0, 2)};
  };
  EXPECT_FALSE(HullShadow({plate(0.02)}, eye).hides({1, 0, 0.5}));
  EXPECT_TRUE(HullShadow({plate(0.04)}, eye).hides({1, 0, 0.5}));
  EXPECT_FALSE(HullShadow({plate(0.04)}, eye).hides({-1, 0, 0.5}));
  EXPECT_FALSE(HullShadow({}, eye).hides({1, 0, 0.5}));
}

TEST(CameraSight, LooksPastTheFacesOfItsRobotWhereThereAreAny) {
  Body body;
  // A panel across, ahead of a camera on the mast, from 0.3 m up to 0.4.
  body.faces = std::make_shared<const std::vector<Face>>(
      std::vector<Face>{{Vec3(0.2, -0.3, 0.3), Vec3(0.2, 0.3, 0.3), Vec3(0.2, 0.3, 0.4)},
                        {Vec3(0.2, -0.3, 0.3), Vec3(0.2, 0.3, 0.4), Vec3(0.2, -0.3, 0.4)}});
  RigCamera camera;
  camera.intrinsics = pinhole(320, 240, deg_to_rad(100));
  camera.T_body_camera = mounted_camera({0, 0, 0.8}, 0, deg_to_rad(50));
  const CameraSight sight(camera, body);
  // Below its lower edge, 0.5 m down in 0.2, behind it, and over its upper edge, 0.4 down in 0.2.
  EXPECT_TRUE(sight.sees({0.30, 0, 0}));
  EXPECT_FALSE(sight.sees({0.36, 0, 0}));
  EXPECT_TRUE(sight.sees({0.42, 0, 0}));
  EXPECT_GT(sight.hull_share(), 0.02);
}

}  // namespace
}  // namespace panoptes
