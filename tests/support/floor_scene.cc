// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/floor_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

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

// Noise between the points of a lattice. Neighbouring pixels mostly lie between the same ones.
class Wave {
 public:
  explicit Wave(int seed) : seed_(seed) {}

  double at(double x, double y) {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    if (fx != fx_ || fy != fy_) {
      const auto ix = static_cast<std::int64_t>(fx);
      const auto iy = static_cast<std::int64_t>(fy);
      corners_ = {lattice(ix, iy, seed_), lattice(ix + 1, iy, seed_), lattice(ix, iy + 1, seed_),
                  lattice(ix + 1, iy + 1, seed_)};
      fx_ = fx;
      fy_ = fy;
    }
    const double u = x - fx;
    const double v = y - fy;
    return (1 - v) * ((1 - u) * corners_[0] + u * corners_[1]) +
           v * ((1 - u) * corners_[2] + u * corners_[3]);
  }

 private:
  int seed_;
  double fx_ = std::numeric_limits<double>::quiet_NaN();
  double fy_ = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 4> corners_{};
};

class Texture {
 public:
  explicit Texture(const Surface& surface)
      : surface_(&surface),
        waves_{Wave(surface.pattern * 16), Wave(surface.pattern * 16 + 1),
               Wave(surface.pattern * 16 + 2)} {}

  Vec3 shade(double x_m, double y_m, double footprint_m) {
    constexpr std::array<double, 3> kWaves_m{0.01, 0.03, 0.08};
    double n = 0;
    for (std::size_t i = 0; i < kWaves_m.size(); ++i) {
      // what is finer than a pixel averages out
      const double share = std::min(1.0, kWaves_m[i] / footprint_m);
      n += waves_[i].at(x_m / kWaves_m[i], y_m / kWaves_m[i]) * share;
    }
    return surface_->bgr * (1 + surface_->contrast * n);
  }

 private:
  const Surface* surface_;
  std::array<Wave, 3> waves_;
};

// Where a ray meets a box first.
struct BoxHit {
  std::size_t box = 0;
  int side = 2;  ///< the axis that its face lies across
};

}  // namespace

RigCamera office_floor_camera() {
  RigCamera camera;
  camera.roles = {"floor"};
  camera.intrinsics = pinhole(320, 240, deg_to_rad(80));
  camera.T_body_camera = mounted_camera(Vec3(0.01, 0, 0.75), 0, deg_to_rad(28));
  camera.floor = FloorView{};
  return camera;
}

Levels same_levels() {
  Levels levels;
  for (auto& channel : levels) {
    for (std::size_t level = 0; level < channel.size(); ++level) {
      channel[level] = static_cast<std::uint8_t>(level);
    }
  }
  return levels;
}

cv::Mat draw(const FloorScene& scene, const RigCamera& camera, const Pose2& T_scene_body,
             Rng& rng) {
  const Intrinsics& k = camera.intrinsics;
  const Pose3 T_scene_camera = on_floor(T_scene_body) * camera.T_body_camera;
  const Mat3 R = T_scene_camera.rotation.toRotationMatrix();
  const Vec3 c = T_scene_camera.translation;
  Texture carpet(scene.carpet);
  Texture second_carpet(scene.second_carpet);
  std::vector<Texture> textures;
  for (const SceneBox& box : scene.boxes) {
    textures.emplace_back(box.surface);
  }
  const std::vector<SceneBox> shading =
      scene.contact_shade > 0 ? scene.boxes : std::vector<SceneBox>();
  cv::Mat picture(k.height_px, k.width_px, CV_8UC3);
  for (int v = 0; v < k.height_px; ++v) {
    auto* out = picture.ptr<std::uint8_t>(v);
    for (int u = 0; u < k.width_px; ++u, out += 3) {
      const Vec3 ray = R * k.ray(Vec2(u, v));
      const double floor = ray.z() < 0 ? -c.z() / ray.z() : std::numeric_limits<double>::infinity();
      double best = floor;
      std::optional<BoxHit> hit;
      for (std::size_t b = 0; b < scene.boxes.size(); ++b) {
        const SceneBox& box = scene.boxes[b];
        const std::array<double, 3> low{box.low.x(), box.low.y(), 0};
        const std::array<double, 3> high{box.high.x(), box.high.y(), box.height_m};
        double enter = 0;
        double leave = best;
        int side = 2;
        for (int a = 0; a < 3 && enter < leave; ++a) {
          const double t0 = (low[a] - c(a)) / ray(a);
          const double t1 = (high[a] - c(a)) / ray(a);
          if (std::min(t0, t1) > enter) {
            enter = std::min(t0, t1);
            side = a;
          }
          leave = std::min(leave, std::max(t0, t1));
        }
        if (enter < leave && enter > 0) {
          best = enter;
          hit = BoxHit{b, side};
        }
      }
      const Vec3 p = c + best * ray;
      Vec3 bgr(150, 160, 165);  // a wall far away
      if (hit) {
        const int side = hit->side;
        const double light = side == 2 ? 1.1 : side == 1 ? 0.85 : 1.0;
        bgr = light * textures[hit->box].shade(side == 0 ? p.y() : p.x(), side == 2 ? p.y() : p.z(),
                                               best / k.fx_px);
      } else if (std::isfinite(floor)) {
        const double footprint_m = best / k.fx_px * std::sqrt(ray.norm() / -ray.z());
        Texture& texture = p.x() > scene.seam_x_m ? second_carpet : carpet;
        bgr = texture.shade(p.x(), p.y(), footprint_m);
        for (const SceneBox& box : shading) {
          const Vec2 on_floor = p.head<2>();
          const Vec2 out_of = (box.low - on_floor).cwiseMax(on_floor - box.high).cwiseMax(0);
          bgr *= 1 - scene.contact_shade * std::max(0.0, 1 - out_of.norm() / 0.06);
        }
      }
      for (int channel = 0; channel < 3; ++channel) {
        const double value = bgr(channel) + rng.normal(0, scene.noise_grey);
        out[channel] = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0) + 0.5);
      }
    }
  }
  return picture;
}

}  // namespace panoptes
