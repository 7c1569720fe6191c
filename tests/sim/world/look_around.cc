// SPDX-License-Identifier: BSD-3-Clause
#include "tests/sim/world/look_around.h"

#include <numbers>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/check.h"
#include "core/camera/rig.h"
#include "sim/physics/obstacles.h"
#include "sim/render/renderer.h"
#include "sim/world/layers.h"

namespace panoptes::sim {
namespace {

constexpr double kRobotRadius_m = 0.25;
constexpr double kRobotHeight_m = 0.8;
constexpr double kClear_m = 0.35;
constexpr int kTries = 100000;

}  // namespace

void look_around(const World& world, int poses, Rng rng, const std::function<void(Look)>& see) {
  const Obstacles obstacles(outlines(world, kFloorLayerTop_m, kRobotHeight_m));
  const FreeRegion region(obstacles, kRobotRadius_m);
  const Vec2 low = obstacles.low_scene();
  const Vec2 high = obstacles.high_scene();
  const Intrinsics intrinsics = pinhole(640, 480, deg_to_rad(80));
  Renderer renderer(world);
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create();
  int found = 0;
  for (int tries = 0; found < poses; ++tries) {
    PANOPTES_CHECK(tries < kTries, "there is free floor to look from");
    const double x = rng.uniform(low.x(), high.x());
    const double y = rng.uniform(low.y(), high.y());
    const Pose2 at{x, y, rng.uniform(-std::numbers::pi, std::numbers::pi)};
    if (!region.contains(at.position()) || obstacles.nearest(at.position(), kClear_m)) {
      continue;
    }
    for (const bool is_back : {false, true}) {
      const Pose3 T_body_camera =
          mounted_camera({0, 0, is_back ? 0.71 : 0.79}, is_back ? std::numbers::pi : 0, 0);
      const RenderedImage rendered =
          renderer.draw({intrinsics, on_floor(at) * T_body_camera}, {.depth = true});
      Look look{at, is_back, 0, 0, rendered.bgr};
      cv::minMaxLoc(rendered.depth_m, &look.nearest_m);
      cv::Mat grey;
      cv::cvtColor(rendered.bgr, grey, cv::COLOR_BGR2GRAY);
      std::vector<cv::KeyPoint> points;
      sift->detect(grey, points);
      look.sift_points = static_cast<int>(points.size());
      see(std::move(look));
    }
    ++found;
  }
}

void Richness::add(const Look& look) {
  if (look.nearest_m > kFar_m) {
    ++judged;
    rich += look.sift_points >= kManyPoints ? 1 : 0;
  }
}

Richness richness(const World& world, int poses, Rng rng) {
  Richness count;
  look_around(world, poses, rng, [&count](const Look& look) { count.add(look); });
  return count;
}

}  // namespace panoptes::sim
