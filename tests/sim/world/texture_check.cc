// SPDX-License-Identifier: BSD-3-Clause
// How much there is to see in a world:
//
//     texture_check WORLD.yaml [POSES=400] [SEED=1] [FOLDER for the poorest pictures]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/world/load.h"
#include "tests/sim/world/look_around.h"

namespace panoptes::sim {
namespace {

constexpr std::size_t kPoorestKept = 12;

void print_size(const World& world) {
  std::size_t triangles = 0;
  for (const Object& object : world.objects) {
    triangles += object.triangles.size();
  }
  std::printf("%zu objects, %zu triangles, %zu textures, %zu lights\n", world.objects.size(),
              triangles, world.textures.size(), world.lights.size());
}

/// What is kept of the pictures: sums, and the poorest ones whole.
class Tally {
 public:
  void add(Look look) {
    cv::Mat grey;
    cv::cvtColor(look.bgr, grey, cv::COLOR_BGR2GRAY);
    const auto pixels = static_cast<double>(grey.total());
    grey_sum_ += cv::mean(grey)[0];
    white_ += cv::countNonZero(grey >= 254) / pixels;
    black_ += cv::countNonZero(grey <= 10) / pixels;
    ++pictures_;
    richness_.add(look);
    if (look.nearest_m <= kFar_m) {
      return;
    }
    points_.push_back(look.sift_points);
    const auto at = std::upper_bound(
        poorest_.begin(), poorest_.end(), look,
        [](const Look& a, const Look& b) { return a.sift_points < b.sift_points; });
    poorest_.insert(at, std::move(look));
    if (poorest_.size() > kPoorestKept) {
      poorest_.pop_back();
    }
  }

  void print(const std::string& folder) {
    std::printf(
        "mean grey %.1f; %.2f %% of pixels white (254 or more), %.2f %% black (10 or less)\n",
        grey_sum_ / pictures_, 100 * white_ / pictures_, 100 * black_ / pictures_);
    std::printf(
        "%d pictures with nothing nearer than %.1f m, %.1f %% of them with %d SIFT points "
        "or more\n",
        richness_.judged, kFar_m, 100 * richness_.share(), kManyPoints);
    std::sort(points_.begin(), points_.end());
    for (const std::size_t percent : {1, 5, 10, 50, 90}) {
      if (!points_.empty()) {
        std::printf("  %zu %% have fewer than %d\n", percent,
                    points_[points_.size() * percent / 100]);
      }
    }
    for (std::size_t i = 0; i < poorest_.size(); ++i) {
      const Look& look = poorest_[i];
      std::printf("  poor %2zu: %4d points at %.2f,%.2f,%.0f %s, nearest %.2f m\n", i,
                  look.sift_points, look.T_scene_body.x_m, look.T_scene_body.y_m,
                  rad_to_deg(look.T_scene_body.theta_rad), look.is_back ? "back" : "front",
                  look.nearest_m);
      if (!folder.empty()) {
        cv::imwrite(folder + "/poor-" + std::to_string(i) + ".png", look.bgr);
      }
    }
  }

 private:
  int pictures_ = 0;
  double grey_sum_ = 0;
  double white_ = 0;
  double black_ = 0;
  Richness richness_;
  std::vector<int> points_;
  std::vector<Look> poorest_;
};

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
    panoptes::sim::print_size(world);
    panoptes::sim::Tally tally;
    panoptes::sim::look_around(world, poses, panoptes::Rng(seed),
                               [&tally](panoptes::sim::Look look) { tally.add(std::move(look)); });
    tally.print(argc > 4 ? argv[4] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
