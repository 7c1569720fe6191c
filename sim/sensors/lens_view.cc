// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/lens_view.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

// The pinholes together have at most so many pixels for each one of the picture; edges in the
// middle of it are a little coarser where that does not do.
constexpr double kMostPixels = 1.5;
// What one more face costs besides its pixels: as much as so many of them.
constexpr double kFaceCost_px = 25'000;
// No face draws what is farther off its axis.
constexpr double kMostFaceAngle_rad = deg_to_rad(72);
// Directions are looked at on a grid this fine to choose the faces.
constexpr int kGrid = 64;
constexpr int kMargin_px = 2;  // for interpolation, and for what lies between points of the grid
constexpr int kRowsTogether = 2 * kFaceRows;  // parts of faces come in few different heights

int rounded_up(int value, int step) { return (value + step - 1) / step * step; }

struct Box {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = Vec2::Constant(-std::numeric_limits<double>::infinity());
  bool empty() const { return !(low.x() <= high.x()); }
  void add(const Vec2& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

Eigen::Quaterniond turned(double yaw_rad, double pitch_rad) {
  return Eigen::AngleAxisd(yaw_rad, Vec3::UnitY()) * Eigen::AngleAxisd(pitch_rad, Vec3::UnitX());
}

/// Which face shows a direction: the one that looks there most.
std::size_t face_of(const std::vector<Eigen::Quaterniond>& R_camera_faces, const Vec3& d_camera) {
  std::size_t best = 0;
  double most = -2;
  for (std::size_t i = 0; i < R_camera_faces.size(); ++i) {
    const double along = (R_camera_faces[i] * Vec3::UnitZ()).dot(d_camera);
    if (along > most) {
      most = along;
      best = i;
    }
  }
  return best;
}

/// A layout to see with several pinholes of one focal length what the lens sees.
struct Plan {
  std::vector<Eigen::Quaterniond> R_camera_faces;
  std::vector<Box> boxes;  ///< of each face's picture at focal length 1
  double f_px = 0;         ///< where every pixel of the lens finds one as fine
  bool possible = true;

  double area() const {
    double sum = 0;
    for (const Box& box : boxes) {
      sum += (box.high - box.low).prod();
    }
    return sum;
  }
};

Vec3 sure_direction(const Intrinsics& lens, const Vec2& px) {
  const std::optional<Vec3> d = lens.direction(px);
  PANOPTES_CHECK(d.has_value(), "a lens without a fault has a direction for every pixel");
  return *d;
}

Plan planned(const Intrinsics& lens, std::vector<Eigen::Quaterniond> R_camera_faces) {
  Plan plan;
  plan.R_camera_faces = std::move(R_camera_faces);
  plan.boxes.resize(plan.R_camera_faces.size());
  constexpr double kStep_px = 0.5;  // to see how fine the lens draws
  for (int row = 0; row <= kGrid; ++row) {
    for (int column = 0; column <= kGrid; ++column) {
      const Vec2 px((lens.width_px - 1) * static_cast<double>(column) / kGrid,
                    (lens.height_px - 1) * static_cast<double>(row) / kGrid);
      const Vec3 d = sure_direction(lens, px);
      const std::size_t i = face_of(plan.R_camera_faces, d);
      const Vec3 d_face = plan.R_camera_faces[i].conjugate() * d;
      if (d_face.z() < std::cos(kMostFaceAngle_rad)) {
        plan.possible = false;
        return plan;
      }
      const Vec2 at = d_face.head<2>() / d_face.z();
      plan.boxes[i].add(at);
      const Vec2 inwards(px.x() > lens.cx_px ? -kStep_px : kStep_px,
                         px.y() > lens.cy_px ? -kStep_px : kStep_px);
      const Vec3 e_face = plan.R_camera_faces[i].conjugate() * sure_direction(lens, px + inwards);
      const double moved = (e_face.head<2>() / e_face.z() - at).norm();
      plan.f_px = std::max(plan.f_px, inwards.norm() / moved);
    }
  }
  for (std::size_t i = plan.boxes.size(); i-- > 0;) {
    if (plan.boxes[i].empty()) {
      plan.boxes.erase(plan.boxes.begin() + static_cast<std::ptrdiff_t>(i));
      plan.R_camera_faces.erase(plan.R_camera_faces.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  return plan;
}

/// The cheapest of one face, two or four side by side, and the sides of a cube.
Plan best_plan(const Intrinsics& lens) {
  double wide_rad = 0;  // off the axis, to the sides
  double high_rad = 0;
  for (int i = 0; i <= kGrid; ++i) {
    const double part = static_cast<double>(i) / kGrid;
    for (const Vec2& px : {Vec2(part * (lens.width_px - 1), 0.0),
                           Vec2(part * (lens.width_px - 1), lens.height_px - 1.0),
                           Vec2(0.0, part * (lens.height_px - 1)),
                           Vec2(lens.width_px - 1.0, part * (lens.height_px - 1))}) {
      const Vec3 d = sure_direction(lens, px);
      wide_rad = std::max(wide_rad, std::atan2(std::abs(d.x()), d.z()));
      high_rad = std::max(high_rad, std::asin(std::abs(d.y())));
    }
  }
  constexpr double kQuarter_rad = deg_to_rad(90);
  const double yaw = wide_rad / 2;
  const double pitch = high_rad / 2;
  const std::vector<std::vector<Eigen::Quaterniond>> layouts{
      {Eigen::Quaterniond::Identity()},
      {turned(-yaw, 0), turned(yaw, 0)},
      {turned(-yaw, -pitch), turned(yaw, -pitch), turned(-yaw, pitch), turned(yaw, pitch)},
      {turned(0, 0), turned(-kQuarter_rad, 0), turned(kQuarter_rad, 0), turned(0, -kQuarter_rad),
       turned(0, kQuarter_rad), turned(2 * kQuarter_rad, 0)}};
  Plan best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& layout : layouts) {
    Plan plan = planned(lens, layout);
    if (!plan.possible) {
      continue;
    }
    const double cost =
        plan.area() * plan.f_px * plan.f_px + kFaceCost_px * static_cast<double>(plan.boxes.size());
    if (cost < least) {
      least = cost;
      best = std::move(plan);
    }
  }
  return best;
}

}  // namespace

LensView::LensView(const Intrinsics& lens) : lens_(lens) {
  if (lens.is_pinhole()) {
    whole_.faces.push_back({lens, {}});
    return;
  }
  Plan plan = best_plan(lens);
  const std::size_t count = plan.boxes.size();
  plan.boxes.assign(count, {});
  // Where each pixel finds what it shows, now for all of them, at focal length 1.
  const bool along_rays = std::holds_alternative<Equidistant>(lens.distortion);
  std::vector<PixelSource> sources;
  sources.reserve(static_cast<std::size_t>(lens.width_px) *
                  static_cast<std::size_t>(lens.height_px));
  for (int v = 0; v < lens.height_px; ++v) {
    for (int u = 0; u < lens.width_px; ++u) {
      const Vec3 d = sure_direction(lens, Vec2(u, v));
      PixelSource source;
      source.face = face_of(plan.R_camera_faces, d);
      const Vec3 d_face = plan.R_camera_faces[source.face].conjugate() * d;
      source.at = d_face.head<2>() / d_face.z();
      source.depth_per_face_depth = (along_rays ? d.norm() : d.z()) / d_face.z();
      plan.boxes[source.face].add(source.at);
      sources.push_back(source);
    }
  }
  const double most_px2 = kMostPixels * static_cast<double>(sources.size());
  const double f_px = std::min(plan.f_px, std::sqrt(most_px2 / plan.area()));
  for (std::size_t i = 0; i < count; ++i) {
    const Vec2 low_px = (plan.boxes[i].low * f_px).array().floor();
    const Vec2 high_px = (plan.boxes[i].high * f_px).array().ceil();
    const Vec2 size_px = high_px - low_px + Vec2::Constant(2 * kMargin_px + 1);
    PinholeFaces::Face face;
    face.pinhole = {static_cast<int>(size_px.x()), static_cast<int>(size_px.y()), f_px, f_px,
                    kMargin_px - low_px.x(),       kMargin_px - low_px.y(),       {}};
    face.T_camera_face.rotation = plan.R_camera_faces[i];
    cv::Size& canvas_px = whole_.canvas_px;
    face.top_px = canvas_px.height;
    canvas_px.width = std::max(canvas_px.width, rounded_up(face.pinhole.width_px, kFaceRows));
    canvas_px.height += rounded_up(face.pinhole.height_px, kRowsTogether);
    whole_.faces.push_back(face);
  }
  PANOPTES_CHECK(std::max(whole_.canvas_px.width, whole_.canvas_px.height) <
                     std::numeric_limits<std::int16_t>::max(),
                 "OpenCV looks things up in pictures of at most so many pixels");
  make_maps(sources);
}

void LensView::make_maps(const std::vector<PixelSource>& sources) {
  const std::vector<PinholeFaces::Face>& faces = whole_.faces;
  const bool as_drawn = faces.size() == 1 && faces[0].T_camera_face.rotation.w() == 1 &&
                        !std::holds_alternative<Equidistant>(lens_.distortion);
  for (const PinholeFaces::Face& face : faces) {
    rows_of_.emplace_back(lens_.height_px, Span{face.pinhole.height_px, 0});
  }
  const cv::Size size_px(lens_.width_px, lens_.height_px);
  whole_.x_px.create(size_px, CV_32F);
  whole_.y_px.create(size_px, CV_32F);
  whole_.detail_px2.create(size_px, CV_32F);
  if (!as_drawn) {
    depth_per_face_depth_.create(size_px, CV_32F);
  }
  auto source = sources.begin();
  for (int v = 0; v < lens_.height_px; ++v) {
    for (int u = 0; u < lens_.width_px; ++u, ++source) {
      const Intrinsics& pinhole = faces[source->face].pinhole;
      const Vec2 px(pinhole.cx_px + pinhole.fx_px * source->at.x(),
                    pinhole.cy_px + pinhole.fy_px * source->at.y());
      whole_.x_px.at<float>(v, u) = static_cast<float>(px.x());
      whole_.y_px.at<float>(v, u) = static_cast<float>(px.y() + faces[source->face].top_px);
      whole_.detail_px2.at<float>(v, u) =
          static_cast<float>(covered(sources, v, u) * pinhole.fx_px * pinhole.fy_px);
      if (!as_drawn) {
        depth_per_face_depth_.at<float>(v, u) = static_cast<float>(source->depth_per_face_depth);
      }
      Span& rows = rows_of_[source->face][static_cast<std::size_t>(v)];
      rows.first = std::min(rows.first, static_cast<int>(px.y()));
      rows.end = std::max(rows.end, static_cast<int>(px.y()) + 2);
    }
  }
}

/// The area of a face's picture, at focal length 1, that a pixel of the lens covers.
double LensView::covered(const std::vector<PixelSource>& sources, int v, int u) const {
  const auto source = [&](int row, int column) -> const PixelSource& {
    return sources[static_cast<std::size_t>(row) * static_cast<std::size_t>(lens_.width_px) +
                   static_cast<std::size_t>(column)];
  };
  const PixelSource& here = source(v, u);
  const auto step = [&](int down, int right) -> Vec2 {
    for (const int sign : {-1, 1}) {
      const int row = v + sign * down;
      const int column = u + sign * right;
      if (row >= 0 && row < lens_.height_px && column >= 0 && column < lens_.width_px &&
          source(row, column).face == here.face) {
        return sign * (source(row, column).at - here.at);
      }
    }
    return {down / lens_.fy_px, right / lens_.fx_px};  // alone in its face
  };
  const Vec2 across = step(0, 1);
  const Vec2 down = step(1, 0);
  return std::abs(across.x() * down.y() - across.y() * down.x());
}

LensView::Span LensView::rows_needed(std::size_t face, int first_row, int end_row) const {
  const int height = whole_.faces[face].pinhole.height_px;
  Span needed{height, 0};
  for (int v = first_row; v < end_row; ++v) {
    const Span& rows = rows_of_[face][static_cast<std::size_t>(v)];
    needed.first = std::min(needed.first, rows.first);
    needed.end = std::max(needed.end, rows.end);
  }
  needed.first = needed.first / kRowsTogether * kRowsTogether;
  needed.end = std::min(rounded_up(needed.end, kRowsTogether), height);
  return needed;
}

/// What those rows of the picture need of the faces.
PinholeFaces LensView::part(int first_row, int end_row) const {
  const cv::Range rows(first_row, end_row);
  PinholeFaces part{{},
                    whole_.canvas_px,
                    whole_.x_px.rowRange(rows),
                    whole_.y_px.rowRange(rows),
                    whole_.detail_px2.rowRange(rows)};
  for (std::size_t i = 0; i < whole_.faces.size(); ++i) {
    const Span needed = rows_needed(i, first_row, end_row);
    if (needed.first < needed.end) {
      PinholeFaces::Face& face = part.faces.emplace_back(whole_.faces[i]);
      face.pinhole.height_px = needed.end - needed.first;
      face.pinhole.cy_px -= needed.first;
      face.top_px += needed.first;
    }
  }
  return part;
}

RenderedImage LensView::draw(const Draw& draw, const Pose3& T_scene_camera, double gain,
                             const RenderOutputs& outputs, int first_row, int end_row) const {
  View view{lens_, T_scene_camera, gain};
  view.intrinsics.height_px = end_row - first_row;
  view.intrinsics.cy_px -= first_row;
  if (lens_.is_pinhole()) {
    return draw(view, outputs);
  }
  const PinholeFaces faces = part(first_row, end_row);
  view.faces = &faces;
  RenderedImage rendered = draw(view, outputs);
  if (outputs.depth && !depth_per_face_depth_.empty()) {
    for (int v = 0; v < rendered.depth_m.rows; ++v) {
      float* depth_m = rendered.depth_m.ptr<float>(v);
      const float* factor = depth_per_face_depth_.ptr<float>(first_row + v);
      for (int u = 0; u < rendered.depth_m.cols; ++u) {
        depth_m[u] = std::isfinite(depth_m[u]) ? depth_m[u] * factor[u] : depth_m[u];
      }
    }
  }
  return rendered;
}

}  // namespace panoptes::sim
