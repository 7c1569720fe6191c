// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/sight_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "apps/draw/canvas.h"
#include "apps/draw/plan_picture.h"
#include "core/eval/floor_sight.h"

namespace panoptes {
namespace {

constexpr int kPlan_px = 760;
constexpr int kLeft_px = 46;
constexpr int kTop_px = 62;
constexpr int kRight_px = 16;
constexpr int kFoot_px = 118;
constexpr double kCell_m = 0.02;
constexpr double kFinest_m = 0.005;  // as strong as it gets,
constexpr double kCoarsest_m = 0.2;  // and as pale
const Colour kBody{150, 155, 162};
const Colour kStopping{214, 28, 38};

/// How strong a colour stands for a ground sampling distance.
double strength(double sampling_m) {
  const double octaves = std::log(sampling_m / kFinest_m) / std::log(kCoarsest_m / kFinest_m);
  return 0.92 - 0.78 * std::clamp(octaves, 0.0, 1.0);
}

/// A part of the colours together, over white.
Colour mixed(const std::vector<Colour>& colours, double share) {
  const auto n = static_cast<double>(colours.size());
  double r = 0;
  double g = 0;
  double b = 0;
  for (const Colour& colour : colours) {
    r += colour.r / n;
    g += colour.g / n;
    b += colour.b / n;
  }
  const auto over_white = [share](double value) {
    return static_cast<unsigned char>(std::lround(255 + share * (value - 255)));
  };
  return {over_white(r), over_white(g), over_white(b)};
}

class SightPlan {
 public:
  SightPlan(const PlacedRig& placed, const PlaceOptions& options)
      : placed_(placed),
        options_(options),
        sight_(placed.rig, options.robot),
        floor_(floor_sight({options.scores.floor.reach_m, kCell_m}, sight_)),
        reach_m_(options.scores.floor.reach_m),
        px_per_m_(kPlan_px / (2 * reach_m_)) {}

  cv::Mat draw() const {
    Canvas canvas(kPlan_px, kPlan_px, kPaper);
    draw_cells(canvas);
    draw_grid(canvas);
    draw_mapped_edge(canvas);
    draw_robot(canvas);
    Canvas sheet(kLeft_px + kPlan_px + kRight_px, kTop_px + kPlan_px + kFoot_px, kPaper);
    const Vec2 corner(kLeft_px, kTop_px);
    sheet.paste_over(canvas.fine(Vec2::Zero(), Vec2::Constant(kPlan_px)), corner);
    draw_frame(sheet, corner);
    draw_legend(sheet);
    return sheet.shrunk();
  }

 private:
  // x up the page, y to the left
  Vec2 to_px(const Vec2& p_body) const {
    return {kPlan_px / 2.0 - p_body.y() * px_per_m_, kPlan_px / 2.0 - p_body.x() * px_per_m_};
  }

  std::size_t cell_at(const Vec2& p_body) const {
    const double half = floor_.side / 2.0;
    const auto index = [&](double along) {
      return std::clamp(static_cast<int>(std::floor(along / floor_.cell_m + half)), 0,
                        floor_.side - 1);
    };
    return static_cast<std::size_t>(index(p_body.y())) * static_cast<std::size_t>(floor_.side) +
           static_cast<std::size_t>(index(p_body.x()));
  }

  Vec2 to_body(double u, double v) const {
    return {(kPlan_px / 2.0 - v) / px_per_m_, (kPlan_px / 2.0 - u) / px_per_m_};
  }

  Colour colour_of(std::size_t cell) const {
    if (floor_.floor[cell] == 0) {
      return kPaper;
    }
    std::vector<Colour> colours;
    for (std::size_t i = 0; i < placed_.scores.cameras.size(); ++i) {
      if ((floor_.seen[cell] & camera_bit(i)) != 0) {
        colours.push_back(nth_colour(i));
      }
    }
    constexpr Colour kUnseen{236, 237, 239};
    return colours.empty() ? kUnseen
                           : mixed(colours, strength(static_cast<double>(floor_.sampling_m[cell])));
  }

  void draw_cells(Canvas& canvas) const {
    cv::Mat fine = canvas.fine(Vec2::Zero(), Vec2::Constant(kPlan_px));
    constexpr double kOver = Canvas::kOver;
    for (int v = 0; v < fine.rows; ++v) {
      for (int u = 0; u < fine.cols; ++u) {
        const Colour c = colour_of(cell_at(to_body((u + 0.5) / kOver, (v + 0.5) / kOver)));
        fine.at<cv::Vec3b>(v, u) = {c.b, c.g, c.r};
      }
    }
  }

  void draw_mapped_edge(Canvas& canvas) const {
    const auto mapped = [&](int column, int row) {
      const auto cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(floor_.side) +
                        static_cast<std::size_t>(column);
      return floor_.mapped[cell] != 0;
    };
    const double half_m = floor_.cell_m / 2;
    for (int row = 1; row < floor_.side; ++row) {
      for (int column = 1; column < floor_.side; ++column) {
        const Vec2 corner = floor_.centre(column, row) - Vec2(half_m, half_m);
        if (mapped(column, row) != mapped(column - 1, row)) {
          canvas.line(to_px(corner), to_px(corner + Vec2(0, floor_.cell_m)), kInk, 1.5);
        }
        if (mapped(column, row) != mapped(column, row - 1)) {
          canvas.line(to_px(corner), to_px(corner + Vec2(floor_.cell_m, 0)), kInk, 1.5);
        }
      }
    }
  }

  void draw_grid(Canvas& canvas) const {
    for (const double at : round_values(-reach_m_, reach_m_, 1)) {
      canvas.line(to_px({at, reach_m_}), to_px({at, -reach_m_}), {205, 208, 213}, 0.75);
      canvas.line(to_px({reach_m_, at}), to_px({-reach_m_, at}), {205, 208, 213}, 0.75);
    }
  }

  void draw_robot(Canvas& canvas) const {
    const double radius_m = options_.robot.radius_m;
    canvas.disc(to_px({0, 0}), radius_m * px_per_m_, kBody);
    if (options_.robot.faces) {  // what the cameras look past
      for (const auto& [p, q, r] : *options_.robot.faces) {
        canvas.polygon({to_px(p.head<2>()), to_px(q.head<2>()), to_px(r.head<2>())}, kBody);
      }
    }
    canvas.ring(to_px({0, 0}), radius_m * px_per_m_, kInk, 1.5);
    canvas.ring(to_px({0, 0}), (radius_m + placed_.scores.stopping_m) * px_per_m_, kStopping, 1.5);
    for (std::size_t i = 0; i < sight_.cameras().size(); ++i) {
      const CameraSight& camera = sight_.cameras()[i];
      const Vec2 eye = camera.eye_body().head<2>();
      const Vec3 axis = camera.camera().T_body_camera.rotation * Vec3::UnitZ();
      constexpr double kAxis_m = 0.18;
      canvas.line(to_px(eye), to_px(eye + kAxis_m * axis.head<2>()), nth_colour(i), 2.5);
      canvas.disc(to_px(eye), 4, nth_colour(i));
    }
  }

  void draw_frame(Canvas& sheet, const Vec2& corner) const {
    sheet.text(placed_.name, {static_cast<double>(kLeft_px), 27}, kInk, 20);
    std::string words = fmt::format("{:.1f} m2 of floor seen", placed_.scores.floor_seen_m2);
    if (placed_.scores.floor_mapped_m2) {
      words += fmt::format(", {:.1f} m2 mapped", *placed_.scores.floor_mapped_m2);
    }
    if (placed_.scores.blind_ahead_m) {
      words += fmt::format("; blind ahead {:.2f} m, stopping distance {:.2f} m",
                           *placed_.scores.blind_ahead_m, placed_.scores.stopping_m);
    }
    sheet.text(words, {static_cast<double>(kLeft_px), 49}, kFaint, 14);
    sheet.frame(corner, corner + Vec2::Constant(kPlan_px), kFaint, 1);
    for (const double at : round_values(-reach_m_, reach_m_, 1)) {
      sheet.text(short_number(at), corner + Vec2(-7, to_px({at, 0}).y() + 5), kFaint, 13, 1);
      sheet.text(short_number(at), corner + Vec2(to_px({0, at}).x(), kPlan_px + 17.0), kFaint, 13,
                 0.5);
    }
  }

  void draw_legend(Canvas& sheet) const {
    double x = kLeft_px;
    double base = kTop_px + kPlan_px + 44;
    const auto word = [&](const std::string& text, double symbol_px) {
      sheet.text(text, {x + symbol_px, base}, kInk, 14);
      x += symbol_px + Canvas::text_width(text, 14) + 20;
    };
    for (std::size_t i = 0; i < placed_.scores.cameras.size(); ++i) {
      sheet.box({x, base - 12}, {x + 18, base + 1}, nth_colour(i));
      word(placed_.scores.cameras[i], 24);
    }
    sheet.text("mixed where several see it", {x, base}, kFaint, 13);
    x = kLeft_px;
    base += 26;
    for (const double sampling_m : {0.005, 0.01, 0.02, 0.05, 0.1, 0.2}) {
      sheet.box({x, base - 12}, {x + 18, base + 1}, mixed({nth_colour(0)}, strength(sampling_m)));
      word(short_number(100 * sampling_m), 24);
    }
    sheet.text("cm of floor a pixel covers, the longer way", {x, base}, kFaint, 13);
    x = kLeft_px;
    base += 26;
    sheet.line({x, base - 5}, {x + 18, base - 5}, kInk, 1.5);
    word("edge of what is mapped", 24);
    sheet.ring({x + 9, base - 5}, 7, kStopping, 1.5);
    word("stands within, from full speed", 24);
    sheet.text("metres in body, x up", {x, base}, kFaint, 13);
  }

  const PlacedRig& placed_;
  const PlaceOptions& options_;
  RigSight sight_;
  FloorSight floor_;
  double reach_m_ = 0;
  double px_per_m_ = 0;
};

}  // namespace

cv::Mat sight_picture(const PlacedRig& placed, const PlaceOptions& options) {
  return SightPlan(placed, options).draw();
}

}  // namespace panoptes
