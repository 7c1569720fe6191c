// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/triangulation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>

#include "core/base/median.h"

namespace panoptes {
namespace {

constexpr double kPoseNoise_px = 0.5;  // of a neighbour's pose: 0.15 degrees on a 190 px lens
constexpr double kNearest_per_m = 10;
constexpr double kBehind = 0.05;  // of the depth: too near the neighbour's picture plane
constexpr int kIterations = 5;

const InverseDepth kUnknown{};

// Where a pixel falls in a neighbour's picture, (at + rho * along) / z, and where it was found.
struct Partner {
  Vec3 at;
  Vec3 along;
  Vec2 px;
  const Intrinsics* lens = nullptr;
};

// The depth on which the partners agree best, and the one of them that agrees least.
struct Fit {
  InverseDepth depth;
  std::size_t worst = 0;
  double worst_m2 = 0;  // squared sigmas
};

Fit fit_depth(const std::vector<Partner>& seen, double variance_px2) {
  const double prior = 1 / (kUnknown.sigma_per_m * kUnknown.sigma_per_m);
  double rho = kUnknown.mean_per_m;
  Fit fit;
  for (int iteration = 0;; ++iteration) {
    double information = prior;
    double gradient = prior * (rho - kUnknown.mean_per_m);
    fit.worst_m2 = 0;
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const Vec3 q = seen[k].at + rho * seen[k].along;
      if (!(q.z() >= kBehind)) {
        fit.worst = k;
        fit.worst_m2 = std::numeric_limits<double>::infinity();
        continue;
      }
      const Intrinsics& lens = *seen[k].lens;
      const Vec3& along = seen[k].along;
      const Vec2 m(q.x() / q.z(), q.y() / q.z());
      const Vec2 focal_px(lens.fx_px, lens.fy_px);
      const Vec2 r = Vec2(lens.cx_px, lens.cy_px) + focal_px.cwiseProduct(m) - seen[k].px;
      const Vec2 j = focal_px.cwiseProduct(along.head<2>() - m * along.z()) / q.z();
      information += j.squaredNorm() / variance_px2;
      gradient += j.dot(r) / variance_px2;
      const double m2 = r.squaredNorm() / variance_px2;
      if (m2 > fit.worst_m2) {
        fit.worst = k;
        fit.worst_m2 = m2;
      }
    }
    if (iteration + 1 == kIterations) {
      fit.depth = {rho, 1 / std::sqrt(information)};
      return fit;
    }
    rho = std::clamp(rho - gradient / information, 0.0, kNearest_per_m);
  }
}

// How the depths of a place are distributed, by those that are known best; robustly, since some
// partners are none. Without it noise would make near things of many far ones in a large hall, and
// each would claim to show where the robot is.
InverseDepth room_of(const PlaceDepths& depths) {
  constexpr std::size_t kEnough = 20;
  constexpr double kMad = 1.4826;     // times the median deviation: sigma of a Gaussian
  constexpr double kWide = 3;         // times as wide: depths of a room are no Gaussian
  constexpr double kNarrowest = 0.1;  // of the mean: no place has all things equally far
  std::vector<InverseDepth> known;
  for (const std::vector<InverseDepth>& of_camera : depths) {
    std::copy_if(of_camera.begin(), of_camera.end(), std::back_inserter(known),
                 [](const InverseDepth& depth) { return depth.is_measured(); });
  }
  if (known.size() < kEnough) {
    return kUnknown;
  }
  std::sort(known.begin(), known.end(), [](const InverseDepth& a, const InverseDepth& b) {
    return a.sigma_per_m < b.sigma_per_m;
  });
  known.resize(std::max(kEnough, known.size() / 2));
  std::vector<double> values;
  double variance = 0;
  for (const InverseDepth& depth : known) {
    values.push_back(depth.mean_per_m);
    variance += depth.sigma_per_m * depth.sigma_per_m / static_cast<double>(known.size());
  }
  const double mean = median(values);
  for (double& value : values) {
    value = std::abs(value - mean);
  }
  const double seen = kMad * median(values);
  const double narrowest = std::max(kNarrowest * mean, 1e-3);
  return {mean, kWide * std::sqrt(std::max(seen * seen - variance, narrowest * narrowest))};
}

// With what is known of the room beforehand, instead of what was said of any room.
InverseDepth in_room(const InverseDepth& depth, const InverseDepth& room) {
  const auto information = [](const InverseDepth& d) {
    return 1 / (d.sigma_per_m * d.sigma_per_m);
  };
  const double own = std::max(0.0, information(depth) - information(kUnknown));
  const double own_mean =
      own > 0
          ? (information(depth) * depth.mean_per_m - information(kUnknown) * kUnknown.mean_per_m) /
                own
          : 0;
  const double together = own + information(room);
  return {std::max(0.0, (own * own_mean + information(room) * room.mean_per_m) / together),
          1 / std::sqrt(together)};
}

}  // namespace

PlaceDepths triangulate(const FeatureOptions& feature_options, const MotionOptions& options,
                        const LoopCameras& cameras, const PlaceFeatures& here,
                        const std::vector<Neighbour>& neighbours) {
  const double variance_px2 =
      2 * options.noise_px * options.noise_px + kPoseNoise_px * kPoseNoise_px;
  const double limit = options.inlier_sigma * options.inlier_sigma;
  PlaceDepths depths(cameras.size());
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    const LoopCamera& eye = cameras[camera];
    std::vector<std::vector<Partner>> partners(here[camera].px.size());
    for (const Neighbour& neighbour : neighbours) {
      const LoopCamera& its_eye = neighbour.cameras[camera];
      const Pose3 T_there_here =
          (on_floor(neighbour.T_here_there) * its_eye.T_body_camera).inverse() * eye.T_body_camera;
      for (const FeatureMatch& match :
           match_features(feature_options, here[camera], neighbour.features[camera])) {
        const Vec3 ray = eye.intrinsics.ray(here[camera].px[match.a].cast<double>());
        partners[match.a].push_back({T_there_here.rotation * ray, T_there_here.translation,
                                     neighbour.features[camera].px[match.b].cast<double>(),
                                     &its_eye.intrinsics});
      }
    }
    depths[camera].assign(partners.size(), kUnknown);
    for (std::size_t feature = 0; feature < partners.size(); ++feature) {
      std::vector<Partner>& seen = partners[feature];
      while (!seen.empty()) {
        const Fit fit = fit_depth(seen, variance_px2);
        if (fit.worst_m2 <= limit) {
          depths[camera][feature] = fit.depth;
          break;
        }
        seen.erase(seen.begin() + static_cast<std::ptrdiff_t>(fit.worst));
      }
    }
  }
  const InverseDepth room = room_of(depths);
  for (std::vector<InverseDepth>& of_camera : depths) {
    for (InverseDepth& depth : of_camera) {
      if (depth.is_measured()) {
        depth = in_room(depth, room);
      }
    }
  }
  return depths;
}

}  // namespace panoptes
