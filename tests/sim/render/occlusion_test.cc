// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/occlusion.h"

#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "sim/render/clip.h"

namespace panoptes::sim {
namespace {

constexpr double kNear_m = 0.05;

View looking_along_x() {
  return {pinhole(84, 61, deg_to_rad(75)), mounted_camera({0, 0, 0}, 0, 0)};
}

Occlusion started(const View& view) {
  Occlusion occlusion;
  occlusion.start(clip_from_scene(view, kNear_m), view.intrinsics.width_px,
                  view.intrinsics.height_px, static_cast<float>(kNear_m));
  return occlusion;
}

/// Across the view at `x_m`, its middle at (y, z).
SpaceRectangle screen(float x_m, float width_m, float height_m, float y_m = 0, float z_m = 0) {
  return {{x_m, y_m - width_m / 2, z_m - height_m / 2}, {0, width_m, 0}, {0, 0, height_m}};
}

/// How far along the axis the ray of a pixel meets it.
std::optional<double> distance_m(const SpaceRectangle& r, const View& view, int column, int row) {
  const Vec3 ray = view.T_scene_camera.rotation * view.intrinsics.ray(Vec2(column, row));
  const Vec3 u = r.side_u.cast<double>();
  const Vec3 v = r.side_v.cast<double>();
  const Vec3 normal = u.cross(v);
  const double along = normal.dot(ray);
  if (along == 0) {
    return std::nullopt;
  }
  const double distance = normal.dot(r.corner.cast<double>()) / along;
  const Vec3 from_corner = distance * ray - r.corner.cast<double>();
  const double a = from_corner.dot(u) / u.squaredNorm();
  const double b = from_corner.dot(v) / v.squaredNorm();
  if (distance < kNear_m || a < 0 || a > 1 || b < 0 || b > 1) {
    return std::nullopt;
  }
  return distance;
}

TEST(Occlusion, AScreenHidesWhatIsBehindItAndNothingElse) {
  Occlusion occlusion = started(looking_along_x());
  EXPECT_FALSE(occlusion.hides(screen(1, 0.8F, 0.8F)));
  occlusion.add();
  EXPECT_TRUE(occlusion.hides(screen(2, 0.8F, 0.8F)));                   // behind
  EXPECT_FALSE(occlusion.hides(screen(0.9F, 0.2F, 0.2F)));               // before
  EXPECT_FALSE(occlusion.hides(screen(2, 0.8F, 0.8F, 1.2F)));            // beside
  EXPECT_FALSE(occlusion.hides(screen(2, 4, 0.2F)));                     // sticks out
  EXPECT_FALSE(occlusion.hides({{-1, 0, 0}, {3, 0, 0}, {0, 0, 0.1F}}));  // from behind the camera
}

TEST(Occlusion, ForgetsWithEachPicture) {
  const View view = looking_along_x();
  Occlusion occlusion = started(view);
  occlusion.hides(screen(1, 0.8F, 0.8F));
  occlusion.add();
  occlusion.start(clip_from_scene(view, kNear_m), view.intrinsics.width_px,
                  view.intrinsics.height_px, static_cast<float>(kNear_m));
  EXPECT_FALSE(occlusion.hides(screen(2, 0.2F, 0.2F)));
}

TEST(Occlusion, NeverHidesWhatAPixelShows) {
  const View view = looking_along_x();
  Rng rng(3);
  const auto draw = [&rng](double low, double high) {
    return static_cast<float>(low + (high - low) * rng.uniform());
  };
  int hidden = 0;
  for (int scene = 0; scene < 120; ++scene) {
    Occlusion occlusion = started(view);
    std::vector<SpaceRectangle> added;
    for (int i = 0; i < 60; ++i) {
      SpaceRectangle r;
      const Eigen::Vector3f side(draw(-1, 1), draw(-1, 1), draw(-1, 1));
      r.corner = {draw(-0.2, 0.6 + 0.1 * i), draw(-2, 2), draw(-2, 2)};
      r.side_u = side.normalized() * draw(0.1, 3);
      r.side_v = side.cross(Eigen::Vector3f(draw(-1, 1), draw(-1, 1), draw(-1, 1))).normalized() *
                 draw(0.1, 3);
      if (occlusion.hides(r)) {
        ++hidden;
        for (int row = 0; row < view.intrinsics.height_px; ++row) {
          for (int column = 0; column < view.intrinsics.width_px; ++column) {
            const auto mine = distance_m(r, view, column, row);
            bool covered = !mine;
            for (std::size_t k = 0; k < added.size() && !covered; ++k) {
              const auto other = distance_m(added[k], view, column, row);
              covered = other && *other < *mine;
            }
            ASSERT_TRUE(covered) << "scene " << scene << ", rectangle " << i << ", pixel " << column
                                 << ", " << row;
          }
        }
      } else if (rng.uniform() < 0.8) {
        occlusion.add();
        added.push_back(r);
      }
    }
  }
  EXPECT_GT(hidden, 200);  // else nothing was tried
}

}  // namespace
}  // namespace panoptes::sim
