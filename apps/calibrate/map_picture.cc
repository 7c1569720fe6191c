// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/map_picture.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/calibrate/drawn_ellipse.h"
#include "apps/calibrate/picture_pane.h"
#include "apps/draw/canvas.h"
#include "apps/draw/pictures.h"
#include "core/base/text.h"
#include "core/base/time.h"
#include "core/eval/statistics.h"

namespace panoptes {
namespace {

constexpr double kMargin = 20;
constexpr double kTitle = 46;
constexpr double kLegend = 40;
constexpr Colour kFoundColour{255, 214, 10};

/// A sheet with one of the camera's pictures, a title over it and room for a legend under it.
struct PictureSheet {
  static constexpr double kWidth = 960;

  PictureSheet(const cv::Mat& grey, const std::string& title)
      : height(PicturePane::height_of(grey.cols, grey.rows, kWidth)),
        canvas(static_cast<int>(kWidth + 2 * kMargin),
               static_cast<int>(height + kTitle + kLegend + kMargin), kPaper),
        pane(canvas, grey, corner, kWidth) {
    canvas.text(title, {kMargin, 30}, kInk, 18);
  }

  Vec2 at(const Vec2& px) const { return pane.at(px); }
  double legend_y() const { return kTitle + height + 26; }

  Vec2 corner{kMargin, kTitle};
  double height;
  Canvas canvas;
  PicturePane pane;
};

Vec2 from_above(const Vec3& p_map) { return {p_map.x(), p_map.z()}; }

/// In parts, where it was lost between them.
std::vector<std::vector<Vec2>> path_of(const MonoMap& map) {
  std::vector<std::vector<Vec2>> parts;
  bool was_lost = true;
  for (const MonoMap::Frame& frame : map.frames) {
    if (!frame.lost) {
      if (was_lost) {
        parts.emplace_back();
      }
      parts.back().push_back(from_above(frame.T_map_camera.translation));
    }
    was_lost = frame.lost;
  }
  return parts;
}

/// Half the side of what nine tenths of the points and all of the path lie in.
double reach_of(const MonoMap& map) {
  std::vector<double> reach;
  for (const MonoMap::Point& point : map.points) {
    reach.push_back(from_above(point.p_map).norm());
  }
  double half = reach.empty() ? 1 : quantile(reach, 0.9);
  for (const std::vector<Vec2>& part : path_of(map)) {
    for (const Vec2& p : part) {
      half = std::max(half, p.norm());
    }
  }
  return 1.1 * half;
}

/// A map from above on a square of the canvas, its first camera in the middle.
class Plan {
 public:
  Plan(Canvas& canvas, const Vec2& low, double side, double half_m)
      : canvas_(canvas), low_(low), side_(side), half_m_(half_m) {}

  /// Returns the side of one, map metres.
  double draw_squares() {
    const double step = round_step(2 * half_m_, 10);
    for (const double value : round_values(-half_m_, half_m_, step)) {
      canvas_.line(at({value, -half_m_}), at({value, half_m_}), kGridColour, 1);
      canvas_.line(at({-half_m_, value}), at({half_m_, value}), kGridColour, 1);
    }
    return step;
  }

  void draw_points(const MonoMap& map) {
    for (const MonoMap::Point& point : map.points) {
      const Vec2 p = from_above(point.p_map);
      if (!is_shown(p)) {
        continue;
      }
      Mat2 covariance;
      covariance << point.covariance(0, 0), point.covariance(0, 2), point.covariance(2, 0),
          point.covariance(2, 2);
      std::vector<Vec2> line = drawn_ellipse(p, covariance, 3);
      std::erase_if(line, [this](const Vec2& corner) { return !is_shown(corner); });
      std::transform(line.begin(), line.end(), line.begin(),
                     [this](const Vec2& q) { return at(q); });
      canvas_.polyline(line, kFaint, 1);
      canvas_.disc(at(p), 2.5, kInk);
    }
  }

  void draw_path(std::vector<std::vector<Vec2>> parts, const Colour& colour) {
    for (std::vector<Vec2>& line : parts) {
      std::transform(line.begin(), line.end(), line.begin(),
                     [this](const Vec2& p) { return at(p); });
      canvas_.polyline(line, colour, 2);
    }
    if (!parts.empty()) {
      canvas_.ring(parts.front().front(), 6, colour, 2);
    }
  }

  void draw_frame() { canvas_.frame(low_, low_ + Vec2::Constant(side_), kFaint, 1); }

 private:
  Vec2 at(const Vec2& p) const {
    return low_ + Vec2::Constant(side_ / 2) + side_ / (2 * half_m_) * Vec2(p.x(), -p.y());
  }
  bool is_shown(const Vec2& p) const { return p.cwiseAbs().maxCoeff() < half_m_; }

  Canvas& canvas_;
  Vec2 low_;
  double side_;
  double half_m_;
};

void draw_legend(Canvas& canvas, double y) {
  canvas.disc({kMargin + 6, y - 5}, 2.5, kInk);
  canvas.text("point, 3 sigma", {kMargin + 16, y}, kInk);
  canvas.line({kMargin + 150, y - 5}, {kMargin + 170, y - 5}, kEstimateColour, 2);
  canvas.text("camera, from the ring on", {kMargin + 178, y}, kInk);
}

}  // namespace

cv::Mat draw_search(const CameraMap& told) {
  const LookedAt& looked = told.looked_at;
  const auto inliers = std::count_if(looked.step.sought.begin(), looked.step.sought.end(),
                                     [](const PointSought& sought) { return sought.inlier; });
  PictureSheet sheet(looked.grey,
                     fmt::format("{}: {} points expected here, {} found where the others agree",
                                 told.camera, looked.step.sought.size(), inliers));
  Canvas& canvas = sheet.canvas;
  const Vec2& corner = sheet.corner;
  const double height = sheet.height;
  constexpr double kWidth = PictureSheet::kWidth;
  const auto at = [&sheet](const Vec2& px) { return sheet.at(px); };
  for (int column = 1; column < looked.columns; ++column) {
    const double x = corner.x() + column * kWidth / looked.columns;
    canvas.line({x, corner.y()}, {x, corner.y() + height}, kGridColour, 1);
  }
  for (int row = 1; row < looked.rows; ++row) {
    const double y = corner.y() + row * height / looked.rows;
    canvas.line({corner.x(), y}, {corner.x() + kWidth, y}, kGridColour, 1);
  }
  for (const PointSought& sought : looked.step.sought) {
    const Mat2 covariance = sought.expected.covariance_px2 + looked.step.match_sigma_px *
                                                                 looked.step.match_sigma_px *
                                                                 Mat2::Identity();
    std::vector<Vec2> line = drawn_ellipse(sought.expected.px, covariance, looked.search_sigmas);
    std::transform(line.begin(), line.end(), line.begin(), at);
    canvas.polyline(line, sought.inlier ? kEstimateColour : kWrongColour, 1.5);
    if (sought.found_px) {
      canvas.cross(at(*sought.found_px), 4, sought.inlier ? kFoundColour : kWrongColour, 1.5);
    }
  }
  for (const PointMatch& added : looked.step.added) {
    canvas.ring(at(added.px), 7, kTruthColour, 2);
  }
  const double y = sheet.legend_y();
  canvas.line({kMargin, y - 5}, {kMargin + 20, y - 5}, kEstimateColour, 2);
  canvas.text(fmt::format("sought within {:g} sigma", looked.search_sigmas), {kMargin + 28, y},
              kInk);
  canvas.cross({kMargin + 228, y - 5}, 4, kFoundColour, 2);
  canvas.text("found", {kMargin + 240, y}, kInk);
  canvas.line({kMargin + 310, y - 5}, {kMargin + 330, y - 5}, kWrongColour, 2);
  canvas.text("not found, or not believed", {kMargin + 338, y}, kInk);
  canvas.ring({kMargin + 566, y - 5}, 6, kTruthColour, 2);
  canvas.text("new", {kMargin + 580, y}, kInk);
  return canvas.shrunk();
}

cv::Mat draw_reprojection(const CameraMap& told) {
  constexpr double kEnlarged = 10;
  const AdjustedMap& adjusted = told.adjusted;
  const int frame = adjusted.keyframes[told.keyframe_shown];
  PictureSheet sheet(told.keyframe_grey,
                     fmt::format("{}: {} keyframes, reprojection {:.2f} px before and {:.2f} px "
                                 "after adjustment",
                                 told.camera, adjusted.keyframes.size(), adjusted.rms_before_px,
                                 adjusted.rms_after_px));
  Canvas& canvas = sheet.canvas;
  const auto at = [&sheet](const Vec2& px) { return sheet.at(px); };
  const auto draw_off = [&](const Vec2& seen_px, const Intrinsics& lens, const Pose3& T_map_camera,
                            const Vec3& p_map, const Colour& colour) {
    const Vec3 p = T_map_camera.inverse() * p_map;
    if (lens.sees(p)) {
      const Vec2 off_px = kEnlarged * (lens.project(p) - seen_px);
      const double most_px = 0.1 * told.lens.width_px;  // of a line on the picture
      const double length = off_px.norm();
      canvas.line(at(seen_px), at(seen_px + off_px * std::min(1.0, most_px / (length + 1e-9))),
                  colour, 2);
    }
  };
  const Pose3& T_before = told.map.frames[static_cast<std::size_t>(frame)].T_map_camera;
  const Pose3& T_after = adjusted.T_map_camera[told.keyframe_shown];
  for (const AdjustedMap::Point& point : adjusted.points) {
    const auto in_map =
        std::find_if(told.map.points.begin(), told.map.points.end(),
                     [&point](const MonoMap::Point& p) { return p.number == point.number; });
    for (const MonoMap::Seen& seen : in_map->seen) {
      if (seen.frame == frame) {
        draw_off(seen.px, told.map.lens, T_before, in_map->p_map, kWrongColour);
        draw_off(seen.px, adjusted.lens, T_after, point.p_map, kTruthColour);
        canvas.ring(at(seen.px), 4, kFoundColour, 1.5);
      }
    }
  }
  const double y = sheet.legend_y();
  canvas.ring({kMargin + 8, y - 5}, 4, kFoundColour, 2);
  canvas.text("seen", {kMargin + 20, y}, kInk);
  canvas.line({kMargin + 90, y - 5}, {kMargin + 110, y - 5}, kWrongColour, 2);
  canvas.text(fmt::format("off before, {:g} times", kEnlarged), {kMargin + 118, y}, kInk);
  canvas.line({kMargin + 320, y - 5}, {kMargin + 340, y - 5}, kTruthColour, 2);
  canvas.text("off after", {kMargin + 348, y}, kInk);
  return canvas.shrunk();
}

cv::Mat draw_camera_map(const CameraMap& told) {
  constexpr double kSide = 860;
  const MonoMap& map = told.map;
  std::vector<Vec2> true_path;
  for (std::size_t i = 0; told.errors && i < map.frames.size(); ++i) {
    const Vec3 start = map.frames.front().T_map_camera.translation;
    true_path.push_back(
        from_above(start + (told.errors->true_map[i] - start) / told.errors->scale));
  }
  Canvas canvas(static_cast<int>(kSide + 2 * kMargin),
                static_cast<int>(kSide + kTitle + kLegend + kMargin), kPaper);
  Plan plan(canvas, {kMargin, kTitle}, kSide, reach_of(map));
  const double square = plan.draw_squares();
  plan.draw_points(map);
  if (told.errors) {
    plan.draw_path({true_path}, kTruthColour);
  }
  plan.draw_path(path_of(map), kEstimateColour);
  plan.draw_frame();
  canvas.text(fmt::format("{}: {}, {}{}", told.camera, counted(map.points.size(), "point"),
                          counted(map.frames.size(), "picture"),
                          map.closed ? "" : "; not closed all round"),
              {kMargin, 30}, kInk, 18);
  const double y = kTitle + kSide + 26;
  draw_legend(canvas, y);
  if (told.errors) {
    canvas.line({kMargin + 396, y - 5}, {kMargin + 416, y - 5}, kTruthColour, 2);
    canvas.text("truth, scaled", {kMargin + 424, y}, kInk);
  }
  canvas.text(fmt::format("a square: {} map metres", short_number(square)), {kMargin + kSide, y},
              kInk, 15, 1);
  return canvas.shrunk();
}

cv::Mat draw_growth(const CameraMap& told) {
  constexpr double kSide = 460;
  constexpr int kAcross = 2;
  const auto count = static_cast<int>(told.growth.size());
  const int down = (count + kAcross - 1) / kAcross;
  const double step = kSide + kMargin;
  Canvas canvas(static_cast<int>(kAcross * step + kMargin),
                static_cast<int>(down * (step + kLegend) + kTitle + kLegend), kPaper);
  canvas.text(fmt::format("{}: its map as it grew", told.camera), {kMargin, 30}, kInk, 18);
  double half = 0;  // one scale for all
  for (const MonoMap& map : told.growth) {
    half = std::max(half, reach_of(map));
  }
  for (int i = 0; i < count; ++i) {
    const MonoMap& map = told.growth[static_cast<std::size_t>(i)];
    const Vec2 low(kMargin + (i % kAcross) * step,
                   kTitle + kLegend - kMargin + (i / kAcross) * (step + kLegend));
    Plan plan(canvas, low, kSide, half);
    plan.draw_squares();
    plan.draw_points(map);
    plan.draw_path(path_of(map), kEstimateColour);
    plan.draw_frame();
    const double t_s =
        map.frames.empty() ? 0 : to_seconds(map.frames.back().stamp - told.growth_from);
    canvas.text(fmt::format("{:.0f} s: {}{}", t_s, counted(map.points.size(), "point"),
                            map.closed ? ", closed all round" : ""),
                low - Vec2(0, 8), kInk);
  }
  draw_legend(canvas, kTitle + down * (step + kLegend) + 20);
  return canvas.shrunk();
}

}  // namespace panoptes
