// SPDX-License-Identifier: BSD-3-Clause
// How much there is to see in a world:
//
//     texture_check WORLD.yaml [POSES=400] [SEED=1] [FOLDER for the poorest pictures]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/world/load.h"
#include "tests/sim/world/look_around.h"

namespace panoptes::sim {
namespace {

constexpr int kPoorestKept = 12;

void print_size(const World& world) {
  std::size_t triangles = 0;
  for (const Object& object : world.objects) {
    triangles += object.triangles.size();
  }
  std::printf("%zu objects, %zu triangles, %zu textures, %zu lights\n", world.objects.size(),
              triangles, world.textures.size(), world.lights.size());
}

void print_light(const std::vector<Look>& looks) {
  double grey_sum = 0;
  double white = 0;
  double black = 0;
  for (const Look& look : looks) {
    cv::Mat grey;
    cv::cvtColor(look.bgr, grey, cv::COLOR_BGR2GRAY);
    grey_sum += cv::mean(grey)[0];
    const auto pixels = static_cast<double>(grey.total());
    white += cv::countNonZero(grey >= 254) / pixels;
    black += cv::countNonZero(grey <= 10) / pixels;
  }
  const auto count = static_cast<double>(looks.size());
  std::printf("mean grey %.1f; %.2f %% of pixels white (254 or more), %.2f %% black (10 or less)\n",
              grey_sum / count, 100 * white / count, 100 * black / count);
}

void print_points(std::vector<Look> looks, const std::string& folder) {
  std::erase_if(looks, [](const Look& look) { return look.nearest_m <= kFar_m; });
  std::stable_sort(looks.begin(), looks.end(),
                   [](const Look& a, const Look& b) { return a.sift_points < b.sift_points; });
  const Richness count = richness(looks);
  std::printf(
      "%d pictures with nothing nearer than %.1f m, %.1f %% of them with %d SIFT points or "
      "more\n",
      count.judged, kFar_m, 100 * count.share(), kManyPoints);
  for (const int percent : {1, 5, 10, 50, 90}) {
    if (!looks.empty()) {
      std::printf("  %d %% have fewer than %d\n", percent,
                  looks[looks.size() * static_cast<std::size_t>(percent) / 100].sift_points);
    }
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(looks.size(), kPoorestKept); ++i) {
    const Look& look = looks[i];
    std::printf("  poor %2zu: %4d points at %.2f,%.2f,%.0f %s, nearest %.2f m\n", i,
                look.sift_points, look.T_scene_body.x_m, look.T_scene_body.y_m,
                rad_to_deg(look.T_scene_body.theta_rad), look.is_back ? "back" : "front",
                look.nearest_m);
    if (!folder.empty()) {
      cv::imwrite(folder + "/poor-" + std::to_string(i) + ".png", look.bgr);
    }
  }
}

}  // namespace
}  // namespace panoptes::sim

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "texture_check WORLD.yaml [POSES] [SEED] [FOLDER]\n");
    return 2;
  }
  try {
    cv::setNumThreads(1);
    const panoptes::sim::World world = panoptes::sim::load_world(argv[1]);
    const int poses = argc > 2 ? std::atoi(argv[2]) : 400;
    const auto seed = static_cast<std::uint64_t>(argc > 3 ? std::atoll(argv[3]) : 1);
    const auto looks = panoptes::sim::look_around(world, poses, panoptes::Rng(seed));
    panoptes::sim::print_size(world);
    panoptes::sim::print_light(looks);
    panoptes::sim::print_points(looks, argc > 4 ? argv[4] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
