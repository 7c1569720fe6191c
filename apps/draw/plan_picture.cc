// SPDX-License-Identifier: BSD-3-Clause
#include "apps/draw/plan_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace panoptes {
namespace {

constexpr double kMargin_m = 0.3;
constexpr double kWindow_m = 16;  // of a larger world so much is shown
constexpr int kLeft_px = 46;      // for the numbers along the sides
constexpr int kTop_px = 8;
constexpr int kRight_px = 8;
constexpr int kFoot_px = 84;
constexpr double kSeenShare = 0.16;
constexpr double kMappedShare = 0.5;
const Colour kThing{104, 110, 118};
const Colour kThingEdge{70, 75, 82};
const Colour kRobot{214, 28, 38};

struct Window {
  Vec2 low_scene;
  Vec2 high_scene;
};

// All of the world, or a part of it about the robot.
Window window_of(const PlanPicture& picture) {
  const Vec2 margin = Vec2::Constant(kMargin_m);
  Window all{picture.low_scene - margin, picture.high_scene + margin};
  const Vec2 at = picture.T_scene_body.position();
  all.low_scene = all.low_scene.cwiseMin(at - margin);
  all.high_scene = all.high_scene.cwiseMax(at + margin);
  Window shown = all;
  for (int axis = 0; axis < 2; ++axis) {
    if (all.high_scene[axis] - all.low_scene[axis] > kWindow_m) {
      const double low = std::clamp(at[axis] - kWindow_m / 2, all.low_scene[axis],
                                    all.high_scene[axis] - kWindow_m);
      shown.low_scene[axis] = low;
      shown.high_scene[axis] = low + kWindow_m;
    }
  }
  return shown;
}

cv::Vec3b mixed(const cv::Vec3b& under, const Colour& over, double share) {
  const auto mix = [share](unsigned char a, unsigned char b) {
    return static_cast<unsigned char>(std::lround((1 - share) * a + share * b));
  };
  return {mix(under[0], over.b), mix(under[1], over.g), mix(under[2], over.r)};
}

// A small overview of the objects, with a frame around what is shown.
void draw_overview(Canvas& canvas, const PlanPicture& picture, const Window& shown,
                   const Vec2& corner) {
  constexpr double kLongest_px = 150;
  const Vec2 size_m = picture.high_scene - picture.low_scene;
  const double px_per_m = kLongest_px / size_m.maxCoeff();
  const Vec2 size_px = size_m * px_per_m;
  const auto to_px = [&](const Vec2& p_scene) {
    const Vec2 inside = p_scene.cwiseMax(picture.low_scene).cwiseMin(picture.high_scene);
    return Vec2(corner.x() + (inside.x() - picture.low_scene.x()) * px_per_m,
                corner.y() + size_px.y() - (inside.y() - picture.low_scene.y()) * px_per_m);
  };
  canvas.box(corner - Vec2(5, 5), corner + size_px + Vec2(5, 5), kPaper);
  canvas.frame(corner - Vec2(5, 5), corner + size_px + Vec2(5, 5), kFaint, 1);
  for (const std::vector<Vec2>& thing : picture.outlines_scene) {
    std::vector<Vec2> px;
    for (const Vec2& corner_scene : thing) {
      px.push_back(to_px(corner_scene));
    }
    canvas.polygon(px, kThing);
  }
  const Vec2 a = to_px(shown.low_scene);
  const Vec2 b = to_px(shown.high_scene);
  canvas.frame({a.x(), b.y()}, {b.x(), a.y()}, kRobot, 1.5);
}

}  // namespace

Colour nth_colour(std::size_t n) {
  static constexpr std::array<Colour, 6> kColours{
      {{31, 98, 196}, {226, 125, 20}, {24, 150, 72}, {132, 62, 178}, {0, 148, 158}, {176, 90, 60}}};
  return kColours[n % kColours.size()];
}

cv::Mat draw_plan(const PlanPicture& picture, int size_px) {
  const Window shown = window_of(picture);
  const Vec2 size_m = shown.high_scene - shown.low_scene;
  const double px_per_m = (size_px - kLeft_px - kRight_px) / size_m.maxCoeff();
  const int width = static_cast<int>(std::lround(size_m.x() * px_per_m));
  const int height = static_cast<int>(std::lround(size_m.y() * px_per_m));
  Canvas canvas(width, height, kPaper);
  const Vec2 opposite(width, height);
  const auto to_px = [&](const Vec2& p_scene) {
    return Vec2((p_scene.x() - shown.low_scene.x()) * px_per_m,
                height - (p_scene.y() - shown.low_scene.y()) * px_per_m);
  };

  // The floor that is seen, and the part of it that is mapped.
  cv::Mat floor = canvas.fine(Vec2::Zero(), opposite);
  constexpr int kOver = Canvas::kOver;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Vec2 p_scene = shown.low_scene + Vec2(u + 0.5, height - v - 0.5) / px_per_m;
      cv::Vec3b colour(255, 255, 255);
      for (const PlanCamera& camera : picture.cameras) {
        const FloorVisibility visibility =
            camera.floor ? camera.floor(p_scene) : FloorVisibility::kNone;
        if (visibility != FloorVisibility::kNone) {
          colour = mixed(colour, camera.colour,
                         visibility == FloorVisibility::kMapped ? kMappedShare : kSeenShare);
        }
      }
      floor(cv::Rect(u * kOver, v * kOver, kOver, kOver)) = cv::Scalar(colour);
    }
  }

  const double step_m = round_step(size_m.maxCoeff(), 12);
  const auto ticks = [&](int axis, const auto& draw) {
    for (const double at : round_values(shown.low_scene[axis], shown.high_scene[axis], step_m)) {
      draw(at);
    }
  };
  ticks(0, [&](double x) {
    const double px = to_px({x, 0}).x();
    canvas.line({px, 0}, {px, opposite.y()}, kGridColour, 1);
  });
  ticks(1, [&](double y) {
    const double px = to_px({0, y}).y();
    canvas.line({0, px}, {opposite.x(), px}, kGridColour, 1);
  });

  for (const std::vector<Vec2>& thing : picture.outlines_scene) {
    std::vector<Vec2> px;
    for (const Vec2& p_scene : thing) {
      px.push_back(to_px(p_scene));
    }
    if (px.size() > 2) {
      canvas.polygon(px, kThing);
    }
    px.push_back(px.front());
    canvas.polyline(px, kThingEdge, 1);
  }

  // Each camera's view as an arc of its own radius, its name on it.
  constexpr double kFirst_m = 0.7;
  constexpr double kNext_m = 0.28;
  const double unit_m = size_m.maxCoeff() / 10;  // arcs are as big in the picture of any world
  for (std::size_t i = 0; i < picture.cameras.size(); ++i) {
    const PlanCamera& camera = picture.cameras[i];
    const double radius_m = unit_m * (kFirst_m + kNext_m * static_cast<double>(i));
    const double span_rad = camera.to_rad - camera.from_rad;
    std::vector<Vec2> outline{to_px(camera.eye_scene)};
    constexpr int kPieces = 48;
    for (int k = 0; k <= kPieces; ++k) {
      const double heading = camera.from_rad + span_rad * k / kPieces;
      outline.push_back(
          to_px(camera.eye_scene + radius_m * Vec2(std::cos(heading), std::sin(heading))));
    }
    outline.push_back(outline.front());
    canvas.polyline(outline, camera.colour, 1.75);
  }
  const double radius_px = std::max(4.0, picture.radius_m * px_per_m);
  const Vec2 at_px = to_px(picture.T_scene_body.position());
  const Vec2 ahead(std::cos(picture.T_scene_body.theta_rad),
                   -std::sin(picture.T_scene_body.theta_rad));
  canvas.ring(at_px, radius_px, kRobot, 2);
  canvas.line(at_px, at_px + radius_px * ahead, kRobot, 2.5);
  for (std::size_t i = 0; i < picture.cameras.size(); ++i) {
    const PlanCamera& camera = picture.cameras[i];
    const double radius_m = unit_m * (kFirst_m + kNext_m * static_cast<double>(i));
    const double middle = (camera.from_rad + camera.to_rad) / 2;
    const Vec2 on_arc =
        to_px(camera.eye_scene + radius_m * Vec2(std::cos(middle), std::sin(middle)));
    canvas.disc(to_px(camera.eye_scene), 3, camera.colour);
    canvas.label(camera.name, on_arc + Vec2(0, 5), camera.colour, 14, 0.5);
  }
  if (size_m.x() < picture.high_scene.x() - picture.low_scene.x() ||
      size_m.y() < picture.high_scene.y() - picture.low_scene.y()) {
    const bool robot_is_left = at_px.x() < opposite.x() / 2;
    draw_overview(canvas, picture, shown, {robot_is_left ? opposite.x() - 162 : 12.0, 12});
  }

  // Around it the metres, below it what the colours mean.
  constexpr int kNarrowest_px = 480;
  Canvas sheet(std::max(kNarrowest_px, kLeft_px + width + kRight_px), kTop_px + height + kFoot_px,
               kPaper);
  const Vec2 corner(kLeft_px, kTop_px);
  sheet.paste_over(canvas.fine(Vec2::Zero(), opposite), corner);
  sheet.frame(corner, corner + opposite, kFaint, 1);
  ticks(0, [&](double x) {
    sheet.text(short_number(x), corner + Vec2(to_px({x, 0}).x(), height + 17.0), kFaint, 13, 0.5);
  });
  ticks(1, [&](double y) {
    sheet.text(short_number(y), corner + Vec2(-7, to_px({0, y}).y() + 5), kFaint, 13, 1);
  });
  const double base = kTop_px + height + 46;
  double x = kLeft_px;
  const auto patch = [&](const std::string& name, const cv::Vec3b& colour) {
    sheet.box({x, base - 12}, {x + 22, base + 1}, {colour[2], colour[1], colour[0]});
    sheet.text(name, {x + 28, base}, kInk, 14);
    x += 28 + Canvas::text_width(name, 14) + 18;
  };
  const auto floor_camera =
      std::find_if(picture.cameras.begin(), picture.cameras.end(),
                   [](const PlanCamera& camera) { return static_cast<bool>(camera.floor); });
  patch("stands in the way", {kThing.b, kThing.g, kThing.r});
  if (floor_camera != picture.cameras.end()) {
    patch("floor seen", mixed({255, 255, 255}, floor_camera->colour, kSeenShare));
    patch("and mapped", mixed({255, 255, 255}, floor_camera->colour, kMappedShare));
  }
  sheet.scale_bar({kLeft_px + opposite.x(), base + 28}, round_step(size_m.maxCoeff() / 3, 2),
                  px_per_m);
  sheet.text("metres in scene", {kLeft_px + 0.0, base + 28}, kFaint, 13);
  return sheet.shrunk();
}

}  // namespace panoptes
