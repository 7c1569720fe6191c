// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/upright_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace panoptes {
namespace {

// A robot that nods sees the horizon so far off.
constexpr double kAbove_rad = deg_to_rad(2);
constexpr double kLowest_rad = deg_to_rad(-60);
constexpr double kEdge = 2;           // of the noise, of means of 3 x 3 pixels that are two apart
constexpr std::size_t kHalfEdge = 1;  // pixels
constexpr double kColoured = 0.7;     // of the pixels, the others a pattern's
constexpr int kAcross = 9;            // pixels
constexpr std::size_t kLeastRun = 6;  // pixels of a face, and of the floor before it
constexpr double kApart = 4;          // of the noise, of the means of a face and of the floor
constexpr double kNearer = 2;         // times, the floor's colour is to a known floor's
constexpr double kRaysSeen = 0.25;    // of all

}  // namespace

std::optional<UprightFaces> UprightFaces::of(const FloorProjection& projection,
                                             const RigCamera& camera, double noise_grey) {
  UprightFaces faces;
  const Pose2& T_body_view = projection.T_body_view;
  const Vec3& c = camera.T_body_camera.translation;
  if (!(c.z() > 0.05)) {
    return std::nullopt;
  }
  faces.foot_view_ = T_body_view.inverse() * Vec2(c.head<2>());
  faces.noise_grey_ = noise_grey;
  faces.width_px_ = camera.intrinsics.width_px;
  faces.height_px_ = camera.intrinsics.height_px;
  faces.near_m_ = static_cast<double>(projection.range_m.front());
  const Intrinsics& lens = camera.intrinsics;
  const Eigen::Quaterniond R_camera_body = camera.T_body_camera.rotation.conjugate();
  const double step_rad = 0.5 / lens.fy_px;
  std::size_t seen = 0;
  for (int ray = 0; ray < projection.rays; ++ray) {
    const double angle = projection.first_ray_rad + ray * projection.ray_step_rad;
    const Vec2 along(std::cos(angle), std::sin(angle));
    const Vec2 along_body = T_body_view.rotation() * along;
    std::vector<Sight> sights;
    for (double up_rad = kAbove_rad; up_rad > kLowest_rad; up_rad -= step_rad) {
      const Vec3 d = R_camera_body * Vec3(std::cos(up_rad) * along_body.x(),
                                          std::cos(up_rad) * along_body.y(), std::sin(up_rad));
      if (!lens.sees(d)) {
        break;
      }
      const Vec2 px = lens.project(d);
      const auto pixel = static_cast<std::int32_t>(std::lround(px.y())) * lens.width_px +
                         static_cast<std::int32_t>(std::lround(px.x()));
      if (sights.empty() || sights.back().pixel != pixel) {
        sights.push_back({pixel, up_rad < 0 ? static_cast<float>(c.z() / std::tan(-up_rad))
                                            : std::numeric_limits<float>::infinity()});
      }
    }
    seen += sights.empty() ? 0 : 1;
    faces.directions_.push_back(along);
    faces.sights_.push_back(std::move(sights));
  }
  if (static_cast<double>(seen) < kRaysSeen * projection.rays) {
    return std::nullopt;
  }
  return faces;
}

std::vector<std::optional<UprightFaces::Face>> UprightFaces::find(const cv::Mat& bgr,
                                                                  const Levels* levels,
                                                                  FloorColour& colour) const {
  PANOPTES_CHECK(bgr.type() == CV_8UC3 && bgr.cols == width_px_ && bgr.rows == height_px_,
                 "a picture of the second camera is 8-bit BGR of the size its rig says");
  cv::Mat smooth;
  cv::Mat wide;  // texture evened out across the rays
  cv::blur(bgr, smooth, {3, 3});
  cv::blur(bgr, wide, {kAcross, 3});
  const auto at = [&](const Sight& sight) {
    return smooth.data + 3 * static_cast<std::ptrdiff_t>(sight.pixel);
  };
  const auto difference = [&](const Sight& a, const Sight& b) {
    int most = 0;
    for (int k = 0; k < 3; ++k) {
      most = std::max(most, std::abs(at(a)[k] - at(b)[k]));
    }
    return most;
  };
  const auto has_floor_colour = [&](const Sight& sight) {
    const std::uint8_t* p = at(sight);
    const Bgr as_floor{(*levels)[0][p[0]], (*levels)[1][p[1]], (*levels)[2][p[2]]};
    return colour.quick(as_floor.data()) > 0;
  };
  // Whether the floor's colour goes on from the floor to above the horizon, but for a pattern.
  const auto has_floor_colour_throughout = [&](const std::vector<Sight>& sights) {
    std::size_t coloured = 0;
    std::size_t above = 0;
    std::size_t coloured_above = 0;
    for (const Sight& sight : sights) {
      const bool alike = has_floor_colour(sight);
      coloured += alike ? 1 : 0;
      above += std::isfinite(sight.range_m) ? 0 : 1;
      coloured_above += alike && !std::isfinite(sight.range_m) ? 1 : 0;
    }
    return static_cast<double>(coloured) >= kColoured * static_cast<double>(sights.size()) &&
           static_cast<double>(coloured_above) >= kColoured * static_cast<double>(above);
  };
  // Where what is above is told best from what is below, by their colours' means (least squares);
  // these as the floor camera shows them.
  struct Change {
    std::size_t at = 0;
    Vec3 above = Vec3::Zero();
    Vec3 below = Vec3::Zero();
  };
  const auto change = [&](const std::vector<Sight>& sights) {
    Vec3 all = Vec3::Zero();
    std::vector<Vec3> colours(sights.size());
    for (std::size_t k = 0; k < sights.size(); ++k) {
      const std::uint8_t* p = wide.data + 3 * static_cast<std::ptrdiff_t>(sights[k].pixel);
      colours[k] = Vec3((*levels)[0][p[0]], (*levels)[1][p[1]], (*levels)[2][p[2]]);
      all += colours[k];
    }
    Vec3 above = Vec3::Zero();
    double most = 0;
    Change best;
    for (std::size_t k = 0; k + kLeastRun < sights.size(); ++k) {
      above += colours[k];
      const auto n = static_cast<double>(k + 1);
      const auto m = static_cast<double>(sights.size()) - n;
      const double between = n * m / (n + m) * ((above / n) - (all - above) / m).squaredNorm();
      if (k + 1 >= kLeastRun && std::isfinite(sights[k].range_m) && between > most) {
        most = between;
        best = {k, above / n, (all - above) / m};
      }
    }
    return best;
  };
  // What is below is floor only where it is far more like a floor that is known.
  const auto shows_floor = [&](const Change& found) {
    double below = std::numeric_limits<double>::infinity();
    double above = below;
    for (const ColourGaussian& floor : colour.learned()) {
      below = std::min(below, (found.below - floor.mean).norm());
      above = std::min(above, (found.above - floor.mean).norm());
    }
    return (found.above - found.below).norm() > kApart * noise_grey_ && kNearer * below < above;
  };
  std::vector<std::optional<Face>> faces(sights_.size());
  for (std::size_t ray = 0; ray < sights_.size(); ++ray) {
    const std::vector<Sight>& sights = sights_[ray];
    if (sights.size() <= 2 * kLeastRun) {
      continue;
    }
    std::size_t k = kHalfEdge;
    bool ends = false;
    while (!ends && k + kHalfEdge + 1 < sights.size()) {
      ends = difference(sights[k - kHalfEdge], sights[k + kHalfEdge]) > kEdge * noise_grey_;
      k += ends ? 0 : 1;
    }
    if (levels != nullptr) {
      if (has_floor_colour_throughout(sights)) {
        const Change found = change(sights);
        if (!shows_floor(found)) {  // all that is seen may be of the face
          faces[ray] = Face{foot_view_ + near_m_ * directions_[ray], 0, false};
          continue;
        }
        ends = ends || found.at > k;
        k = std::max(k, found.at);
      }
    }
    const auto range_m = static_cast<double>(sights[k - kHalfEdge].range_m);
    if (std::isfinite(range_m)) {
      faces[ray] = Face{foot_view_ + range_m * directions_[ray],
                        range_m - static_cast<double>(sights[k].range_m), ends};
    }
  }
  return faces;
}

}  // namespace panoptes
