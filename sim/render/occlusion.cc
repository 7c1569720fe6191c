// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/occlusion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace panoptes::sim {
namespace {

constexpr int kTile_px = 8;
// Rasterisers move edges to 1/256 of a pixel, and floats err by less at these sizes.
constexpr float kEdge_px = 0.05F;
// What hides is nearer by this share: more than depth is rounded by, less than anything is thick.
constexpr float kNearer = 1e-4F;

}  // namespace

void Occlusion::start(const Eigen::Matrix4f& clip_scene, int width_px, int height_px,
                      float near_m) {
  clip_scene_ = clip_scene;
  width_px_ = width_px;
  height_px_ = height_px;
  near_m_ = near_m;
  columns_ = (width_px + kTile_px - 1) / kTile_px;
  rows_ = (height_px + kTile_px - 1) / kTile_px;
  tiles_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0.0F);
}

void Occlusion::project(const SpaceRectangle& rectangle) {
  const Eigen::Vector4f corner =
      clip_scene_ *
      Eigen::Vector4f(rectangle.corner.x(), rectangle.corner.y(), rectangle.corner.z(), 1.0F);
  const Eigen::Vector4f u = clip_scene_.leftCols<3>() * rectangle.side_u;
  const Eigen::Vector4f v = clip_scene_.leftCols<3>() * rectangle.side_v;
  const std::array<Eigen::Vector4f, 4> clip{corner, corner + u, corner + u + v, corner + v};
  in_front_ = true;
  for (std::size_t i = 0; i < clip.size(); ++i) {
    const float distance = clip[i].w();
    in_front_ = in_front_ && distance > near_m_;
    const float inverse = 1.0F / distance;
    px_[i] = {(clip[i].x() * inverse + 1.0F) * 0.5F * static_cast<float>(width_px_),
              (clip[i].y() * inverse + 1.0F) * 0.5F * static_cast<float>(height_px_), inverse};
  }
}

bool Occlusion::hides(const SpaceRectangle& rectangle) {
  project(rectangle);
  if (!in_front_) {
    return false;
  }
  Eigen::Vector3f low = px_[0];
  Eigen::Vector3f high = px_[0];
  for (const Eigen::Vector3f& p : px_) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const auto tile = [](float px, float most_px) {
    return static_cast<int>(std::clamp(px, 0.0F, most_px - 1.0F)) / kTile_px;
  };
  const auto width = static_cast<float>(width_px_);
  const auto height = static_cast<float>(height_px_);
  const int first = tile(low.x() - 1, width);
  const int last = tile(high.x() + 1, width);
  const int bottom = tile(high.y() + 1, height);
  const float nearest = high.z() * (1.0F + kNearer);
  for (int row = tile(low.y() - 1, height); row <= bottom; ++row) {
    for (int column = first; column <= last; ++column) {
      if (inverse_depth(column, row) <= nearest) {
        return false;
      }
    }
  }
  return true;
}

void Occlusion::add() {
  if (!in_front_) {
    return;
  }
  // 1 / distance is linear over the picture: through three corners.
  const Eigen::Vector3f a = px_[1] - px_[0];
  const Eigen::Vector3f b = px_[3] - px_[0];
  const float area = a.x() * b.y() - a.y() * b.x();
  if (std::abs(area) < kTile_px * kTile_px) {
    return;
  }
  const float per_x = (a.z() * b.y() - b.z() * a.y()) / area;
  const float per_y = (b.z() * a.x() - a.z() * b.x()) / area;
  const float turn = area > 0 ? 1.0F : -1.0F;
  // Each edge as inwards * p >= offset, at the worst corner of a tile whose first corner p is.
  std::array<Eigen::Vector2f, 4> inwards;
  std::array<float, 4> offset{};
  float top_px = px_[0].y();
  float bottom_px = px_[0].y();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3f& from = px_[i];
    const Eigen::Vector3f edge = px_[(i + 1) % 4] - from;
    const float length = edge.head<2>().norm();
    if (!(length > 0)) {
      return;
    }
    inwards[i] = Eigen::Vector2f(-edge.y(), edge.x()) * (turn / length);
    offset[i] = inwards[i].dot(from.head<2>()) + kEdge_px -
                kTile_px * (std::min(inwards[i].x(), 0.0F) + std::min(inwards[i].y(), 0.0F));
    top_px = std::min(top_px, from.y());
    bottom_px = std::max(bottom_px, from.y());
  }
  const float least = px_[0].z() + kTile_px * (std::min(per_x, 0.0F) + std::min(per_y, 0.0F)) -
                      per_x * px_[0].x() - per_y * px_[0].y();
  const int first_row = std::max(0, static_cast<int>(std::ceil(std::max(top_px, 0.0F) / kTile_px)));
  const int last_row =
      static_cast<int>(std::floor(std::min(bottom_px, static_cast<float>(height_px_)) / kTile_px));
  for (int row = first_row; row < rows_ && row <= last_row; ++row) {
    const auto y = static_cast<float>(row * kTile_px);
    float first = 0;
    auto last = static_cast<float>(columns_ - 1);
    for (std::size_t i = 0; i < 4; ++i) {
      const float missing = offset[i] - inwards[i].y() * y;
      const float across = inwards[i].x() * kTile_px;
      if (across > 0) {
        first = std::max(first, std::ceil(missing / across));
      } else if (across < 0) {
        last = std::min(last, std::floor(missing / across));
      } else if (missing > 0) {
        last = -1;
      }
    }
    const int end = static_cast<int>(std::max(last, -1.0F)) + 1;
    for (int column = static_cast<int>(std::min(first, static_cast<float>(columns_))); column < end;
         ++column) {
      float& tile = inverse_depth(column, row);
      tile = std::max(tile, least + per_x * static_cast<float>(column * kTile_px) + per_y * y);
    }
  }
}

}  // namespace panoptes::sim
