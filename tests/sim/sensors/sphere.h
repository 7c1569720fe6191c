// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include <opencv2/core.hpp>

#include "sim/render/renderer.h"

namespace panoptes::sim {

inline constexpr double kSphere_m = 3;

/// The inside of a sphere about the origin of the scene, drawn exactly: what light (1 is white) of
/// each colour comes from where.
using Light = std::function<Vec3(const Vec3& d_scene)>;

inline RenderedImage draw_sphere(const Light& light, const View& view,
                                 const RenderOutputs& outputs) {
  if (view.faces != nullptr) {
    return draw_faces(view, outputs, [&light](const View& pinhole, const RenderOutputs& of_face) {
      return draw_sphere(light, pinhole, of_face);
    });
  }
  const Intrinsics& k = view.intrinsics;
  RenderedImage out;
  out.bgr.create(k.height_px, k.width_px, CV_8UC3);
  if (outputs.floor_label) {
    out.floor_label.create(k.height_px, k.width_px, CV_8UC1);
  }
  if (outputs.depth) {
    out.depth_m.create(k.height_px, k.width_px, CV_32FC1);
  }
  if (outputs.instance) {
    out.instance.create(k.height_px, k.width_px, CV_16UC1);
  }
  const Vec3& eye = view.T_scene_camera.translation;
  for (int v = 0; v < k.height_px; ++v) {
    for (int u = 0; u < k.width_px; ++u) {
      const Vec3 ray_camera = k.ray(Vec2(u, v));
      const Vec3 ray_scene = view.T_scene_camera.rotation * ray_camera;
      const double half_b = eye.dot(ray_scene) / ray_scene.squaredNorm();
      const double c = (eye.squaredNorm() - kSphere_m * kSphere_m) / ray_scene.squaredNorm();
      const double z_m = -half_b + std::sqrt(half_b * half_b - c);
      const Vec3 d_scene = (eye + ray_scene * z_m) / kSphere_m;
      const Vec3 grey = (light(d_scene) * view.gain).cwiseMax(0).cwiseSqrt() * 255;
      for (int i = 0; i < 3; ++i) {
        out.bgr.at<cv::Vec3b>(v, u)[i] = cv::saturate_cast<std::uint8_t>(grey[i]);
      }
      if (outputs.floor_label) {
        out.floor_label.at<std::uint8_t>(v, u) = d_scene.z() < 0 ? 255 : 0;
      }
      if (outputs.depth) {
        out.depth_m.at<float>(v, u) = static_cast<float>(z_m);
      }
      if (outputs.instance) {
        out.instance.at<std::uint16_t>(v, u) =
            static_cast<std::uint16_t>(1 + (d_scene.x() < 0) + 2 * (d_scene.y() < 0));
      }
    }
  }
  return out;
}

}  // namespace panoptes::sim
