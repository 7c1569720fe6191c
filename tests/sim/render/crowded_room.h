// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

#include "core/base/rng.h"
#include "sim/world/world.h"
#include "tests/sim/render/flag_world.h"

namespace panoptes::sim {

/// A room full of boxes that touch, cross, stand one behind another and lean on the walls.
inline World crowded_room() {
  World world;
  world.ambient = 0.5;
  world.sky_bgr = {0.9, 0.5, 0.2};
  world.lights = {{{0, 0, 2.4}, {0.5, 0.5}, {0, 0, -1}, 2.0, ""}};
  cv::Mat noise(256, 256, CV_8UC3);
  Rng rng(5);
  for (int row = 0; row < noise.rows; ++row) {
    for (int column = 0; column < noise.cols; ++column) {
      const int patch = (row / 16 + column / 16) % 2 * 90;
      noise.at<cv::Vec3b>(row, column) =
          cv::Vec3b::all(static_cast<std::uint8_t>(60 + patch + 50 * rng.uniform()));
    }
  }
  world.textures = {{"grey", cv::Mat(64, 64, CV_8UC3, kGrey)}, {"flag", flag()}, {"noise", noise}};
  world.objects = {{"floor", {}, floor_sheet(2)}};
  for (int i = 0; i < 60; ++i) {
    const Vec3 low(-4 + 8 * rng.uniform(), -4 + 8 * rng.uniform(), 0);
    const Vec3 size(0.1 + rng.uniform(), 0.1 + rng.uniform(), 0.1 + 1.5 * rng.uniform());
    if (low.head<2>().norm() > 0.3 && (low + size).head<2>().norm() > 0.3 &&
        !(low.x() < 0.3 && low.y() < 0.3 && low.x() + size.x() > -0.3 &&
          low.y() + size.y() > -0.3)) {
      world.objects.push_back({"box", {}, box(low, low + size, i % 3)});
    }
  }
  return world;
}

/// How many pixels differ by more than `most`, as a share.
inline double share_differing(const cv::Mat& a, const cv::Mat& b, double most) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  difference = difference.reshape(1);
  return cv::countNonZero(difference > most) / static_cast<double>(difference.total());
}

}  // namespace panoptes::sim
