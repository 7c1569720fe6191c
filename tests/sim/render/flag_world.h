// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>

#include "sim/render/renderer.h"
#include "tests/sim/world/boxes.h"

namespace panoptes::sim {

inline constexpr int kWidth_px = 160;
inline constexpr int kHeight_px = 120;

inline const cv::Scalar kGrey(120, 120, 120);
inline const cv::Scalar kRed(20, 20, 200);
inline const cv::Scalar kGreen(20, 200, 20);

/// A picture with a red left half and a green right half, its lower quarter blue.
inline cv::Mat flag() {
  cv::Mat bgr(64, 64, CV_8UC3, kGreen);
  bgr.colRange(0, 32).setTo(kRed);
  bgr.rowRange(48, 64).setTo(cv::Scalar(200, 20, 20));
  return bgr;
}

/// A grey floor and, 3 m ahead of the origin to the left, a box that shows the flag on each side.
inline World flag_world() {
  World world;
  world.ambient = 1;
  world.textures = {{"grey", cv::Mat(64, 64, CV_8UC3, kGrey)}, {"flag", flag()}};
  world.objects = {{"floor", {}, floor_sheet(0)},
                   {"box", {}, box({2.8, 0.4, 0}, {3.2, 1.2, 0.8}, 1)}};
  return world;
}

inline View ahead(double height_m = 0.5, double tilt_rad = 0) {
  return {pinhole(kWidth_px, kHeight_px, deg_to_rad(80)),
          mounted_camera({0, 0, height_m}, 0, tilt_rad)};
}

}  // namespace panoptes::sim
