// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/second_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/check.h"
#include "core/geometry/pose3.h"

namespace panoptes {
namespace {

constexpr double kShared = 0.15;    // of the mapped floor, at least
constexpr double kApart_m = 0.04;   // in height
constexpr int kPairStride = 37;     // of samples
constexpr std::size_t kPairs = 40;  // that must show clear floor
constexpr int kClearly = FloorColour::kClip / 3;

}  // namespace

Vec3 SecondView::range_error(double range_m, double direction_rad) const {
  const double by_angle = (range_m * range_m + height_m * height_m) / height_m;
  return {range_m, by_angle * std::cos(direction_rad), by_angle * std::sin(direction_rad)};
}

std::optional<SecondView> second_view(const FloorProjection& projection, const RigCamera& camera) {
  const Pose2 T_view_body = projection.T_body_view.inverse();
  const Vec3 c = camera.T_body_camera.translation;
  SecondView out;
  out.foot_view = T_view_body * Vec2(c.head<2>());
  out.height_m = c.z();
  if (!(out.height_m > 0.05) || std::abs(out.height_m - projection.height_m) < kApart_m) {
    return std::nullopt;
  }
  const Intrinsics& lens = camera.intrinsics;
  const Pose3 T_camera_body = camera.T_body_camera.inverse();
  const auto project = [&](const Vec2& p_view) -> std::optional<Vec2> {
    const Vec2 p_body = projection.T_body_view * p_view;
    const Vec3 p = T_camera_body * Vec3(p_body.x(), p_body.y(), 0);
    if (!lens.sees(p)) {
      return std::nullopt;
    }
    return lens.project(p);
  };
  const auto pixel = [&](const Vec2& px) {
    return static_cast<std::int32_t>(std::lround(px.y())) * lens.width_px +
           static_cast<std::int32_t>(std::lround(px.x()));
  };
  out.pixel.assign(projection.pixel.size(), -1);
  out.depth_m.assign(projection.pixel.size(), 0);
  std::size_t mapped = 0;
  std::size_t shared = 0;
  for (int ray = 0; ray < projection.rays; ++ray) {
    const double angle = projection.first_ray_rad + ray * projection.ray_step_rad;
    const Vec2 along(std::cos(angle), std::sin(angle));
    for (int row = 0; row < projection.rows; ++row) {
      const auto i = static_cast<std::size_t>(row * projection.rays + ray);
      const double range_m = static_cast<double>(projection.range_m[i]);
      const std::optional<Vec2> px = project(out.foot_view + range_m * along);
      constexpr double kLittle_m = 0.005;
      const std::optional<Vec2> beyond =
          px ? project(out.foot_view + (range_m + kLittle_m) * along) : std::nullopt;
      if (beyond) {
        out.pixel[i] = pixel(*px);
        out.depth_m[i] = static_cast<float>(kLittle_m / std::max(1e-6, (*beyond - *px).norm()));
      }
      if (projection.pixel[i] >= 0) {
        ++mapped;
        if (const std::optional<Vec2> same = project(projection.foot_view + range_m * along)) {
          if (shared % kPairStride == 0) {
            out.pairs.push_back({static_cast<std::int32_t>(i), pixel(*same)});
          }
          ++shared;
        }
      }
    }
  }
  if (static_cast<double>(shared) < kShared * static_cast<double>(mapped)) {
    return std::nullopt;
  }
  const double angle_rad = std::max(camera.sigma.rotation_rad.x(), camera.sigma.rotation_rad.y());
  const double height = camera.sigma.position_m.z() / out.height_m;
  out.covariance = Vec3(height, angle_rad, angle_rad).cwiseAbs2().asDiagonal();
  return out;
}

std::optional<Levels> levels_alike(const SecondView& view, const cv::Mat& bgr,
                                   const FloorProjection& projection, const cv::Mat& floor_bgr,
                                   const std::vector<std::int8_t>& known) {
  const cv::Mat picture = bgr.isContinuous() ? bgr : bgr.clone();
  PANOPTES_CHECK(
      picture.type() == CV_8UC3 && static_cast<std::int64_t>(picture.total()) >
                                       *std::max_element(view.pixel.begin(), view.pixel.end()),
      "a picture of the second camera is 8-bit BGR of the size its rig says");
  std::array<std::vector<float>, 3> ratios;
  for (const SecondView::Pair& pair : view.pairs) {
    const auto sample = static_cast<std::size_t>(pair.sample);
    if (known[sample] < kClearly) {
      continue;
    }
    const std::uint8_t* floor =
        floor_bgr.data + 3 * static_cast<std::ptrdiff_t>(projection.pixel[sample]);
    const std::uint8_t* other = picture.data + 3 * static_cast<std::ptrdiff_t>(pair.pixel);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      ratios[channel].push_back((static_cast<float>(floor[channel]) + 1) /
                                (static_cast<float>(other[channel]) + 1));
    }
  }
  if (ratios[0].size() < kPairs) {
    return std::nullopt;
  }
  Levels alike;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::vector<float>& all = ratios[channel];
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    for (std::size_t level = 0; level < 256; ++level) {
      alike[channel][level] = static_cast<std::uint8_t>(
          std::clamp(*middle * (static_cast<float>(level) + 1) - 1 + 0.5F, 0.0F, 255.0F));
    }
  }
  return alike;
}

std::vector<std::int8_t> rate_second(const SecondView& view, const cv::Mat& bgr,
                                     const Levels& levels, FloorColour& colour) {
  const cv::Mat picture = bgr.isContinuous() ? bgr : bgr.clone();
  std::vector<std::int8_t> rated(view.pixel.size(), 0);
  for (std::size_t i = 0; i < view.pixel.size(); ++i) {
    if (view.pixel[i] >= 0) {
      const std::uint8_t* p = picture.data + 3 * static_cast<std::ptrdiff_t>(view.pixel[i]);
      const std::array<std::uint8_t, 3> as_floor{levels[0][p[0]], levels[1][p[1]], levels[2][p[2]]};
      rated[i] = colour.quick(as_floor.data());
    }
  }
  return rated;
}

}  // namespace panoptes
