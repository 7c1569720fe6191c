// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/calib/rig_calibration.h"
#include "core/camera/mounting.h"
#include "tests/support/driven_rose.h"

namespace panoptes {

/// What cameras that drive a rose have mapped, without pictures.
struct MappedScene {
  int points = 200;
  double noise_px = 0.1;
  double off = 0.01;       ///< of points and poses in a map, as a share of how far points are
  double false_looks = 0;  ///< the share of a map's points that look as others do
  bool common = true;      ///< maps have points in common
  /// The room is alike on both sides, and each map but the first takes one for the other.
  bool other_side = false;
  double late_s = 0;          ///< by which the pictures of all but the first camera are taken
  std::vector<double> scale;  ///< of each map; 1
};

/// So many cameras that look all about.
inline std::vector<RigCamera> cameras_about(int count) {
  std::vector<RigCamera> rig(static_cast<std::size_t>(count));
  for (int c = 0; c < count; ++c) {
    RigCamera& camera = rig[static_cast<std::size_t>(c)];
    camera.intrinsics = pinhole(640, 480, deg_to_rad(80));
    const double yaw_rad = 2 * std::numbers::pi * c / count;
    camera.T_body_camera = mounted_camera(
        {0.15 * std::cos(yaw_rad), 0.15 * std::sin(yaw_rad), 0.7 + 0.02 * c}, yaw_rad, 0.05 * c);
  }
  return rig;
}

/// What a point looks like: 32 numbers, of length 1.
inline cv::Mat drawn_look(Rng& rng) {
  cv::Mat look(1, 32, CV_32F);
  double square = 0;
  for (int i = 0; i < look.cols; ++i) {
    look.at<float>(i) = static_cast<float>(rng.normal());
    square += std::pow(look.at<float>(i), 2);
  }
  look.convertTo(look, CV_32F, 1 / std::sqrt(square));
  return look;
}

/// The maps of a rig's cameras, each of its own metre and begun where the camera is first.
inline std::vector<MappedCamera> mapped_cameras(const std::vector<RigCamera>& rig,
                                                const MappedScene& scene, Rng rng) {
  constexpr int kEvery = 10;  // frames of which anything is seen
  const DrivenRose rose({}, rng.fork("drive"));
  std::vector<Vec3> points;
  std::vector<cv::Mat> looks;
  for (int i = 0; i < scene.points; ++i) {
    const double angle_rad = rng.uniform(0, 2 * std::numbers::pi);
    const double far_m = rng.uniform(1.5, 3);
    points.emplace_back(far_m * std::cos(angle_rad), far_m * std::sin(angle_rad),
                        rng.uniform(0.2, 1.6));
    if (scene.other_side && 2 * i >= scene.points) {
      const Vec3& across = points[static_cast<std::size_t>(i - scene.points / 2)];
      points.back() = Vec3(-across.x(), -across.y(), across.z());
    }
    looks.push_back(drawn_look(rng));
  }
  std::vector<MappedCamera> cameras;
  for (std::size_t c = 0; c < rig.size(); ++c) {
    const double scale = c < scene.scale.size() ? scene.scale[c] : 1;
    Rng of_map = rng.fork("map " + std::to_string(c));
    const auto drawn = [&of_map] {
      const double x = of_map.normal();
      const double y = of_map.normal();
      return Vec3(x, y, of_map.normal());
    };
    MappedCamera camera{"camera_" + std::to_string(c), rig[c], {}, {}};
    camera.map.lens = rig[c].intrinsics;
    camera.map.start_is_known = true;
    camera.map.closed = rose.instants() / 2;
    std::vector<Pose3> T_start_camera;
    for (std::size_t i = 0; i < rose.instants(); ++i) {
      const Duration late = from_seconds(c > 0 ? scene.late_s : 0);
      T_start_camera.push_back(on_floor(rose.T_start_body(rose.instant(i) + late)) *
                               rig[c].T_body_camera);
      Pose3 T_map_camera = T_start_camera.front().inverse() * T_start_camera.back();
      if (i > 0) {
        T_map_camera.rotation = T_map_camera.rotation * turned_by(scene.off / 5 * drawn());
        T_map_camera.translation += scene.off * drawn();
      }
      T_map_camera.translation *= scale;
      camera.map.frames.push_back({rose.instant(i) + late, T_map_camera, false});
    }
    for (std::size_t p = 0; p < points.size(); ++p) {
      MonoMap::Point point;
      point.number = static_cast<int>(p);
      const Vec3 p_map = T_start_camera.front().inverse() * points[p];
      point.p_map = scale * (p_map + scene.off * p_map.norm() * drawn());
      const bool is_false = of_map.uniform() < scene.false_looks;
      point.descriptor = !scene.common               ? drawn_look(of_map)
                         : is_false                  ? looks[(p + 1 + c) % looks.size()]
                         : scene.other_side && c > 0 ? looks[(p + looks.size() / 2) % looks.size()]
                                                     : looks[p];
      for (std::size_t i = 0; i < T_start_camera.size(); i += kEvery) {
        const Vec3 p_camera = T_start_camera[i].inverse() * points[p];
        if (rig[c].intrinsics.sees(p_camera)) {
          point.seen.push_back({static_cast<int>(i), rig[c].intrinsics.project(p_camera) +
                                                         scene.noise_px * drawn().head<2>()});
        }
      }
      if (point.seen.size() >= 2) {
        camera.map.points.push_back(point);
      }
    }
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

}  // namespace panoptes
