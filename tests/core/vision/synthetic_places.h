// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <numbers>
#include <vector>

#include <opencv2/core.hpp>

#include "core/base/rng.h"
#include "core/geometry/pose3.h"
#include "core/motion/relative_motion.h"

namespace panoptes::testing {

/// Two cameras of 80 degrees, 0.75 m high, 0.15 m before and behind the axle, looking ahead and
/// back.
inline LoopCameras front_and_back() {
  const Intrinsics lens = pinhole(320, 240, deg_to_rad(80));
  return {{"front", "front", lens, mounted_camera({0.15, 0, 0.75}, 0, 0)},
          {"back", "back", lens, mounted_camera({-0.15, 0, 0.75}, std::numbers::pi, 0)}};
}

/// Points on the walls and furniture of a room, each with a random descriptor of its own.
struct SyntheticRoom {
  std::vector<Vec3> points_map;
  cv::Mat descriptors;

  SyntheticRoom(int count, double half_side_m, Rng rng) {
    descriptors.create(count, 32, CV_8U);
    for (int i = 0; i < count; ++i) {
      const double along = rng.uniform(-half_side_m, half_side_m);
      const double off = half_side_m - rng.uniform(0, 0.8);  // furniture along the walls
      const double z = rng.uniform(0, 2);
      const int wall = rng.index(4);
      points_map.push_back(wall == 0   ? Vec3(along, off, z)
                           : wall == 1 ? Vec3(along, -off, z)
                           : wall == 2 ? Vec3(off, along, z)
                                       : Vec3(-off, along, z));
      for (int byte = 0; byte < 32; ++byte) {
        descriptors.at<std::uint8_t>(i, byte) = static_cast<std::uint8_t>(rng.next());
      }
    }
  }

  /// What the cameras see from a pose: pixels with noise, descriptors with a few bits flipped, and
  /// a share of the points replaced by clutter that looks like points seen elsewhere.
  PlaceFeatures seen_from(const LoopCameras& cameras, const Pose2& T_map_body, double noise_px,
                          double clutter, Rng rng) const {
    PlaceFeatures features(cameras.size());
    for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
      const Pose3 T_camera_map = (on_floor(T_map_body) * cameras[camera].T_body_camera).inverse();
      const Intrinsics& lens = cameras[camera].intrinsics;
      for (int i = 0; i < static_cast<int>(points_map.size()); ++i) {
        const Vec3 p_camera = T_camera_map * points_map[i];
        if (p_camera.z() < 0.2) {
          continue;
        }
        Vec2 px = lens.project(p_camera);
        if (px.x() < 0 || px.y() < 0 || px.x() > lens.width_px - 1 || px.y() > lens.height_px - 1) {
          continue;
        }
        px += Vec2(rng.normal(0, noise_px), rng.normal(0, noise_px));
        if (rng.uniform() < clutter) {
          px = {rng.uniform(0, lens.width_px - 1), rng.uniform(0, lens.height_px - 1)};
        }
        cv::Mat row = descriptors.row(i).clone();
        for (int flip = 0; flip < 10; ++flip) {
          const int bit = rng.index(256);
          row.at<std::uint8_t>(0, bit / 8) ^= static_cast<std::uint8_t>(1 << (bit % 8));
        }
        features[camera].px.emplace_back(px.cast<float>());
        features[camera].descriptors.push_back(row);
      }
    }
    return features;
  }
};

}  // namespace panoptes::testing
