// SPDX-License-Identifier: BSD-3-Clause
#include "apps/draw/pictures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/draw/canvas.h"
#include "core/base/check.h"

namespace panoptes {
namespace {

struct Extent {
  int column0 = 0, row0 = 0, column1 = -1, row1 = -1;
};

Extent known_extent(const OccupancyMap& map) {
  Extent e{map.columns, map.rows, -1, -1};
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      if (map.at(column, row) != Cell::kUnknown) {
        e.column0 = std::min(e.column0, column);
        e.column1 = std::max(e.column1, column);
        e.row0 = std::min(e.row0, row);
        e.row1 = std::max(e.row1, row);
      }
    }
  }
  return e;
}

struct View {
  Vec2 low_map;
  Vec2 high_map;
  double px_per_m = 1;
};

// All that is known, all paths driven and goals about as near, with a margin.
View view_of(const MapPicture& picture) {
  const OccupancyMap& map = picture.map;
  Vec2 low(1e9, 1e9);
  Vec2 high(-1e9, -1e9);
  const auto show = [&](const Vec2& p_map) {
    low = low.cwiseMin(p_map);
    high = high.cwiseMax(p_map);
  };
  const Extent e = known_extent(map);
  if (e.column1 >= e.column0) {
    show(map.centre(e.column0, e.row0));
    show(map.centre(e.column1, e.row1));
  }
  for (const Pose2& pose : picture.estimate_map) {
    show(pose.position());
  }
  for (const Vec2& p_map : picture.truth_map) {
    show(p_map);
  }
  for (const ContactMark& contact : picture.contacts) {
    show(contact.p_map);
  }
  if (low.x() > high.x()) {
    low = high = Vec2::Zero();
  }
  constexpr double kLeast_m = 2;  // about so far aside of all that is known a goal is shown
  const double aside_m = std::max(kLeast_m, 0.5 * (high - low).maxCoeff());
  const Vec2 low_goal = low - Vec2::Constant(aside_m);
  const Vec2 high_goal = high + Vec2::Constant(aside_m);
  for (const GoalMark& goal : picture.goals) {
    if (goal.p_map == goal.p_map.cwiseMax(low_goal).cwiseMin(high_goal)) {
      show(goal.p_map);
    }
  }
  constexpr double kMargin_m = 0.3;
  constexpr double kLongest_px = 1100;
  low -= Vec2::Constant(kMargin_m);
  high += Vec2::Constant(kMargin_m);
  return {low, high, kLongest_px / (high - low).maxCoeff()};
}

cv::Vec3b cell_colour(Cell cell) {
  switch (cell) {
    case Cell::kFree:
      return {255, 255, 255};
    case Cell::kOccupied:
      return {72, 62, 56};
    case Cell::kUnknown:
      break;
  }
  return {218, 214, 210};
}

// As fine as a canvas draws it, `size_px` of the picture wide and high.
cv::Mat drawn_cells(const OccupancyMap& map, const View& view, const cv::Size& size_px) {
  constexpr int kOver = Canvas::kOver;
  cv::Mat cells(size_px * kOver, CV_8UC3);
  for (int v = 0; v < cells.rows; ++v) {
    for (int u = 0; u < cells.cols; ++u) {
      const Vec2 p_map =
          view.low_map + Vec2(u + 0.5, cells.rows - v - 0.5) / (kOver * view.px_per_m);
      cells.at<cv::Vec3b>(v, u) = cell_colour(map.at(p_map));
    }
  }
  return cells;
}

// The robot from above, its tip ahead.
void draw_arrow(Canvas& canvas, const Vec2& at_px, double theta_rad) {
  const auto corners = [&](double scale) {
    std::vector<Vec2> px;
    for (const Vec2& corner : {Vec2(12, 0), Vec2(-8, 7.5), Vec2(-8, -7.5)}) {
      const Vec2 turned = Pose2{0, 0, theta_rad} * (scale * corner);
      px.emplace_back(at_px.x() + turned.x(), at_px.y() - turned.y());
    }
    return px;
  };
  canvas.polygon(corners(1.4), kPaper);
  canvas.polygon(corners(1), kInk);
}

void draw_start(Canvas& canvas, const Vec2& at_px) {
  canvas.disc(at_px, 7, kPaper);
  canvas.disc(at_px, 5, kInk);
}

void draw_contact(Canvas& canvas, const Vec2& at_px, bool while_moving) {
  canvas.cross(at_px, 7, kPaper, 6);
  canvas.cross(at_px, 6.5, while_moving ? kWrongColour : kFaint, 3);
}

Colour colour_of(GoalMark::End end) {
  switch (end) {
    case GoalMark::End::kReached:
      return kTruthColour;
    case GoalMark::End::kRefused:
      return kWrongColour;
    case GoalMark::End::kNeither:
      break;
  }
  return kFaint;
}

// Without a number in the legend.
void draw_goal(Canvas& canvas, const Vec2& at_px, GoalMark::End end, const std::string& number) {
  canvas.disc(at_px, 11, kPaper);
  canvas.disc(at_px, 9, colour_of(end));
  canvas.text(number, at_px + Vec2(0, 4.5), kPaper, 13, 0.5);
}

// What a sign in the picture means.
struct LegendEntry {
  std::string name;
  std::function<void(Canvas& canvas, const Vec2& middle)> draw;
};

std::vector<LegendEntry> legend_of(const MapPicture& picture) {
  std::vector<LegendEntry> legend;
  const auto line = [&](const char* name, const Colour& colour) {
    legend.push_back({name, [colour](Canvas& canvas, const Vec2& middle) {
                        canvas.line(middle - Vec2(11, 0), middle + Vec2(11, 0), colour, 3);
                      }});
  };
  if (!picture.truth_map.empty()) {
    line("true path", kTruthColour);
  }
  line("estimated path", kEstimateColour);
  if (!picture.estimate_map.empty()) {
    legend.push_back({"start", draw_start});
    legend.push_back(
        {"end", [](Canvas& canvas, const Vec2& middle) { draw_arrow(canvas, middle, 0); }});
  }
  if (!picture.loops.empty()) {
    line("loop closures", kLoopColour);
  }
  if (std::any_of(picture.loops.begin(), picture.loops.end(),
                  [](const LoopLine& l) { return l.wrong; })) {
    line("wrong ones", kWrongColour);
  }
  for (const bool moving : {true, false}) {
    if (std::any_of(picture.contacts.begin(), picture.contacts.end(),
                    [&](const ContactMark& c) { return c.while_moving == moving; })) {
      legend.push_back(
          {moving ? "touched" : "touched while it stood",
           [moving](Canvas& canvas, const Vec2& middle) { draw_contact(canvas, middle, moving); }});
    }
  }
  using End = GoalMark::End;
  for (const auto& [end, name] :
       {std::pair(End::kReached, "goal, reached"), std::pair(End::kRefused, "goal, refused"),
        std::pair(End::kNeither, "goal, not reached")}) {
    if (std::any_of(picture.goals.begin(), picture.goals.end(),
                    [end = end](const GoalMark& goal) { return goal.end == end; })) {
      legend.push_back({name, [end = end](Canvas& canvas, const Vec2& middle) {
                          draw_goal(canvas, middle, end, "");
                        }});
    }
  }
  return legend;
}

constexpr double kSign_px = 30;  // from a sign's left side to its name
constexpr double kRow_px = 26;

double width_px(const LegendEntry& entry) {
  return kSign_px + Canvas::text_width(entry.name, 15) + 20;
}

// From the left side on, in as many rows as it takes.
std::vector<Vec2> places_of(const std::vector<LegendEntry>& legend, double width) {
  std::vector<Vec2> corners;
  Vec2 at(0, 0);
  for (const LegendEntry& entry : legend) {
    if (at.x() > 0 && at.x() + width_px(entry) > width) {
      at = {0, at.y() + kRow_px};
    }
    corners.push_back(at);
    at.x() += width_px(entry);
  }
  return corners;
}

}  // namespace

cv::Mat draw_map(const MapPicture& picture) {
  constexpr int kLeft_px = 50;  // for the numbers along the side
  constexpr int kRight_px = 14;
  constexpr int kHead_px = 44;
  constexpr int kNarrowest_px = 620;
  const View view = view_of(picture);
  const Vec2 size_m = view.high_map - view.low_map;
  const cv::Size plot_px(static_cast<int>(std::ceil(size_m.x() * view.px_per_m)),
                         static_cast<int>(std::ceil(size_m.y() * view.px_per_m)));
  const int width = std::max(kNarrowest_px, kLeft_px + plot_px.width + kRight_px);
  const std::vector<LegendEntry> legend = legend_of(picture);
  const std::vector<Vec2> places = places_of(legend, width - kLeft_px - kRight_px);
  const int foot_px = static_cast<int>(74 + places.back().y());
  Canvas canvas(width, kHead_px + plot_px.height + foot_px, kPaper);
  const Vec2 corner((kLeft_px + width - kRight_px - plot_px.width) / 2, kHead_px);
  const Vec2 opposite = corner + Vec2(plot_px.width, plot_px.height);
  const auto to_px = [&](const Vec2& p_map) {
    return Vec2(corner.x() + (p_map.x() - view.low_map.x()) * view.px_per_m,
                opposite.y() - (p_map.y() - view.low_map.y()) * view.px_per_m);
  };
  canvas.paste_over(drawn_cells(picture.map, view, plot_px), corner);
  const Colour on_cells{200, 204, 210};  // seen on the floor and on what is unknown
  const double step_m = round_step(size_m.maxCoeff(), 12);
  for (const double x_m : round_values(view.low_map.x(), view.high_map.x(), step_m)) {
    const double x = to_px({x_m, 0}).x();
    canvas.line({x, corner.y()}, {x, opposite.y()}, on_cells, 0.5);
    canvas.text(short_number(x_m), {x, opposite.y() + 18}, kFaint, 13, 0.5);
  }
  for (const double y_m : round_values(view.low_map.y(), view.high_map.y(), step_m)) {
    const double y = to_px({0, y_m}).y();
    canvas.line({corner.x(), y}, {opposite.x(), y}, on_cells, 0.5);
    canvas.text(short_number(y_m), {corner.x() - 7, y + 5}, kFaint, 13, 1);
  }
  canvas.frame(corner, opposite, kFaint, 1);

  const auto draw_path = [&](const std::vector<Vec2>& path, const Colour& colour, double line_px) {
    std::vector<Vec2> px;
    px.reserve(path.size());
    for (const Vec2& p : path) {
      px.push_back(to_px(p));
    }
    canvas.polyline(px, colour, line_px);
  };
  std::vector<Vec2> estimate_map;
  for (const Pose2& pose : picture.estimate_map) {
    estimate_map.push_back(pose.position());
  }
  draw_path(picture.truth_map, kTruthColour, 4);
  draw_path(estimate_map, kEstimateColour, 1.5);
  for (const bool wrong : {false, true}) {
    for (const LoopLine& loop : picture.loops) {
      if (loop.wrong == wrong) {
        const Colour& colour = wrong ? kWrongColour : kLoopColour;
        canvas.line(to_px(loop.a_map), to_px(loop.b_map), colour, wrong ? 2.5 : 1.5);
        canvas.ring(to_px(loop.b_map), wrong ? 6 : 4.5, colour, wrong ? 2.5 : 1.5);
      }
    }
  }
  if (!picture.estimate_map.empty()) {
    const Pose2& end = picture.estimate_map.back();
    draw_start(canvas, to_px(estimate_map.front()));
    draw_arrow(canvas, to_px(end.position()), end.theta_rad);
  }
  for (std::size_t i = 0; i < picture.goals.size(); ++i) {
    const GoalMark& goal = picture.goals[i];
    draw_goal(canvas, to_px(goal.p_map).cwiseMax(corner).cwiseMin(opposite), goal.end,
              std::to_string(i + 1));
  }
  for (const ContactMark& contact : picture.contacts) {
    draw_contact(canvas, to_px(contact.p_map), contact.while_moving);
  }

  canvas.text(picture.title, {16, 29}, kInk, 19);
  const double base = opposite.y() + 42;
  canvas.text("metres in map", {kLeft_px, base}, kFaint, 13);
  canvas.scale_bar({width - kRight_px - 2.0, base}, round_step(size_m.x() / 3, 2), view.px_per_m);
  for (std::size_t i = 0; i < legend.size(); ++i) {
    const Vec2 at = Vec2(kLeft_px, base + 24) + places[i];
    legend[i].draw(canvas, at + Vec2(11, -5));
    canvas.text(legend[i].name, at + Vec2(kSign_px, 0), kInk);
  }
  return canvas.shrunk();
}

cv::Mat draw_plot(const Plot& plot) {
  constexpr int kWidth = 1100;
  constexpr int kHeight = 520;
  const Vec2 low(84, 64);  // the plotting area in pixels: left, top
  const Vec2 high(kWidth - 28, kHeight - 66);
  double x_end = 0;
  double y_end = plot.y_top;
  for (const Curve& curve : plot.curves) {
    for (const Vec2& p : curve.points) {
      x_end = std::max(x_end, p.x());
      y_end = std::max(y_end, p.y());
    }
  }
  x_end = x_end > 0 ? x_end : 1;
  y_end = y_end > 0 ? y_end : 1;
  const double y_step = round_step(y_end, 8);
  y_end = y_step * std::ceil(y_end / y_step - 1e-9);
  const auto to_px = [&](double x, double y) {
    return Vec2(low.x() + x / x_end * (high.x() - low.x()),
                high.y() - y / y_end * (high.y() - low.y()));
  };

  Canvas canvas(kWidth, kHeight, kPaper);
  canvas.text(plot.title, {low.x(), 32}, kInk, 19);
  for (int i = 0; i * y_step <= y_end * (1 + 1e-9); ++i) {
    const Vec2 at = to_px(0, i * y_step);
    canvas.line(at, {high.x(), at.y()}, i == 0 ? kFaint : kGridColour, 1);
    canvas.text(short_number(i * y_step), {low.x() - 9, at.y() + 5}, kFaint, 14, 1);
  }
  const double x_step = round_step(x_end, 12);
  for (int i = 0; i * x_step <= x_end * (1 + 1e-9); ++i) {
    const Vec2 at = to_px(i * x_step, 0);
    canvas.line(at, {at.x(), low.y()}, kGridColour, 1);
    canvas.text(short_number(i * x_step), {at.x(), at.y() + 22}, kFaint, 14, 0.5);
  }
  canvas.line({low.x(), high.y()}, {high.x(), high.y()}, kFaint, 1);
  for (const Level& level : plot.levels) {
    const double y = to_px(0, level.y).y();
    for (double x = low.x(); x < high.x(); x += 12) {
      canvas.line({x, y}, {std::min(x + 6, high.x()), y}, kFaint, 1);
    }
    canvas.text(level.name, {low.x() + 6, y + 15}, kFaint, 13);
  }
  for (const Tick& tick : plot.ticks) {
    const double x = to_px(tick.x, 0).x();
    canvas.line({x, high.y()}, {x, high.y() - 11}, tick.colour, 1.5);
  }
  for (const Curve& curve : plot.curves) {
    std::vector<Vec2> px;
    px.reserve(curve.points.size());
    for (const Vec2& p : curve.points) {
      px.push_back(to_px(p.x(), p.y()));
    }
    canvas.polyline(px, curve.colour, 2);
    if (px.size() == 1) {
      canvas.disc(px.front(), 3, curve.colour);
    }
  }
  // legend, right of the title
  double x = high.x();
  const auto entry = [&](const std::string& name, const Colour& colour) {
    x -= Canvas::text_width(name, 15);
    canvas.text(name, {x, 32}, kInk);
    x -= 28;
    canvas.line({x, 27}, {x + 22, 27}, colour, 3);
    x -= 20;
  };
  for (std::size_t i = plot.tick_names.size(); i-- > 0;) {
    entry(plot.tick_names[i].first, plot.tick_names[i].second);
  }
  if (plot.curves.size() > 1 || !plot.tick_names.empty()) {
    for (std::size_t i = plot.curves.size(); i-- > 0;) {
      entry(plot.curves[i].name, plot.curves[i].colour);
    }
  }
  canvas.text(plot.x_label, {(low.x() + high.x()) / 2, kHeight - 14.0}, kInk, 15, 0.5);
  canvas.text_upwards(plot.y_label, {20, (low.y() + high.y()) / 2}, kInk, 15, kPaper);
  return canvas.shrunk();
}

std::string png(const cv::Mat& bgr) {
  std::vector<unsigned char> bytes;
  PANOPTES_CHECK(cv::imencode(".png", bgr, bytes), "a picture can be encoded");
  return {bytes.begin(), bytes.end()};
}

}  // namespace panoptes
