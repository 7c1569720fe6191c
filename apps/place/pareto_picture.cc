// SPDX-License-Identifier: BSD-3-Clause
#include "apps/place/pareto_picture.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "apps/draw/canvas.h"
#include "core/base/text.h"

namespace panoptes {
namespace {

constexpr int kWidth_px = 900;
constexpr int kHeight_px = 640;
constexpr double kLeft_px = 84;
constexpr double kTop_px = 56;
constexpr double kRight_px = 24;
constexpr double kFoot_px = 96;
const Colour kGood{31, 98, 196};
const Colour kBroken{200, 204, 210};
const Colour kPareto{214, 28, 38};

struct Axis {
  std::string label;
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  bool more_is_better = true;
  std::size_t score = 0;
  bool by_number = false;  // of the rig
  double scale = 1;

  std::optional<double> of(const RigSweep& sweep, std::size_t rig) const {
    if (by_number) {
      return static_cast<double>(rig + 1);
    }
    const std::optional<double>& value = sweep.rigs[rig].scores[score];
    return value ? std::optional(*value * scale) : std::nullopt;
  }
  // From 0 to 1, what is better at 1.
  double share(double value) const {
    const double s = (value - low) / (high - low);
    return more_is_better ? s : 1 - s;
  }
};

Axis axis_of(const RigSweep& sweep, std::size_t objective) {
  Axis axis;
  axis.by_number = objective >= sweep.objectives.size();
  if (axis.by_number) {
    axis.label = "rig";
  } else {
    const NamedScore& name = sweep.names[sweep.objectives[objective]];
    axis.score = sweep.objectives[objective];
    axis.more_is_better = name.better == Better::kHigher;
    axis.scale = name.scale;
    axis.label = name.what + (name.unit.empty() ? "" : " (" + name.unit + ")") +
                 (axis.more_is_better ? "" : ", less is better");
  }
  for (const std::size_t rig : sweep.ranked) {
    if (const auto value = axis.of(sweep, rig)) {
      axis.low = std::min(axis.low, *value);
      axis.high = std::max(axis.high, *value);
    }
  }
  if (!(axis.high > axis.low)) {
    const double middle = axis.high == axis.low ? axis.low : 0;
    axis.low = middle - 1;
    axis.high = middle + 1;
  }
  const double room = 0.04 * (axis.high - axis.low);
  axis.low -= room;
  axis.high += room;
  return axis;
}

}  // namespace

cv::Mat pareto_picture(const PlacementStudy& study, const RigSweep& sweep) {
  const Axis x = axis_of(sweep, sweep.objectives.size() > 1 ? 1 : sweep.objectives.size());
  const Axis y = axis_of(sweep, 0);
  Canvas canvas(kWidth_px, kHeight_px, kPaper);
  const Vec2 low(kLeft_px, kHeight_px - kFoot_px);
  const Vec2 high(kWidth_px - kRight_px, kTop_px);
  const auto to_px = [&](double of_x, double of_y) {
    return Vec2(low.x() + x.share(of_x) * (high.x() - low.x()),
                low.y() + y.share(of_y) * (high.y() - low.y()));
  };
  for (const double value : round_values(x.low, x.high, round_step(x.high - x.low, 8))) {
    const Vec2 at = to_px(value, y.low);
    canvas.line({at.x(), low.y()}, {at.x(), high.y()}, kGridColour, 1);
    canvas.text(short_number(value), {at.x(), low.y() + 18}, kFaint, 13, 0.5);
  }
  for (const double value : round_values(y.low, y.high, round_step(y.high - y.low, 8))) {
    const Vec2 at = to_px(x.low, value);
    canvas.line({low.x(), at.y()}, {high.x(), at.y()}, kGridColour, 1);
    canvas.text(short_number(value), {low.x() - 8, at.y() + 5}, kFaint, 13, 1);
  }
  std::vector<Vec2> front_px;
  for (const int layer : {0, 1, 2}) {  // the Pareto set over the good ones over the others
    for (const std::size_t rig : sweep.ranked) {
      const SweptRig& swept = sweep.rigs[rig];
      const int own = swept.pareto ? 2 : swept.good() ? 1 : 0;
      const auto of_x = x.of(sweep, rig);
      const auto of_y = y.of(sweep, rig);
      if (own != layer || !of_x || !of_y) {
        continue;
      }
      const Vec2 at = to_px(*of_x, *of_y);
      canvas.disc(at, own == 2 ? 5 : 3, own == 2 ? kPareto : own == 1 ? kGood : kBroken);
      if (own == 2) {
        front_px.push_back(at);
      }
    }
  }
  if (sweep.objectives.size() == 2 && front_px.size() > 1) {
    std::sort(front_px.begin(), front_px.end(),
              [](const Vec2& a, const Vec2& b) { return a.x() < b.x(); });
    canvas.polyline(front_px, kPareto, 1.5);
  }
  canvas.frame({low.x(), high.y()}, {high.x(), low.y()}, kFaint, 1);
  canvas.text(std::filesystem::path(study.file).stem().string(), {kLeft_px, 30}, kInk, 20);
  canvas.text(x.label, {(low.x() + high.x()) / 2, low.y() + 42}, kInk, 15, 0.5);
  canvas.text_upwards(y.label, {22, (low.y() + high.y()) / 2}, kInk, 15, kPaper);
  double at = kLeft_px;
  const auto legend = [&](const Colour& colour, double radius, const std::string& words) {
    canvas.disc({at + 6, kHeight_px - 21.0}, radius, colour);
    canvas.text(words, {at + 18, kHeight_px - 16.0}, kInk, 14);
    at += 18 + Canvas::text_width(words, 14) + 22;
  };
  legend(kPareto, 5, "Pareto set");
  legend(kGood, 3, "holds what is required");
  legend(kBroken, 3, "does not");
  return canvas.shrunk();
}

}  // namespace panoptes
