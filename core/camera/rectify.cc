// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera/rectify.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace panoptes {
namespace {

// What lies farther out takes most of a pinhole's picture and shows little of the room.
constexpr double kMostHalfView_rad = deg_to_rad(55);
constexpr double kMostMarkAngle_rad = deg_to_rad(89);
constexpr int kBisections = 60;

Intrinsics unbent(const Intrinsics& lens, double f_px) {
  return {lens.width_px, lens.height_px, f_px, f_px, lens.cx_px, lens.cy_px, {}};
}

/// Whether everything on the edge of the pinhole's picture is in the lens's as well.
bool within(const Intrinsics& pinhole, const Intrinsics& lens) {
  const auto seen = [&](double x_px, double y_px) {
    const Vec3 ray = pinhole.ray({x_px, y_px});
    if (!lens.sees(ray)) {
      return false;
    }
    const Vec2 px = lens.project(ray);  // between the centres of pixels, so that none is made up
    return px.x() >= 0 && px.y() >= 0 && px.x() <= lens.width_px - 1 &&
           px.y() <= lens.height_px - 1;
  };
  for (int x_px = 0; x_px < lens.width_px; ++x_px) {
    if (!seen(x_px, 0) || !seen(x_px, lens.height_px - 1)) {
      return false;
    }
  }
  for (int y_px = 0; y_px < lens.height_px; ++y_px) {
    if (!seen(0, y_px) || !seen(lens.width_px - 1, y_px)) {
      return false;
    }
  }
  return true;
}

void move_marks(const Intrinsics& lens, const Intrinsics& pinhole, FloorView& floor) {
  std::vector<FloorMark> moved;
  for (FloorMark mark : floor.marks) {
    const std::optional<Vec3> d = lens.direction(mark.px);
    if (d && d->z() > std::cos(kMostMarkAngle_rad)) {
      mark.px = pinhole.project(*d);
      moved.push_back(mark);
    }
  }
  floor.marks = moved;
}

}  // namespace

Intrinsics rectified(const Intrinsics& lens) {
  const double farthest_px = std::max(
      {lens.cx_px, lens.width_px - 1 - lens.cx_px, lens.cy_px, lens.height_px - 1 - lens.cy_px});
  const double least_px = farthest_px / std::tan(kMostHalfView_rad);
  if (within(unbent(lens, least_px), lens)) {
    return unbent(lens, least_px);
  }
  double narrow_px = least_px;
  while (!within(unbent(lens, narrow_px), lens)) {
    narrow_px *= 2;
    PANOPTES_CHECK(std::isfinite(narrow_px), "a lens sees what its picture's middle shows");
  }
  double wide_px = least_px;
  for (int i = 0; i < kBisections; ++i) {
    const double middle_px = (wide_px + narrow_px) / 2;
    (within(unbent(lens, middle_px), lens) ? narrow_px : wide_px) = middle_px;
  }
  return unbent(lens, narrow_px);
}

Rectifier::Rectifier(const Rig& raw) : rig_(raw) {
  for (auto& [name, camera] : rig_.cameras) {
    const Intrinsics lens = camera.intrinsics;
    if (lens.is_pinhole()) {
      continue;
    }
    camera.intrinsics = panoptes::rectified(lens);
    camera.sigma.centre_px *= camera.intrinsics.fx_px / lens.fx_px;  // of the pixels made here
    if (camera.floor) {
      move_marks(lens, camera.intrinsics, *camera.floor);
    }
    cv::Mat at_px(lens.height_px, lens.width_px, CV_32FC2);
    for (int v = 0; v < lens.height_px; ++v) {
      for (int u = 0; u < lens.width_px; ++u) {
        const Vec2 px = lens.project(camera.intrinsics.ray(Vec2(u, v)));
        at_px.at<cv::Vec2f>(v, u) = {static_cast<float>(px.x()), static_cast<float>(px.y())};
      }
    }
    Maps& maps = maps_[name];
    cv::convertMaps(at_px, cv::noArray(), maps.whole, maps.part, CV_16SC2);
  }
}

Observation Rectifier::rectified(const Observation& raw) const {
  Observation out = raw;
  for (const auto& [name, maps] : maps_) {
    const auto picture = out.pictures.find(name);
    if (picture == out.pictures.end()) {
      continue;
    }
    PANOPTES_CHECK(picture->second.bgr.size() == maps.whole.size(),
                   "a picture has the size its camera has in the rig");
    cv::Mat straight;
    cv::remap(picture->second.bgr, straight, maps.whole, maps.part, cv::INTER_LINEAR,
              cv::BORDER_REPLICATE);
    picture->second.bgr = straight;
  }
  return out;
}

}  // namespace panoptes
