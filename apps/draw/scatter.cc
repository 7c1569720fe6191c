// SPDX-License-Identifier: BSD-3-Clause
#include "apps/draw/scatter.h"

#include <algorithm>
#include <utility>

namespace panoptes {
namespace {

constexpr int kWidth_px = 900;
constexpr int kHeight_px = 640;
constexpr double kLeft_px = 84;
constexpr double kTop_px = 56;
constexpr double kRight_px = 24;
constexpr double kFoot_px = 96;

// What is better at the high end.
struct Span : AxisSpan {
  bool more_is_better;

  Span(const Scatter& picture, int axis)
      : more_is_better(axis == 0 ? picture.x.more_is_better : picture.y.more_is_better) {
    for (const ScatterLayer& layer : picture.layers) {
      for (const ScatterPoint& point : layer.points) {
        take(point.at[axis] - point.half_interval[axis]);
        take(point.at[axis] + point.half_interval[axis]);
      }
    }
    make_room(0.04);
  }
  double goodness(double value) const { return more_is_better ? share(value) : 1 - share(value); }
};

std::string label_of(const ScatterAxis& axis) {
  return axis.label + (axis.more_is_better ? "" : ", less is better");
}

// Towards the middle of the picture, above or below where no other name stands.
void write_name(Canvas& canvas, std::vector<std::pair<Vec2, Vec2>>& taken, const Vec2& at,
                double middle_px, const std::string& name, const Colour& colour) {
  constexpr double kSize_px = 13;
  constexpr double kLine_px = 17;
  constexpr int kMostTries = 12;
  const double width_px = Canvas::text_width(name, kSize_px);
  const double left = at.x() < middle_px ? at.x() + 9 : at.x() - 9 - width_px;
  Vec2 base(left, at.y() - 8);
  for (int i = 0; i < kMostTries; ++i) {
    base.y() = at.y() - 8 + kLine_px * (i % 2 == 0 ? -(i / 2) : (i + 1) / 2 + 0.5);
    const Vec2 low = base - Vec2(0, kLine_px);
    const Vec2 high = base + Vec2(width_px, 0);
    const bool is_free = std::none_of(taken.begin(), taken.end(), [&](const auto& box) {
      return (low.array() < box.second.array()).all() && (box.first.array() < high.array()).all();
    });
    if (is_free) {
      break;
    }
  }
  taken.emplace_back(base - Vec2(0, kLine_px), base + Vec2(width_px, 0));
  canvas.label(name, base, colour, kSize_px);
}

}  // namespace

cv::Mat draw_scatter(const Scatter& picture) {
  const Span x(picture, 0);
  const Span y(picture, 1);
  Canvas canvas(kWidth_px, kHeight_px, kPaper);
  const Vec2 low(kLeft_px, kHeight_px - kFoot_px);
  const Vec2 high(kWidth_px - kRight_px, kTop_px);
  const auto to_px = [&](const Vec2& at) {
    return Vec2(low.x() + x.goodness(at.x()) * (high.x() - low.x()),
                low.y() + y.goodness(at.y()) * (high.y() - low.y()));
  };
  canvas.text_upwards(label_of(picture.y), {22, (low.y() + high.y()) / 2}, kInk, 15, kPaper);
  for (const double value : round_values(x.low(), x.high(), round_step(x.high() - x.low(), 8))) {
    const double at = to_px({value, y.low()}).x();
    canvas.line({at, low.y()}, {at, high.y()}, kGridColour, 1);
    canvas.text(short_number(value), {at, low.y() + 18}, kFaint, 13, 0.5);
  }
  for (const double value : round_values(y.low(), y.high(), round_step(y.high() - y.low(), 8))) {
    const double at = to_px({x.low(), value}).y();
    canvas.line({low.x(), at}, {high.x(), at}, kGridColour, 1);
    canvas.text(short_number(value), {low.x() - 8, at + 5}, kFaint, 13, 1);
  }
  for (const ScatterLayer& layer : picture.layers) {
    std::vector<Vec2> all_px;
    for (const ScatterPoint& point : layer.points) {
      const Vec2 at = to_px(point.at);
      for (const int axis : {0, 1}) {
        if (point.half_interval[axis] > 0) {
          const Vec2 half = point.half_interval[axis] * (axis == 0 ? Vec2(1, 0) : Vec2(0, 1));
          canvas.line(to_px(point.at - half), to_px(point.at + half), layer.colour, 1);
        }
      }
      canvas.disc(at, layer.radius_px, layer.colour);
      all_px.push_back(at);
    }
    if (layer.joined && all_px.size() > 1) {
      std::sort(all_px.begin(), all_px.end(),
                [](const Vec2& a, const Vec2& b) { return a.x() < b.x(); });
      canvas.polyline(all_px, layer.colour, 1.5);
    }
  }
  std::vector<std::pair<Vec2, Vec2>> taken;
  for (auto layer = picture.layers.rbegin(); layer != picture.layers.rend(); ++layer) {
    for (const ScatterPoint& point : layer->points) {
      if (!point.name.empty()) {
        write_name(canvas, taken, to_px(point.at), 0.5 * (low.x() + high.x()), point.name,
                   layer->colour);
      }
    }
  }
  canvas.frame({low.x(), high.y()}, {high.x(), low.y()}, kFaint, 1);
  canvas.text(picture.title, {kLeft_px, 30}, kInk, 20);
  canvas.text(label_of(picture.x), {(low.x() + high.x()) / 2, low.y() + 42}, kInk, 15, 0.5);
  double at = kLeft_px;
  for (auto layer = picture.layers.rbegin(); layer != picture.layers.rend(); ++layer) {
    canvas.disc({at + 6, kHeight_px - 21.0}, layer->radius_px, layer->colour);
    canvas.text(layer->name, {at + 18, kHeight_px - 16.0}, kInk, 14);
    at += 18 + Canvas::text_width(layer->name, 14) + 22;
  }
  return canvas.shrunk();
}

}  // namespace panoptes
