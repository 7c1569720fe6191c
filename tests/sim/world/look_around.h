// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include <opencv2/core/mat.hpp>

#include "core/base/rng.h"
#include "core/geometry/pose2.h"
#include "sim/world/world.h"

namespace panoptes::sim {

/// A picture of 640x480 px, 80 degrees wide, from where camera A or B of
/// scenes/rigs/front-back-floor.yaml has its eye.
struct Look {
  Pose2 T_scene_body;
  bool is_back = false;  ///< camera B's
  double nearest_m = 0;  ///< smallest depth in the picture
  int sift_points = 0;   ///< with SIFT as OpenCV has it by default
  cv::Mat bgr;           ///< without noise
};

/// Pictures of both cameras at random places that a robot of 0.25 m radius gets to and that have
/// 0.35 m clear all around, headings random; each is shown to `see`.
void look_around(const World& world, int poses, Rng rng, const std::function<void(Look)>& see);

inline constexpr double kFar_m = 0.6;  ///< pictures with something nearer are not judged
inline constexpr int kManyPoints = 150;

/// How rich in texture the pictures are that show nothing nearer than kFar_m.
struct Richness {
  int judged = 0;
  int rich = 0;  ///< of these, with kManyPoints or more

  void add(const Look& look);
  double share() const { return judged == 0 ? 1 : static_cast<double>(rich) / judged; }
};
Richness richness(const World& world, int poses, Rng rng);

}  // namespace panoptes::sim
