// SPDX-License-Identifier: BSD-3-Clause
#include "tests/core/map/floor_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace panoptes {
namespace {

double lattice(std::int64_t x, std::int64_t y, int seed) {
  auto h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL ^
           static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fULL ^
           static_cast<std::uint64_t>(seed) * 0x165667b19e3779f9ULL;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
  h ^= h >> 31;
  return static_cast<double>(h >> 11) * 0x1p-53 * 2 - 1;
}

double value_noise(double x, double y, int seed) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto ix = static_cast<std::int64_t>(fx);
  const auto iy = static_cast<std::int64_t>(fy);
  const double u = x - fx;
  const double v = y - fy;
  return (1 - v) * ((1 - u) * lattice(ix, iy, seed) + u * lattice(ix + 1, iy, seed)) +
         v * ((1 - u) * lattice(ix, iy + 1, seed) + u * lattice(ix + 1, iy + 1, seed));
}

Vec3 shade(const Surface& s, double x_m, double y_m, double footprint_m) {
  double n = 0;
  int seed = s.pattern * 16;
  for (const double wave_m : {0.01, 0.03, 0.08}) {
    // what is finer than a pixel averages out
    n += value_noise(x_m / wave_m, y_m / wave_m, seed++) * std::min(1.0, wave_m / footprint_m);
  }
  return s.bgr * (1 + s.contrast * n);
}

}  // namespace

RigCamera office_floor_camera() {
  RigCamera camera;
  camera.roles = {"floor"};
  camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
  camera.T_body_camera = mounted_camera(Vec3(0.01, 0, 0.75), 0, deg_to_rad(28));
  camera.floor = FloorView{};
  return camera;
}

cv::Mat draw(const FloorScene& scene, const RigCamera& camera, const Pose2& T_scene_body,
             Rng& rng) {
  const Intrinsics& k = camera.intrinsics;
  const Pose3 T_scene_camera = on_floor(T_scene_body) * camera.T_body_camera;
  const Vec3 c = T_scene_camera.translation;
  cv::Mat picture(k.height_px, k.width_px, CV_8UC3);
  for (int v = 0; v < k.height_px; ++v) {
    auto* out = picture.ptr<std::uint8_t>(v);
    for (int u = 0; u < k.width_px; ++u, out += 3) {
      const Vec3 ray = T_scene_camera.rotation * k.ray(Vec2(u, v));
      double best = ray.z() < 0 ? -c.z() / ray.z() : std::numeric_limits<double>::infinity();
      Vec3 bgr(150, 160, 165);  // a wall far away
      if (std::isfinite(best)) {
        const Vec2 p = (c + best * ray).head<2>();
        const double footprint_m = best / k.fx_px * std::sqrt(ray.norm() / -ray.z());
        bgr = shade(p.x() > scene.seam_x_m ? scene.second_carpet : scene.carpet, p.x(), p.y(),
                    footprint_m);
        for (const SceneBox& box : scene.boxes) {
          const Vec2 out_of = (box.low - p).cwiseMax(p - box.high).cwiseMax(0);
          bgr *= 1 - scene.contact_shade * std::max(0.0, 1 - out_of.norm() / 0.06);
        }
      }
      for (const SceneBox& box : scene.boxes) {
        const Vec3 low(box.low.x(), box.low.y(), 0);
        const Vec3 high(box.high.x(), box.high.y(), box.height_m);
        double enter = 0;
        double leave = best;
        int side = 2;
        for (int a = 0; a < 3; ++a) {
          const double t0 = (low(a) - c(a)) / ray(a);
          const double t1 = (high(a) - c(a)) / ray(a);
          if (std::min(t0, t1) > enter) {
            enter = std::min(t0, t1);
            side = a;
          }
          leave = std::min(leave, std::max(t0, t1));
        }
        if (enter < leave && enter > 0) {
          best = enter;
          const Vec3 p = c + enter * ray;
          const double light = side == 2 ? 1.1 : side == 1 ? 0.85 : 1.0;
          bgr = light * shade(box.surface, side == 0 ? p.y() : p.x(), side == 2 ? p.y() : p.z(),
                              enter / k.fx_px);
        }
      }
      for (int channel = 0; channel < 3; ++channel) {
        const double value = bgr(channel) + rng.normal(0, scene.noise_grey);
        out[channel] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
      }
    }
  }
  return picture;
}

}  // namespace panoptes
