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

// The part of the picture that shows the world, and how its metres fall on its pixels.
struct Plan {
  Plan(const PlanPicture& of, int size_px) : picture(of), shown(window_of(of)) {
    size_m = shown.high_scene - shown.low_scene;
    px_per_m = (size_px - kLeft_px - kRight_px) / size_m.maxCoeff();
    width = static_cast<int>(std::lround(size_m.x() * px_per_m));
    height = static_cast<int>(std::lround(size_m.y() * px_per_m));
    step_m = round_step(size_m.maxCoeff(), 12);
  }

  Vec2 to_px(const Vec2& p_scene) const {
    return {(p_scene.x() - shown.low_scene.x()) * px_per_m,
            height - (p_scene.y() - shown.low_scene.y()) * px_per_m};
  }
  Vec2 to_scene(int u, int v) const {
    return shown.low_scene + Vec2(u + 0.5, height - v - 0.5) / px_per_m;
  }
  Vec2 opposite() const { return Vec2(width, height); }

  bool is_whole() const {
    return size_m.x() >= picture.high_scene.x() - picture.low_scene.x() &&
           size_m.y() >= picture.high_scene.y() - picture.low_scene.y();
  }
  // Where lines of the grid cross an axis.
  std::vector<double> ticks(int axis) const {
    return round_values(shown.low_scene[axis], shown.high_scene[axis], step_m);
  }
  // Of the arc that shows the n-th camera's view: as big in the picture of any world.
  double arc_radius_m(std::size_t n) const {
    constexpr double kFirst_m = 0.7;
    constexpr double kNext_m = 0.28;
    return size_m.maxCoeff() / 10 * (kFirst_m + kNext_m * static_cast<double>(n));
  }

  const PlanPicture& picture;
  Window shown;
  Vec2 size_m = Vec2::Zero();
  double px_per_m = 0;
  int width = 0;
  int height = 0;
  double step_m = 0;
};

cv::Vec3b floor_colour(const PlanPicture& picture, const Vec2& p_scene) {
  cv::Vec3b colour(255, 255, 255);
  for (const PlanCamera& camera : picture.cameras) {
    const FloorVisibility visibility =
        camera.floor ? camera.floor(p_scene) : FloorVisibility::kNone;
    if (visibility != FloorVisibility::kNone) {
      colour = mixed(colour, camera.colour,
                     visibility == FloorVisibility::kMapped ? kMappedShare : kSeenShare);
    }
  }
  return colour;
}

// The floor that is seen, and the part of it that is mapped.
void draw_floor(Canvas& canvas, const Plan& plan) {
  cv::Mat floor = canvas.fine(Vec2::Zero(), plan.opposite());
  constexpr int kOver = Canvas::kOver;
  for (int v = 0; v < plan.height; ++v) {
    for (int u = 0; u < plan.width; ++u) {
      floor(cv::Rect(u * kOver, v * kOver, kOver, kOver)) =
          cv::Scalar(floor_colour(plan.picture, plan.to_scene(u, v)));
    }
  }
}

void draw_grid(Canvas& canvas, const Plan& plan) {
  for (const double x : plan.ticks(0)) {
    const double px = plan.to_px({x, 0}).x();
    canvas.line({px, 0}, {px, plan.opposite().y()}, kGridColour, 1);
  }
  for (const double y : plan.ticks(1)) {
    const double px = plan.to_px({0, y}).y();
    canvas.line({0, px}, {plan.opposite().x(), px}, kGridColour, 1);
  }
}

void draw_outlines(Canvas& canvas, const Plan& plan) {
  for (const std::vector<Vec2>& thing : plan.picture.outlines_scene) {
    std::vector<Vec2> px;
    for (const Vec2& p_scene : thing) {
      px.push_back(plan.to_px(p_scene));
    }
    if (px.size() > 2) {
      canvas.polygon(px, kThing);
    }
    px.push_back(px.front());
    canvas.polyline(px, kThingEdge, 1);
  }
}

// Each camera's view as an arc of its own radius.
void draw_views(Canvas& canvas, const Plan& plan) {
  for (std::size_t i = 0; i < plan.picture.cameras.size(); ++i) {
    const PlanCamera& camera = plan.picture.cameras[i];
    const double radius_m = plan.arc_radius_m(i);
    const double span_rad = camera.to_rad - camera.from_rad;
    std::vector<Vec2> outline{plan.to_px(camera.eye_scene)};
    constexpr int kPieces = 48;
    for (int k = 0; k <= kPieces; ++k) {
      const double heading = camera.from_rad + span_rad * k / kPieces;
      outline.push_back(
          plan.to_px(camera.eye_scene + radius_m * Vec2(std::cos(heading), std::sin(heading))));
    }
    outline.push_back(outline.front());
    canvas.polyline(outline, camera.colour, 1.75);
  }
}

void draw_robot(Canvas& canvas, const Plan& plan) {
  const Pose2& T_scene_body = plan.picture.T_scene_body;
  const double radius_px = std::max(4.0, plan.picture.radius_m * plan.px_per_m);
  const Vec2 at_px = plan.to_px(T_scene_body.position());
  const Vec2 ahead(std::cos(T_scene_body.theta_rad), -std::sin(T_scene_body.theta_rad));
  canvas.ring(at_px, radius_px, kRobot, 2);
  canvas.line(at_px, at_px + radius_px * ahead, kRobot, 2.5);
}

// The cameras themselves, and the name of each on the arc of its view.
void draw_cameras(Canvas& canvas, const Plan& plan) {
  for (std::size_t i = 0; i < plan.picture.cameras.size(); ++i) {
    const PlanCamera& camera = plan.picture.cameras[i];
    const double radius_m = plan.arc_radius_m(i);
    const double middle = (camera.from_rad + camera.to_rad) / 2;
    const Vec2 on_arc =
        plan.to_px(camera.eye_scene + radius_m * Vec2(std::cos(middle), std::sin(middle)));
    canvas.disc(plan.to_px(camera.eye_scene), 3, camera.colour);
    canvas.label(camera.name, on_arc + Vec2(0, 5), camera.colour, 14, 0.5);
  }
}

// A small overview of the objects, on the side where the robot is not, with a frame around what is
// shown.
void draw_overview(Canvas& canvas, const Plan& plan) {
  constexpr double kLongest_px = 150;
  constexpr double kMargin_px = 12;
  const PlanPicture& picture = plan.picture;
  const bool robot_is_left =
      plan.to_px(picture.T_scene_body.position()).x() < plan.opposite().x() / 2;
  const Vec2 corner(robot_is_left ? plan.opposite().x() - kLongest_px - kMargin_px : kMargin_px,
                    kMargin_px);
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
  const Vec2 a = to_px(plan.shown.low_scene);
  const Vec2 b = to_px(plan.shown.high_scene);
  canvas.frame({a.x(), b.y()}, {b.x(), a.y()}, kRobot, 1.5);
}

// Around it the metres.
void draw_axes(Canvas& sheet, const Plan& plan, const Vec2& corner) {
  sheet.frame(corner, corner + plan.opposite(), kFaint, 1);
  for (const double x : plan.ticks(0)) {
    sheet.text(short_number(x), corner + Vec2(plan.to_px({x, 0}).x(), plan.height + 17.0), kFaint,
               13, 0.5);
  }
  for (const double y : plan.ticks(1)) {
    sheet.text(short_number(y), corner + Vec2(-7, plan.to_px({0, y}).y() + 5), kFaint, 13, 1);
  }
}

// Below it what the colours mean, and a scale.
void draw_legend(Canvas& sheet, const Plan& plan) {
  const double base = kTop_px + plan.height + 46;
  double x = kLeft_px;
  const auto patch = [&](const std::string& name, const cv::Vec3b& colour) {
    sheet.box({x, base - 12}, {x + 22, base + 1}, {colour[2], colour[1], colour[0]});
    sheet.text(name, {x + 28, base}, kInk, 14);
    x += 28 + Canvas::text_width(name, 14) + 18;
  };
  const std::vector<PlanCamera>& cameras = plan.picture.cameras;
  const auto floor_camera =
      std::find_if(cameras.begin(), cameras.end(),
                   [](const PlanCamera& camera) { return static_cast<bool>(camera.floor); });
  patch("stands in the way", {kThing.b, kThing.g, kThing.r});
  if (floor_camera != cameras.end()) {
    patch("floor seen", mixed({255, 255, 255}, floor_camera->colour, kSeenShare));
    patch("and mapped", mixed({255, 255, 255}, floor_camera->colour, kMappedShare));
  }
  sheet.scale_bar({kLeft_px + plan.opposite().x(), base + 28},
                  round_step(plan.size_m.maxCoeff() / 3, 2), plan.px_per_m);
  sheet.text("metres in scene", {kLeft_px + 0.0, base + 28}, kFaint, 13);
}

}  // namespace

Colour nth_colour(std::size_t n) {
  static constexpr std::array<Colour, 6> kColours{
      {{31, 98, 196}, {226, 125, 20}, {24, 150, 72}, {132, 62, 178}, {0, 148, 158}, {176, 90, 60}}};
  return kColours[n % kColours.size()];
}

cv::Mat draw_plan(const PlanPicture& picture, int size_px) {
  const Plan plan(picture, size_px);
  Canvas canvas(plan.width, plan.height, kPaper);
  draw_floor(canvas, plan);
  draw_grid(canvas, plan);
  draw_outlines(canvas, plan);
  draw_views(canvas, plan);
  draw_robot(canvas, plan);
  draw_cameras(canvas, plan);
  if (!plan.is_whole()) {
    draw_overview(canvas, plan);
  }

  constexpr int kNarrowest_px = 480;
  Canvas sheet(std::max(kNarrowest_px, kLeft_px + plan.width + kRight_px),
               kTop_px + plan.height + kFoot_px, kPaper);
  const Vec2 corner(kLeft_px, kTop_px);
  sheet.paste_over(canvas.fine(Vec2::Zero(), plan.opposite()), corner);
  draw_axes(sheet, plan, corner);
  draw_legend(sheet, plan);
  return sheet.shrunk();
}

}  // namespace panoptes
