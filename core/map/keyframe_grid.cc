// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/keyframe_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace panoptes {
namespace {

// Certain enough that ten contradicting pictures from near by still turn it.
constexpr int kCertain = 100;

// A body has stood on a cell: stronger than any one picture.
constexpr int kTouched = 48;

// Pictures nearer together than this share their errors: a pixel moves by about its own size on the
// floor a metre away.
constexpr double kIndependent_m = 0.025;
constexpr double kIndependent_rad = 0.035;

// A second look from the same place adds as much as the first, a third nothing.
constexpr int kSamePlaceLooks = 2;

// Places of the body nearer together than this add nothing: the sweep's edge is a fifth of a
// millimetre short.
constexpr double kTrackStep_m = 0.02;

// Places of a camera nearer together than this see as good as the same.
constexpr double kCameraStep_m = 0.1;
constexpr double kCameraStep_rad = 0.2;

// What proved to be floor is noted by places so far apart, and counts nowhere so near to what
// stands.
constexpr double kProvedStep_m = 0.02;
constexpr double kProvedApart_m = 0.1;

// A line of sight that meets the floor farther away says nothing.
constexpr double kFarthest = 20;  // times as far as what it passes over

// The grid grows by whole blocks, so that it seldom does.
constexpr int kBlock = 64;

int floor_of(double cells) { return static_cast<int>(std::floor(cells)); }
int ceil_of(double cells) { return static_cast<int>(std::ceil(cells)); }

// Where the line y crosses a convex outline: [low, high], empty when low > high.
std::pair<double, double> crossing(const std::vector<Vec2>& outline, double y) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2& a = outline[i];
    const Vec2& b = outline[i + 1 < outline.size() ? i + 1 : 0];
    if ((a.y() <= y) == (b.y() <= y)) {
      continue;
    }
    const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    low = std::min(low, x);
    high = std::max(high, x);
  }
  return {low, high};
}

}  // namespace

std::int8_t GridCrop::at(int column, int row) const {
  if (row < first_row || row >= first_row + static_cast<int>(rows.size())) {
    return 0;
  }
  const Row& r = rows[static_cast<std::size_t>(row - first_row)];
  return column >= r.begin && column < r.end
             ? cells[r.offset + static_cast<std::size_t>(column - r.begin)]
             : std::int8_t{0};
}

namespace {

bool under_body(const GridCrop& crop, const Vec2& p) {
  return std::any_of(crop.traversed.begin(), crop.traversed.end(),
                     [&](const Vec2& place) { return (p - place).norm() < crop.body_radius_m; });
}

bool looks_at(const CameraPlace& camera, const Vec2& to) {
  return std::abs(wrap_angle(std::atan2(to.y(), to.x()) - camera.heading_rad)) <=
         camera.half_width_rad;
}

}  // namespace

bool hide_behind(GridCrop& crop, std::span<const StandingPoint> standing, double half_width_m,
                 double behind_m) {
  bool any = false;
  for (const StandingPoint& point : standing) {
    if (under_body(crop, point.p)) {
      continue;
    }
    for (const CameraPlace& camera : crop.cameras) {
      const Vec2 to = point.p - camera.foot;
      if (to.norm() < half_width_m || point.height_m <= 0 || !looks_at(camera, to)) {
        continue;
      }
      const double over = std::max(camera.height_m - point.height_m, camera.height_m / kFarthest);
      const double reach = camera.height_m / over;
      const Vec2 aside = half_width_m * Vec2(-to.y(), to.x()).normalized();
      const Vec2 foot = point.p + behind_m * to.normalized();
      const std::vector<Vec2> shadow{foot + aside, foot - aside, camera.foot + reach * (to - aside),
                                     camera.foot + reach * (to + aside)};
      double low = shadow.front().y();
      double high = low;
      for (const Vec2& corner : shadow) {
        low = std::min(low, corner.y());
        high = std::max(high, corner.y());
      }
      const int rows = static_cast<int>(crop.rows.size());
      const int begin_row = std::max(0, floor_of(low / crop.cell_m) - crop.first_row);
      const int end_row = std::min(rows, floor_of(high / crop.cell_m) + 1 - crop.first_row);
      for (int r = begin_row; r < end_row; ++r) {
        const GridCrop::Row& row = crop.rows[static_cast<std::size_t>(r)];
        const auto [left, right] = crossing(shadow, (crop.first_row + r + 0.5) * crop.cell_m);
        if (left > right) {
          continue;
        }
        const int begin = std::max(row.begin, floor_of(left / crop.cell_m));
        const int end = std::min(row.end, floor_of(right / crop.cell_m) + 1);
        for (int column = begin; column < end; ++column) {
          std::int8_t& cell = crop.cells[row.offset + static_cast<std::size_t>(column - row.begin)];
          if (cell > 0 &&
              !under_body(crop, crop.cell_m * Vec2(column + 0.5, crop.first_row + r + 0.5))) {
            any = true;
            cell = 0;
          }
        }
      }
    }
  }
  return any;
}

bool forget_obstacles(GridCrop& crop) {
  bool any = false;
  for (std::int8_t& cell : crop.cells) {
    any = any || cell < 0;
    cell = std::max<std::int8_t>(cell, 0);
  }
  return any;
}

bool forget_obstacles_on(GridCrop& crop, std::span<const Vec2> proved_floor) {
  bool any = false;
  const int reach = ceil_of(kProvedStep_m / crop.cell_m);
  for (const Vec2& p : proved_floor) {
    if (std::any_of(crop.standing.begin(), crop.standing.end(), [&](const StandingPoint& point) {
          return (point.p - p).norm() < kProvedApart_m;
        })) {
      continue;
    }
    const int column = floor_of(p.x() / crop.cell_m);
    const int row = floor_of(p.y() / crop.cell_m);
    for (int r = row - reach; r <= row + reach; ++r) {
      for (int c = column - reach; c <= column + reach; ++c) {
        if (crop.at(c, r) < 0) {
          const GridCrop::Row& cells = crop.rows[static_cast<std::size_t>(r - crop.first_row)];
          crop.cells[cells.offset + static_cast<std::size_t>(c - cells.begin)] = 0;
          any = true;
        }
      }
    }
  }
  return any;
}

KeyframeGrid::KeyframeGrid(double cell_m) : cells_(cell_m, kBlock) {
  PANOPTES_CHECK(cell_m > 0, "a grid has cells of some size");
}

void KeyframeGrid::reserve(const Vec2& low, const Vec2& high) {
  const double cell_m = cells_.cell_m();
  cells_.reserve({floor_of(low.x() / cell_m), floor_of(low.y() / cell_m),
                  ceil_of(high.x() / cell_m), ceil_of(high.y() / cell_m)});
}

void KeyframeGrid::add(const FloorReading& reading, const Pose2& T_keyframe_body,
                       int floor_camera) {
  PANOPTES_CHECK(reading.projection != nullptr, "a reading of the floor knows where it lies");
  const FloorProjection& p = *reading.projection;
  PANOPTES_CHECK(reading.evidence.size() == p.sample.size(), "a reading fills its raster");
  const auto [last, first_reading] = T_keyframe_last_.try_emplace(floor_camera, T_keyframe_body);
  const Pose2 T_last_body = last->second.inverse() * T_keyframe_body;
  const bool independent = first_reading || T_last_body.position().norm() >= kIndependent_m ||
                           std::abs(T_last_body.theta_rad) >= kIndependent_rad;
  if (independent) {
    last->second = T_keyframe_body;
  }
  const Pose2 T_keyframe_view = T_keyframe_body * p.T_body_view;
  const Vec2 foot = T_keyframe_view * p.foot_view;
  const double half_width_rad = 0.5 * p.rays * p.ray_step_rad;
  const CameraPlace here{foot, p.height_m,
                         wrap_angle(T_keyframe_view.theta_rad + p.first_ray_rad + half_width_rad),
                         half_width_rad + kCameraStep_rad};
  if (std::none_of(cameras_.begin(), cameras_.end(), [&](const CameraPlace& camera) {
        return (camera.foot - foot).norm() < kCameraStep_m && camera.height_m == here.height_m &&
               std::abs(wrap_angle(camera.heading_rad - here.heading_rad)) < kCameraStep_rad;
      })) {
    cameras_.push_back(here);
  }

  std::vector<Vec2> outline;
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = -low;
  for (const Vec2& corner : p.outline_view) {
    outline.push_back(T_keyframe_view * corner);
    low = low.cwiseMin(outline.back());
    high = high.cwiseMax(outline.back());
  }
  reserve(low, high);
  const double cell_m = cells_.cell_m();
  const CellBox box = cells_.box();

  // For each cell of the grid within the outline, the raster's cell under its centre, in fixed
  // point: no cell is left out or met twice.
  const Pose2 T_view_keyframe = T_keyframe_view.inverse();
  const std::int8_t* evidence = reading.evidence.data();
  constexpr int kShift = 16;
  const double scale = cell_m / p.cell_m * (1 << kShift);
  const auto step_x =
      static_cast<std::int32_t>(std::lround(std::cos(T_view_keyframe.theta_rad) * scale));
  const auto step_y =
      static_cast<std::int32_t>(std::lround(std::sin(T_view_keyframe.theta_rad) * scale));
  const int first_row = std::max(box.low_row, floor_of(low.y() / cell_m));
  const int last_row = std::min(box.end_row - 1, floor_of(high.y() / cell_m));
  for (int row = first_row; row <= last_row; ++row) {
    const double y = (row + 0.5) * cell_m;
    const auto [left, right] = crossing(outline, y);
    if (left > right) {
      continue;
    }
    const int begin = std::max(box.low_column, floor_of(left / cell_m));
    const int end = std::min(box.end_column, ceil_of(right / cell_m));
    const Vec2 at = (T_view_keyframe * Vec2((begin + 0.5) * cell_m, y) - p.origin_view) / p.cell_m *
                    (1 << kShift);
    auto x_fixed = static_cast<std::int32_t>(std::floor(at.x()));
    auto y_fixed = static_cast<std::int32_t>(std::floor(at.y()));
    std::int8_t* cells = cells_.row(row);
    for (int k = begin - box.low_column; k < end - box.low_column;
         ++k, x_fixed += step_x, y_fixed += step_y) {
      const std::int32_t c = x_fixed >> kShift;
      const std::int32_t r = y_fixed >> kShift;
      if (static_cast<std::uint32_t>(c) >= static_cast<std::uint32_t>(p.cell_columns) ||
          static_cast<std::uint32_t>(r) >= static_cast<std::uint32_t>(p.cell_rows)) {
        continue;
      }
      const std::int8_t e = evidence[r * p.cell_columns + c];
      if (e == 0) {
        continue;
      }
      const std::int8_t was = cells[k];
      // seen from the same place, a cell gains no more than its looks there are worth
      const int limit =
          independent ? kCertain : std::max(kSamePlaceLooks * std::abs(e), std::abs(was));
      cells[k] = static_cast<std::int8_t>(
          std::clamp(was + e, std::min<int>(-limit, was), std::max<int>(limit, was)));
    }
  }
}

void KeyframeGrid::forget_obstacles() {
  const CellBox& box = cells_.box();
  std::int8_t* cells = cells_.data();
  for (std::size_t i = 0; i < static_cast<std::size_t>(box.columns()) * box.rows(); ++i) {
    cells[i] = std::max<std::int8_t>(cells[i], 0);
  }
}

void KeyframeGrid::add_disc(const Vec2& p_keyframe, double radius_m, int evidence) {
  const Vec2 reach = Vec2::Constant(radius_m);
  reserve(p_keyframe - reach, p_keyframe + reach);
  const double cell_m = cells_.cell_m();
  const CellBox box = cells_.box();
  const int low = floor_of((p_keyframe.y() - radius_m) / cell_m);
  const int high = floor_of((p_keyframe.y() + radius_m) / cell_m);
  for (int row = std::max(low, box.low_row); row <= std::min(high, box.end_row - 1); ++row) {
    const double dy = (row + 0.5) * cell_m - p_keyframe.y();
    const double half_square = radius_m * radius_m - dy * dy;
    if (half_square <= 0) {
      continue;
    }
    const double half = std::sqrt(half_square);
    const int begin = std::max(box.low_column, ceil_of((p_keyframe.x() - half) / cell_m - 0.5));
    const int end = std::min(box.end_column, floor_of((p_keyframe.x() + half) / cell_m - 0.5) + 1);
    for (int column = begin; column < end; ++column) {
      std::int8_t& cell = cells_(column, row);
      cell = evidence > 0 ? std::max(cell, static_cast<std::int8_t>(evidence))
                          : std::min(cell, static_cast<std::int8_t>(evidence));
    }
  }
}

void KeyframeGrid::add_free_disc(const Vec2& p_keyframe, double radius_m) {
  add_disc(p_keyframe, radius_m, kTouched);
}

void KeyframeGrid::add_body(const Vec2& p_keyframe, double radius_m) {
  add_free_disc(p_keyframe, radius_m);
  body_radius_m_ = radius_m;
  if (traversed_.empty() || (traversed_.back() - p_keyframe).norm() >= kTrackStep_m) {
    traversed_.push_back(p_keyframe);
  }
}

void KeyframeGrid::add_occupied_disc(const Vec2& p_keyframe, double radius_m) {
  add_disc(p_keyframe, radius_m, -kTouched);
}

void KeyframeGrid::add_proved_floor(const Vec2& p_keyframe) {
  proved_floor_.emplace(
      std::pair(floor_of(p_keyframe.x() / kProvedStep_m), floor_of(p_keyframe.y() / kProvedStep_m)),
      p_keyframe);
}

GridCrop KeyframeGrid::crop() const {
  GridCrop out;
  out.cell_m = cells_.cell_m();
  out.traversed = traversed_;
  out.body_radius_m = body_radius_m_;
  out.cameras = cameras_;
  out.standing = standing_;
  for (const auto& [cell, p] : proved_floor_) {
    out.proved_floor.push_back(p);
  }
  const CellBox& box = cells_.box();
  const auto set = [](std::int8_t v) { return v != 0; };
  bool any = false;
  for (int row = box.low_row; row < box.end_row; ++row) {
    const std::int8_t* begin = cells_.row(row);
    const std::int8_t* end = begin + box.columns();
    const std::int8_t* first = std::find_if(begin, end, set);
    GridCrop::Row r;
    r.offset = out.cells.size();
    if (first != end) {
      const std::int8_t* last = end;
      while (*(last - 1) == 0) {
        --last;
      }
      if (!any) {
        out.first_row = row;
      }
      r.begin = box.low_column + static_cast<int>(first - begin);
      r.end = box.low_column + static_cast<int>(last - begin);
      out.cells.insert(out.cells.end(), first, last);
      any = true;
    }
    if (any) {
      out.rows.push_back(r);
    }
  }
  while (!out.rows.empty() && out.rows.back().begin == out.rows.back().end) {
    out.rows.pop_back();
  }
  out.cells.shrink_to_fit();
  return out;
}

}  // namespace panoptes
