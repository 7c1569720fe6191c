// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/seen.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/check.h"
#include "sim/sensors/floor_pixels.h"

namespace panoptes::sim {
namespace {

bool anything_stands_in(const TruthLayer& floor, const TruthLayer& seen, int column, int row) {
  const Vec2 low = seen.point(column, row);
  const int side = std::max(1, static_cast<int>(std::lround(seen.cell_m / floor.cell_m)));
  const int first_column =
      static_cast<int>(std::lround((low.x() - floor.origin.x()) / floor.cell_m));
  const int first_row = static_cast<int>(std::lround((low.y() - floor.origin.y()) / floor.cell_m));
  for (int y = first_row; y < first_row + side; ++y) {
    for (int x = first_column; x < first_column + side; ++x) {
      if (floor.contains(x, y) && floor(x, y) != 0) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

SeenFloor::SeenFloor(const RigCamera& true_camera, const Body& body)
    : width_px_(true_camera.intrinsics.width_px),
      height_px_(true_camera.intrinsics.height_px),
      top_px_(first_mapped_row(true_camera)) {
  PANOPTES_CHECK(true_camera.floor.has_value(), "a floor camera has its floor view");
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  for (int v = top_px_; v < height_px_; ++v) {
    for (int u = 0; u < width_px_; ++u) {
      const std::optional<Vec2> p_body = floor_under(true_camera, Vec2(u, v));
      const bool mapped = p_body && in_mapped_range(true_camera, body, *p_body);
      x_body_m_.push_back(mapped ? static_cast<float>(p_body->x()) : kNowhere);
      y_body_m_.push_back(mapped ? static_cast<float>(p_body->y()) : kNowhere);
    }
  }
}

void SeenFloor::mark(const cv::Mat& floor_label, const Pose2& T_scene_body, const TruthLayer& floor,
                     TruthLayer& seen) const {
  PANOPTES_CHECK(floor_label.type() == CV_8UC1 && floor_label.cols == width_px_ &&
                     floor_label.rows == height_px_,
                 "a floor label has the picture's size and one byte a pixel");
  // cell = rotation * p_body + translation, in units of cells
  const double per_cell = 1 / seen.cell_m;
  const float c = static_cast<float>(std::cos(T_scene_body.theta_rad) * per_cell);
  const float s = static_cast<float>(std::sin(T_scene_body.theta_rad) * per_cell);
  const float x0 = static_cast<float>((T_scene_body.x_m - seen.origin.x()) * per_cell);
  const float y0 = static_cast<float>((T_scene_body.y_m - seen.origin.y()) * per_cell);
  const float columns = static_cast<float>(seen.columns);
  const float rows = static_cast<float>(seen.rows);

  enum : std::uint8_t { kNoFloorYet, kOnFloor, kEnded };
  std::vector<std::uint8_t> column_state(static_cast<std::size_t>(width_px_), kNoFloorYet);
  for (int v = height_px_ - 1; v >= top_px_; --v) {
    const std::uint8_t* label = floor_label.ptr<std::uint8_t>(v);
    const std::size_t row_at =
        static_cast<std::size_t>(v - top_px_) * static_cast<std::size_t>(width_px_);
    for (int u = 0; u < width_px_; ++u) {
      std::uint8_t& state = column_state[static_cast<std::size_t>(u)];
      const bool shows_floor = label[u] != 0;
      const bool foot = !shows_floor && state == kOnFloor;
      if (!shows_floor && !foot) {
        continue;
      }
      if (state != kEnded) {
        state = shows_floor ? kOnFloor : kEnded;
      }
      const float x = x_body_m_[row_at + static_cast<std::size_t>(u)];
      const float y = y_body_m_[row_at + static_cast<std::size_t>(u)];
      const float column = x0 + c * x - s * y;
      const float row = y0 + s * x + c * y;
      if (column >= 0 && column < columns && row >= 0 && row < rows) {  // false for NaN
        std::uint8_t& cell = seen(static_cast<int>(column), static_cast<int>(row));
        if (cell == 0 && (shows_floor || anything_stands_in(floor, seen, static_cast<int>(column),
                                                            static_cast<int>(row)))) {
          cell = 1;
        }
      }
    }
  }
}

}  // namespace panoptes::sim
