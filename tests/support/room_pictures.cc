// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/room_pictures.h"

#include <cstdint>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "tests/support/picture_noise.h"

namespace panoptes {
namespace {

constexpr int kBlotches = 90;  // of 7 cm
constexpr int kTexels = 1080;

}  // namespace

RoomPainter::RoomPainter(const Intrinsics& lens, double contrast, Rng rng) : lens_(lens) {
  for (int wall = 0; wall < 6; ++wall) {
    cv::Mat blotches(kBlotches, kBlotches, CV_32F);
    for (int i = 0; i < kBlotches * kBlotches; ++i) {
      blotches.at<float>(i) = static_cast<float>(120 + contrast * (rng.uniform() - 0.5));
    }
    walls_.emplace_back();
    cv::resize(blotches, walls_.back(), cv::Size(kTexels, kTexels), 0, 0, cv::INTER_CUBIC);
  }
  for (int v = 0; v < lens.height_px; ++v) {
    for (int u = 0; u < lens.width_px; ++u) {
      rays_.push_back(lens.direction({u, v}).value());
    }
  }
}

cv::Mat RoomPainter::draw(const Pose3& T_room_camera, Rng& rng) const {
  cv::Mat picture(lens_.height_px, lens_.width_px, CV_8U);
  const Mat3 R = T_room_camera.rotation.toRotationMatrix();
  PictureNoise noise(rng);
  for (int i = 0; i < lens_.height_px * lens_.width_px; ++i) {
    const Vec3 ray = R * rays_[static_cast<std::size_t>(i)];
    const Vec3& from = T_room_camera.translation;
    double nearest = std::numeric_limits<double>::infinity();
    int axis = 0;
    for (int a = 0; a < 3; ++a) {
      const double wall = a == 1 ? 1.3 : 3;
      const double distance = ((ray[a] > 0 ? wall : -wall) - from[a]) / ray[a];
      if (distance < nearest) {
        nearest = distance;
        axis = a;
      }
    }
    const Vec3 at = from + nearest * ray;
    const auto texel = [](double m) { return (m + 3) / 6 * (kTexels - 2); };
    const double x = texel(at[(axis + 1) % 3]);
    const double y = texel(at[(axis + 2) % 3]);
    const cv::Mat& wall = walls_[static_cast<std::size_t>(2 * axis + (ray[axis] > 0 ? 1 : 0))];
    const int u = static_cast<int>(x);
    const int v = static_cast<int>(y);
    const auto fx = static_cast<float>(x - u);
    const auto fy = static_cast<float>(y - v);
    const float grey =
        (1 - fy) * ((1 - fx) * wall.at<float>(v, u) + fx * wall.at<float>(v, u + 1)) +
        fy * ((1 - fx) * wall.at<float>(v + 1, u) + fx * wall.at<float>(v + 1, u + 1));
    picture.at<std::uint8_t>(i) = cv::saturate_cast<std::uint8_t>(grey + 2 * noise.normal());
  }
  return picture;
}

}  // namespace panoptes
