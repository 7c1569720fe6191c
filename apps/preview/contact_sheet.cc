// SPDX-License-Identifier: BSD-3-Clause
#include "apps/preview/contact_sheet.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "apps/draw/canvas.h"
#include "apps/draw/plan_picture.h"
#include "core/base/check.h"
#include "core/base/text.h"
#include "sim/sensors/floor_pixels.h"

namespace panoptes {
namespace {

constexpr int kGap_px = 16;
constexpr int kHead_px = 64;     // the title's, and a line below it
constexpr int kWords_px = 46;    // above every camera's pictures
constexpr int kCaption_px = 20;  // below a picture
constexpr int kWidest_px = 480;  // of a picture; larger ones are shrunk
constexpr int kPlan_px = 900;
const Colour kGround{244, 245, 247};
const Colour kFault{214, 28, 38};

// The direction of the last pixel before the picture's edge that has one, in the camera's frame,
// going from its middle.
Vec3 edge_direction(const Intrinsics& lens, const Vec2& edge_px) {
  const Vec2 middle_px((lens.width_px - 1) / 2.0, (lens.height_px - 1) / 2.0);
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) {
    const double share = 1 - static_cast<double>(i) / kSteps;
    if (const auto direction = lens.direction(middle_px + share * (edge_px - middle_px))) {
      return direction->normalized();
    }
  }
  return Vec3::UnitZ();
}

// How far off the axis a lens sees to both sides, together.
double view_deg(const Intrinsics& lens, const Vec2& from_px, const Vec2& to_px) {
  const auto off_axis = [&](const Vec2& px) {
    return std::acos(std::clamp(edge_direction(lens, px).z(), -1.0, 1.0));
  };
  return rad_to_deg(off_axis(from_px) + off_axis(to_px));
}

std::string words_of(const RigCamera& camera) {
  const Intrinsics& lens = camera.intrinsics;
  const double across = view_deg(lens, {-0.5, lens.cy_px}, {lens.width_px - 0.5, lens.cy_px});
  const double down = view_deg(lens, {lens.cx_px, -0.5}, {lens.cx_px, lens.height_px - 0.5});
  const Vec3 axis = camera.T_body_camera.rotation * Vec3::UnitZ();
  const double tilt = std::round(rad_to_deg(std::asin(std::clamp(-axis.z(), -1.0, 1.0)))) + 0.0;
  const std::string lens_words = std::visit(
      [](const auto& distortion) { return std::string(std::decay_t<decltype(distortion)>::kName); },
      lens.distortion);
  return fmt::format("{} x {} px, {:.0f} x {:.0f} deg{}, {:.2f} m high, tilt {:.0f} deg",
                     lens.width_px, lens.height_px, across, down,
                     lens.is_pinhole() ? "" : " " + lens_words,
                     camera.T_body_camera.translation.z(), tilt);
}

PlanCamera plan_camera(const CameraView& camera_view, const Colour& colour, const Body& body,
                       const Pose2& T_scene_body) {
  const Intrinsics& lens = camera_view.camera.intrinsics;
  PlanCamera out;
  out.name = camera_view.name;
  out.colour = colour;
  out.eye_scene = camera_view.T_scene_camera.translation.head<2>();
  const auto heading = [&](double u) {
    const Vec3 direction =
        camera_view.T_scene_camera.rotation * edge_direction(lens, {u, lens.cy_px});
    return std::atan2(direction.y(), direction.x());
  };
  const Vec3 axis = camera_view.T_scene_camera.rotation * Vec3::UnitZ();
  const double middle = std::atan2(axis.y(), axis.x());
  const auto off = [&](double of_side, bool left) {  // wide lenses look back past the side
    const double angle = wrap_angle(of_side - middle);
    return left ? (angle < 0 ? angle + 2 * M_PI : angle) : (angle > 0 ? angle - 2 * M_PI : angle);
  };
  out.from_rad = middle + off(heading(lens.width_px - 0.5), false);
  out.to_rad = middle + off(heading(-0.5), true);
  if (!camera_view.camera.floor) {
    return out;
  }
  const Pose3 T_camera_scene = camera_view.T_scene_camera.inverse();
  const Pose2 T_body_scene = T_scene_body.inverse();
  out.floor = [&camera_view, &body, T_camera_scene, T_body_scene](const Vec2& p_scene) {
    const Intrinsics& through = camera_view.camera.intrinsics;
    const Vec3 p_camera = T_camera_scene * Vec3(p_scene.x(), p_scene.y(), 0);
    if (!through.sees(p_camera)) {
      return FloorVisibility::kNone;
    }
    const Vec2 px = through.project(p_camera);
    const cv::Point at(static_cast<int>(std::lround(px.x())),
                       static_cast<int>(std::lround(px.y())));
    const cv::Mat& label = camera_view.image.floor_label;
    // A pixel that shows floor shows this very point of it: its ray meets the floor once.
    if (!cv::Rect({}, label.size()).contains(at) || label.at<std::uint8_t>(at) == 0) {
      return FloorVisibility::kNone;
    }
    return at.y >= sim::first_mapped_row(camera_view.camera) &&
                   sim::in_mapped_range(camera_view.camera, body, T_body_scene * p_scene)
               ? FloorVisibility::kMapped
               : FloorVisibility::kSeen;
  };
  return out;
}

// The pixels where the mapped part ends, in the camera's colour.
cv::Mat with_mapped_edge(const CameraView& camera_view, const Body& body, const Colour& colour) {
  cv::Mat bgr = camera_view.image.bgr.clone();
  if (!camera_view.camera.floor) {
    return bgr;
  }
  cv::Mat_<std::uint8_t> mapped(bgr.size(), std::uint8_t{0});
  for (int v = sim::first_mapped_row(camera_view.camera); v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const auto p_body = sim::floor_under(camera_view.camera, Vec2(u, v));
      mapped(v, u) = p_body && sim::in_mapped_range(camera_view.camera, body, *p_body) ? 255 : 0;
    }
  }
  cv::Mat inside;
  cv::erode(mapped, inside, cv::Mat());
  bgr.setTo(cv::Scalar(colour.b, colour.g, colour.r), mapped & ~inside);
  return bgr;
}

/// A picture of what pixels mean, and what it shows in words.
struct Shown {
  cv::Mat bgr;
  std::string caption;
};

// Near is bright and warm; equal steps of colour are equal shares of depth.
Shown shown_depth(const cv::Mat& depth_m) {
  double near_m = 1e9;
  double far_m = 0;
  for (int v = 0; v < depth_m.rows; ++v) {
    for (int u = 0; u < depth_m.cols; ++u) {
      const double d = depth_m.at<float>(v, u);
      if (std::isfinite(d) && d > 0) {
        near_m = std::min(near_m, d);
        far_m = std::max(far_m, d);
      }
    }
  }
  cv::Mat_<std::uint8_t> level(depth_m.size(), std::uint8_t{0});
  const double span = std::log(std::max(far_m / near_m, 1.001));
  for (int v = 0; v < depth_m.rows; ++v) {
    for (int u = 0; u < depth_m.cols; ++u) {
      const double d = depth_m.at<float>(v, u);
      if (std::isfinite(d) && d > 0) {
        level(v, u) =
            static_cast<std::uint8_t>(std::lround(255 - 255 * std::log(d / near_m) / span));
      }
    }
  }
  cv::Mat bgr;
  cv::applyColorMap(level, bgr, cv::COLORMAP_TURBO);
  bgr.setTo(cv::Scalar(60, 60, 60), ~(depth_m < 1e9F));
  return {bgr, far_m > 0 ? fmt::format("depth, {:.2f} to {:.1f} m", near_m, far_m)
                         : "depth: nothing is there"};
}

// Neighbouring numbers get colours far apart.
Shown shown_labels(const cv::Mat& instance, const cv::Mat& floor_label) {
  std::set<std::uint16_t> things;
  cv::Mat_<cv::Vec3b> hsv(instance.size());
  for (int v = 0; v < instance.rows; ++v) {
    for (int u = 0; u < instance.cols; ++u) {
      const auto number = instance.at<std::uint16_t>(v, u);
      const bool floor = floor_label.at<std::uint8_t>(v, u) != 0;
      things.insert(number);
      constexpr double kGolden = 0.6180339887;
      const double hue = std::fmod(number * kGolden, 1.0);
      const auto level = static_cast<std::uint8_t>(number == 0 ? 60 : floor ? 245 : 200);
      hsv(v, u) = {static_cast<std::uint8_t>(std::lround(179 * hue)),
                   static_cast<std::uint8_t>(number == 0 ? 0
                                             : floor     ? 70
                                                         : 150),
                   level};
    }
  }
  things.erase(0);
  cv::Mat bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  return {bgr, fmt::format("{} things, the floor bright", things.size())};
}

/// A camera's pictures beside one another.
struct Row {
  std::string name;
  std::string roles;
  std::string words;
  Colour colour;
  std::vector<Shown> pictures;

  int width() const {
    int sum = -kGap_px;
    for (const Shown& picture : pictures) {
      sum += picture.bgr.cols + kGap_px;
    }
    return sum;
  }
  int height() const {
    return kWords_px + pictures.front().bgr.rows + (pictures.size() > 1 ? kCaption_px : 0);
  }
};

cv::Mat fitting(const cv::Mat& bgr) {
  if (bgr.cols <= kWidest_px) {
    return bgr;
  }
  cv::Mat small;
  cv::resize(bgr, small, {kWidest_px, bgr.rows * kWidest_px / bgr.cols}, 0, 0, cv::INTER_AREA);
  return small;
}

Row row_of(const CameraView& camera_view, const Body& body, const Colour& colour) {
  Row row{
      camera_view.name, joined(camera_view.camera.roles), words_of(camera_view.camera), colour, {}};
  const bool alone = camera_view.image.depth_m.empty() && camera_view.image.instance.empty();
  row.pictures.push_back({fitting(with_mapped_edge(camera_view, body, colour)),
                          alone                      ? ""
                          : camera_view.camera.floor ? "the mapped part framed"
                                                     : ""});
  if (!camera_view.image.depth_m.empty()) {
    const Shown depth = shown_depth(camera_view.image.depth_m);
    row.pictures.push_back({fitting(depth.bgr), depth.caption});
  }
  if (!camera_view.image.instance.empty()) {
    const Shown labels = shown_labels(camera_view.image.instance, camera_view.image.floor_label);
    row.pictures.push_back({fitting(labels.bgr), labels.caption});
  }
  return row;
}

void draw_row(Canvas& canvas, const Row& row, int left, int top) {
  const double x = left;
  canvas.disc({x + 6, top + 12.0}, 6, row.colour);
  canvas.text(row.name, {x + 19, top + 18.0}, kInk, 18);
  canvas.text(row.roles, {x + 19 + Canvas::text_width(row.name, 18) + 12, top + 18.0}, kFaint, 14);
  canvas.text(row.words, {x, top + 38.0}, kFaint, 13);
  int at = left;
  for (const Shown& picture : row.pictures) {
    canvas.paste(picture.bgr, {static_cast<double>(at), static_cast<double>(top + kWords_px)});
    canvas.text(picture.caption,
                {static_cast<double>(at), top + kWords_px + picture.bgr.rows + 15.0}, kFaint, 13);
    at += picture.bgr.cols + kGap_px;
  }
}

}  // namespace

cv::Mat contact_sheet(const ExploreMission& mission, const Pose2& T_scene_body, double at_s,
                      const CameraPreview::Views& views) {
  PlanPicture plan;
  plan.outlines_scene = views.outlines_scene;
  plan.T_scene_body = T_scene_body;
  plan.radius_m = mission.robot.radius_m;
  plan.low_scene = views.low_scene;
  plan.high_scene = views.high_scene;
  std::vector<Row> rows;
  for (const CameraView& camera_view : views.cameras) {
    const Colour colour = nth_colour(rows.size());
    rows.push_back(row_of(camera_view, mission.robot, colour));
    plan.cameras.push_back(plan_camera(camera_view, colour, mission.robot, T_scene_body));
  }
  const cv::Mat plan_bgr = draw_plan(plan, kPlan_px);

  // Columns of cameras about as high as the plan, and at least one camera each.
  struct Placed {
    int left;
    int top;
  };
  std::vector<Placed> places;
  int left = kGap_px;
  int top = kHead_px;
  int column_px = 0;
  int bottom = kHead_px + plan_bgr.rows;
  for (const Row& row : rows) {
    constexpr double kTaller = 1.2;  // than the plan, rather than one column more
    if (top > kHead_px && top + row.height() > kHead_px + kTaller * plan_bgr.rows) {
      left += column_px + kGap_px;
      top = kHead_px;
      column_px = 0;
    }
    places.push_back({left, top});
    constexpr double kWords_size_px = 13;
    column_px = std::max({column_px, row.width(),
                          static_cast<int>(Canvas::text_width(row.words, kWords_size_px)) + 1});
    top += row.height() + kGap_px;
    bottom = std::max(bottom, top - kGap_px);
  }
  const int plan_left = left + column_px + kGap_px;
  Canvas canvas(plan_left + plan_bgr.cols + kGap_px, bottom + kGap_px, kGround);
  const std::string title =
      fmt::format("{}: what the cameras see from ({}, {}) m, heading {} deg{}", mission.name,
                  short_number(T_scene_body.x_m), short_number(T_scene_body.y_m),
                  short_number(std::round(1e3 * rad_to_deg(T_scene_body.theta_rad)) / 1e3),
                  at_s > 0 ? ", at " + short_number(at_s) + " s" : "");
  canvas.text(title, {kGap_px, 30}, kInk, 20);
  const std::string below = views.fault.empty() ? fmt::format("{:.2f} m clear around the body",
                                                              views.clearance_m.value_or(0))
                                                : "no robot can stand here: it " + views.fault;
  canvas.text(below, {kGap_px, 52}, views.fault.empty() ? kFaint : kFault, 15);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    draw_row(canvas, rows[i], places[i].left, places[i].top);
  }
  canvas.paste(plan_bgr, {static_cast<double>(plan_left), static_cast<double>(kHead_px)});
  return canvas.shrunk();
}

}  // namespace panoptes
