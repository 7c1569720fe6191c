// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/upright_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

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

// A column of a picture, from above the horizon down, as the floor camera would show it.
struct Column {
  std::vector<Vec3> colours;        // texture evened out across the rays
  std::vector<std::uint8_t> alike;  // whether each has the floor's colour
  std::size_t above = 0;            // so many of them lie above the horizon
};

// Whether the floor's colour goes on from the floor to above the horizon, but for a pattern.
bool has_floor_colour_throughout(const Column& column) {
  const auto alike = [&](std::size_t count) {
    return static_cast<double>(std::accumulate(
        column.alike.begin(), column.alike.begin() + static_cast<std::ptrdiff_t>(count), 0));
  };
  const std::size_t all = column.alike.size();
  return alike(all) >= kColoured * static_cast<double>(all) &&
         alike(column.above) >= kColoured * static_cast<double>(column.above);
}

// Where what is above is told best from what is below, by their colours' means (least squares).
struct Change {
  std::size_t at = 0;
  Vec3 above = Vec3::Zero();
  Vec3 below = Vec3::Zero();
};

Change change_of(const Column& column) {
  const std::vector<Vec3>& colours = column.colours;
  const Vec3 all = std::accumulate(colours.begin(), colours.end(), Vec3(Vec3::Zero()));
  Vec3 above = Vec3::Zero();
  double most = 0;
  Change best;
  for (std::size_t k = 0; k + kLeastRun < colours.size(); ++k) {
    above += colours[k];
    const auto n = static_cast<double>(k + 1);
    const auto m = static_cast<double>(colours.size()) - n;
    const double between = n * m / (n + m) * ((above / n) - (all - above) / m).squaredNorm();
    if (k + 1 >= kLeastRun && k >= column.above && between > most) {
      most = between;
      best = {k, above / n, (all - above) / m};
    }
  }
  return best;
}

// What is below is floor only where it is far more like a floor that is known.
bool shows_floor(const Change& found, const FloorColour& colour, double noise_grey) {
  double below = std::numeric_limits<double>::infinity();
  double above = below;
  for (const ColourGaussian& floor : colour.learned()) {
    below = std::min(below, (found.below - floor.mean).norm());
    above = std::min(above, (found.above - floor.mean).norm());
  }
  return (found.above - found.below).norm() > kApart * noise_grey && kNearer * below < above;
}

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
  cv::Mat wide;
  cv::blur(bgr, smooth, {3, 3});
  cv::blur(bgr, wide, {kAcross, 3});
  const auto at = [](const cv::Mat& picture, const Sight& sight) {
    return picture.data + 3 * static_cast<std::ptrdiff_t>(sight.pixel);
  };
  const auto is_edge = [&](const Sight& a, const Sight& b) {
    int most = 0;
    for (int k = 0; k < 3; ++k) {
      most = std::max(most, std::abs(at(smooth, a)[k] - at(smooth, b)[k]));
    }
    return most > kEdge * noise_grey_;
  };
  const auto as_floor = [&](const std::uint8_t* p) {
    return Bgr{(*levels)[0][p[0]], (*levels)[1][p[1]], (*levels)[2][p[2]]};
  };
  const auto column_of = [&](const std::vector<Sight>& sights) {
    Column column;
    for (const Sight& sight : sights) {
      const Bgr c = as_floor(at(wide, sight));
      column.colours.emplace_back(c[0], c[1], c[2]);
      column.alike.push_back(colour.quick(as_floor(at(smooth, sight)).data()) > 0 ? 1 : 0);
      column.above += std::isfinite(sight.range_m) ? 0 : 1;
    }
    return column;
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
      ends = is_edge(sights[k - kHalfEdge], sights[k + kHalfEdge]);
      k += ends ? 0 : 1;
    }
    const Column column = levels != nullptr ? column_of(sights) : Column();
    if (levels != nullptr && has_floor_colour_throughout(column)) {
      const Change found = change_of(column);
      if (!shows_floor(found, colour, noise_grey_)) {  // all that is seen may be of the face
        faces[ray] = Face{foot_view_ + near_m_ * directions_[ray], 0, false};
        continue;
      }
      ends = ends || found.at > k;
      k = std::max(k, found.at);
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
