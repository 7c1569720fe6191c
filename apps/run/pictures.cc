// SPDX-License-Identifier: BSD-3-Clause
#include "apps/run/pictures.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "apps/run/canvas.h"
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

}  // namespace

cv::Mat draw_map(const MapPicture& picture) {
  const OccupancyMap& map = picture.map;
  // what to show, in metres
  Vec2 low(1e9, 1e9);
  Vec2 high(-1e9, -1e9);
  const Extent e = known_extent(map);
  if (e.column1 >= e.column0) {
    low = map.centre(e.column0, e.row0);
    high = map.centre(e.column1, e.row1);
  }
  for (const auto* way : {&picture.estimate_map, &picture.truth_map}) {
    for (const Vec2& p : *way) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  if (low.x() > high.x()) {
    low = high = Vec2::Zero();
  }
  constexpr double kMargin_m = 0.3;
  low -= Vec2::Constant(kMargin_m);
  high += Vec2::Constant(kMargin_m);
  const Vec2 size_m = high - low;

  constexpr double kLongest_px = 1100;
  constexpr int kHead_px = 44;
  constexpr int kFoot_px = 56;
  const double px_per_m = kLongest_px / std::max(size_m.x(), size_m.y());
  const int width = std::max(620, static_cast<int>(std::ceil(size_m.x() * px_per_m)));
  const int height = static_cast<int>(std::ceil(size_m.y() * px_per_m));
  Canvas canvas(width, height + kHead_px + kFoot_px, kPaper);
  const double left_px = (width - size_m.x() * px_per_m) / 2;
  const auto to_px = [&](const Vec2& p_map) {
    return Vec2(left_px + (p_map.x() - low.x()) * px_per_m,
                kHead_px + height - (p_map.y() - low.y()) * px_per_m);
  };

  constexpr int kOver = Canvas::kOver;
  cv::Mat floor(height * kOver, width * kOver, CV_8UC3);
  const auto cell_colour = [](Cell cell) -> cv::Vec3b {
    switch (cell) {
      case Cell::kFree:
        return {255, 255, 255};
      case Cell::kOccupied:
        return {72, 62, 56};
      case Cell::kUnknown:
        break;
    }
    return {218, 214, 210};
  };
  for (int v = 0; v < floor.rows; ++v) {
    for (int u = 0; u < floor.cols; ++u) {
      const Vec2 p_map =
          low + Vec2((u + 0.5) / kOver - left_px, height - (v + 0.5) / kOver) / px_per_m;
      const int column = static_cast<int>(std::floor((p_map.x() - map.origin.x()) / map.cell_m));
      const int row = static_cast<int>(std::floor((p_map.y() - map.origin.y()) / map.cell_m));
      floor.at<cv::Vec3b>(v, u) = cell_colour(map.at(column, row));
    }
  }
  canvas.paste_over(floor, {0, kHead_px});

  const auto draw_way = [&](const std::vector<Vec2>& way, const Colour& colour, double width_px) {
    std::vector<Vec2> px;
    px.reserve(way.size());
    for (const Vec2& p : way) {
      px.push_back(to_px(p));
    }
    canvas.polyline(px, colour, width_px);
  };
  draw_way(picture.truth_map, kTruthColour, 4);
  draw_way(picture.estimate_map, kEstimateColour, 1.5);
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
    canvas.disc(to_px(picture.estimate_map.front()), 7, kPaper);
    canvas.disc(to_px(picture.estimate_map.front()), 5, kInk);
  }

  canvas.text(picture.title, {16, 29}, kInk, 19);
  // legend and scale bar, below
  const double base = height + kHead_px + 34;
  double x = 16;
  const auto entry = [&](const std::string& name, const Colour& colour) {
    canvas.line({x, base - 5}, {x + 22, base - 5}, colour, 3);
    canvas.text(name, {x + 28, base}, kInk);
    x += 28 + Canvas::text_width(name, 15) + 20;
  };
  const bool any_wrong = std::any_of(picture.loops.begin(), picture.loops.end(),
                                     [](const LoopLine& l) { return l.wrong; });
  if (!picture.truth_map.empty()) {
    entry("true path", kTruthColour);
  }
  entry("estimated path", kEstimateColour);
  if (!picture.loops.empty()) {
    entry("loop closures", kLoopColour);
  }
  if (any_wrong) {
    entry("wrong ones", kWrongColour);
  }
  canvas.disc({x + 6, base - 5}, 5, kInk);
  canvas.text("start", {x + 18, base}, kInk);
  x += 18 + Canvas::text_width("start", 15);
  const double bar_m = round_step(size_m.x() / 3, 2);
  if (width - 16 - bar_m * px_per_m - Canvas::text_width("100 m", 15) - 30 > x) {
    canvas.scale_bar({width - 16.0, base}, bar_m, px_per_m);
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
