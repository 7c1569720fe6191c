// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/lens_view.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/base/check.h"

namespace panoptes::sim {
namespace {

// The pinholes together draw at most so many pixels for each one of the picture; the middle of the
// picture is drawn a little coarser where that does not do. It keeps a lens below 1.5 times the
// time of a plain picture.
constexpr double kMostPixels = 1.25;
// What one more face costs besides its pixels: as much as so many of them.
constexpr double kFaceCost_px = 25'000;
// No face draws what is farther off its axis.
constexpr double kMostFaceAngle_rad = deg_to_rad(72);
// Directions are looked at on a grid this fine to choose the faces.
constexpr int kGrid = 64;
constexpr int kMargin_px = 2;  // for interpolation, and for what lies between points of the grid
constexpr int kRowsTogether = 16;  // parts of faces come in few different heights

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

/// A way to see with several pinholes of one focal length what the lens sees.
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
  const std::vector<std::vector<Eigen::Quaterniond>> ways{
      {Eigen::Quaterniond::Identity()},
      {turned(-yaw, 0), turned(yaw, 0)},
      {turned(-yaw, -pitch), turned(yaw, -pitch), turned(-yaw, pitch), turned(yaw, pitch)},
      {turned(0, 0), turned(-kQuarter_rad, 0), turned(kQuarter_rad, 0), turned(0, -kQuarter_rad),
       turned(0, kQuarter_rad), turned(2 * kQuarter_rad, 0)}};
  Plan best;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& way : ways) {
    Plan plan = planned(lens, way);
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

void paste(const cv::Mat& part, const cv::Size& canvas_size, int row, cv::Mat& canvas) {
  canvas.create(canvas_size, part.type());
  part.copyTo(canvas(cv::Rect(0, row, part.cols, part.rows)));
}

}  // namespace

LensView::LensView(const Intrinsics& lens) : lens_(lens) {
  if (lens.is_pinhole()) {
    faces_.push_back({lens, {}});
    canvas_size_ = {lens.width_px, lens.height_px};
    return;
  }
  Plan plan = best_plan(lens);
  const std::size_t count = plan.boxes.size();
  plan.boxes.assign(count, {});
  // Where each pixel finds what it shows, now for all of them, at focal length 1.
  std::vector<Sight> sights;
  sights.reserve(static_cast<std::size_t>(lens.width_px) *
                 static_cast<std::size_t>(lens.height_px));
  for (int v = 0; v < lens.height_px; ++v) {
    for (int u = 0; u < lens.width_px; ++u) {
      const Vec3 d = sure_direction(lens, Vec2(u, v));
      Sight sight;
      sight.face = face_of(plan.R_camera_faces, d);
      const Vec3 d_face = plan.R_camera_faces[sight.face].conjugate() * d;
      sight.at = d_face.head<2>() / d_face.z();
      sight.axis_per_face_depth = d.z() / d_face.z();
      plan.boxes[sight.face].add(sight.at);
      sights.push_back(sight);
    }
  }
  const double most_px2 = kMostPixels * static_cast<double>(sights.size());
  const double f_px = std::min(plan.f_px, std::sqrt(most_px2 / plan.area()));
  for (std::size_t i = 0; i < count; ++i) {
    const Vec2 low_px = (plan.boxes[i].low * f_px).array().floor();
    const Vec2 high_px = (plan.boxes[i].high * f_px).array().ceil();
    const Vec2 size_px = high_px - low_px + Vec2::Constant(2 * kMargin_px + 1);
    Face face;
    face.pinhole = {static_cast<int>(size_px.x()), static_cast<int>(size_px.y()), f_px, f_px,
                    kMargin_px - low_px.x(),       kMargin_px - low_px.y(),       {}};
    face.T_camera_face.rotation = plan.R_camera_faces[i];
    tile_top_.push_back(canvas_size_.height);
    canvas_size_.width = std::max(canvas_size_.width, face.pinhole.width_px);
    canvas_size_.height += face.pinhole.height_px;
    faces_.push_back(face);
  }
  PANOPTES_CHECK(
      std::max(canvas_size_.width, canvas_size_.height) < std::numeric_limits<std::int16_t>::max(),
      "fixed-point maps reach over the whole canvas");
  make_maps(sights);
}

void LensView::make_maps(const std::vector<Sight>& sights) {
  const bool along_axis = faces_.size() == 1 && faces_[0].T_camera_face.rotation.w() == 1;
  for (const Face& face : faces_) {
    rows_of_.emplace_back(lens_.height_px, Span{face.pinhole.height_px, 0});
  }
  cv::Mat at_px(lens_.height_px, lens_.width_px, CV_32FC2);
  if (!along_axis) {
    axis_per_face_depth_.create(lens_.height_px, lens_.width_px, CV_32F);
  }
  auto sight = sights.begin();
  for (int v = 0; v < lens_.height_px; ++v) {
    for (int u = 0; u < lens_.width_px; ++u, ++sight) {
      const std::size_t i = sight->face;
      const Intrinsics& pinhole = faces_[i].pinhole;
      const Vec2 px(pinhole.cx_px + pinhole.fx_px * sight->at.x(),
                    pinhole.cy_px + pinhole.fy_px * sight->at.y());
      at_px.at<cv::Vec2f>(v, u) = {static_cast<float>(px.x()),
                                   static_cast<float>(px.y() + tile_top_[i])};
      if (!along_axis) {
        axis_per_face_depth_.at<float>(v, u) = static_cast<float>(sight->axis_per_face_depth);
      }
      Span& rows = rows_of_[i][static_cast<std::size_t>(v)];
      rows.first = std::min(rows.first, static_cast<int>(px.y()));
      rows.end = std::max(rows.end, static_cast<int>(px.y()) + 2);
    }
  }
  cv::convertMaps(at_px, cv::noArray(), whole_px_, part_px_, CV_16SC2);
  cv::Mat unused;
  cv::convertMaps(at_px, cv::noArray(), nearest_px_, unused, CV_16SC2, true);
}

LensView::Span LensView::rows_needed(std::size_t face, int first_row, int end_row) const {
  const int height = faces_[face].pinhole.height_px;
  if (lens_.is_pinhole()) {
    return {first_row, end_row};
  }
  Span needed{height, 0};
  for (int v = first_row; v < end_row; ++v) {
    const Span& rows = rows_of_[face][static_cast<std::size_t>(v)];
    needed.first = std::min(needed.first, rows.first);
    needed.end = std::max(needed.end, rows.end);
  }
  needed.first = needed.first / kRowsTogether * kRowsTogether;
  needed.end = std::min((needed.end + kRowsTogether - 1) / kRowsTogether * kRowsTogether, height);
  return needed;
}

Drawn LensView::draw(const Draw& draw, const Pose3& T_scene_camera, double gain, const Ask& ask,
                     int first_row, int end_row) {
  Drawn last;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const Span rows = rows_needed(i, first_row, end_row);
    if (rows.first >= rows.end) {
      continue;
    }
    View view;
    view.intrinsics = faces_[i].pinhole;
    view.intrinsics.height_px = rows.end - rows.first;
    view.intrinsics.cy_px -= rows.first;
    view.T_scene_camera = T_scene_camera * faces_[i].T_camera_face;
    view.gain = gain;
    last = draw(view, ask);
    if (lens_.is_pinhole()) {
      return last;
    }
    if (last.bgr.size() == canvas_size_) {
      canvas_ = last;
      continue;
    }
    const int row = tile_top_[i] + rows.first;
    paste(last.bgr, canvas_size_, row, canvas_.bgr);
    if (ask.floor_label) {
      paste(last.floor_label, canvas_size_, row, canvas_.floor_label);
    }
    if (ask.depth) {
      paste(last.depth_m, canvas_size_, row, canvas_.depth_m);
    }
    if (ask.instance) {
      paste(last.instance, canvas_size_, row, canvas_.instance);
    }
  }
  const cv::Range rows(first_row, end_row);
  Drawn out;
  cv::remap(canvas_.bgr, out.bgr, whole_px_.rowRange(rows), part_px_.rowRange(rows),
            cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  const auto nearest = [&](const cv::Mat& canvas, cv::Mat& picture) {
    cv::remap(canvas, picture, nearest_px_.rowRange(rows), cv::noArray(), cv::INTER_NEAREST,
              cv::BORDER_REPLICATE);
  };
  if (ask.floor_label) {
    nearest(canvas_.floor_label, out.floor_label);
  }
  if (ask.instance) {
    nearest(canvas_.instance, out.instance);
  }
  if (ask.depth) {
    nearest(canvas_.depth_m, out.depth_m);
    if (!axis_per_face_depth_.empty()) {
      for (int v = 0; v < out.depth_m.rows; ++v) {
        float* depth_m = out.depth_m.ptr<float>(v);
        const float* factor = axis_per_face_depth_.ptr<float>(first_row + v);
        for (int u = 0; u < out.depth_m.cols; ++u) {
          depth_m[u] = std::isfinite(depth_m[u]) ? depth_m[u] * factor[u] : depth_m[u];
        }
      }
    }
  }
  return out;
}

}  // namespace panoptes::sim
