// SPDX-License-Identifier: BSD-3-Clause
#include "apps/draw/bands.h"

#include <algorithm>
#include <array>

namespace panoptes {
namespace {

constexpr int kWidth_px = 900;
constexpr int kPanel_px = 250;
constexpr int kTop_px = 50;
constexpr double kLeft_px = 96;
constexpr double kRight_px = 24;
constexpr double kGap_px = 26;  // between panels
constexpr double kLine_px = 20;
constexpr std::array<Colour, 8> kColours{{{31, 98, 196},
                                          {214, 28, 38},
                                          {24, 150, 72},
                                          {226, 125, 20},
                                          {132, 62, 178},
                                          {20, 150, 160},
                                          {150, 100, 60},
                                          {110, 116, 124}}};

const Colour& colour_of(std::size_t curve) { return kColours[curve % kColours.size()]; }

Colour paler(const Colour& c) {
  const auto mixed = [](unsigned char v) {
    return static_cast<unsigned char>(255 - (255 - v) / 5);
  };
  return {mixed(c.r), mixed(c.g), mixed(c.b)};
}

// Names that are too long for their steps stand on two lines by turns, and are cut.
std::string cut(std::string words, double width_px, double size_px) {
  if (Canvas::text_width(words, size_px) <= width_px) {
    return words;
  }
  const auto is_within_letter = [](char byte) {  // UTF-8
    return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
  };
  while (!words.empty() && Canvas::text_width(words + "..", size_px) > width_px) {
    while (words.size() > 1 && is_within_letter(words.back())) {
      words.pop_back();
    }
    words.pop_back();
  }
  return words + "..";
}

class PanelScale : public AxisSpan {
 public:
  PanelScale(const BandPanel& panel, std::size_t steps, const Vec2& top_left,
             const Vec2& bottom_right)
      : steps_(static_cast<double>(steps)), top_left_(top_left), bottom_right_(bottom_right) {
    for (const BandCurve& curve : panel.curves) {
      for (const auto& point : curve.points) {
        if (point) {
          take(point->low);
          take(point->high);
        }
      }
    }
    make_room(0.06);
  }
  // `aside` keeps the bars of several curves apart.
  Vec2 to_px(std::size_t step, double value, double aside_px = 0) const {
    const double width = (bottom_right_.x() - top_left_.x()) / steps_;
    return {top_left_.x() + (static_cast<double>(step) + 0.5) * width + aside_px,
            bottom_right_.y() - share(value) * (bottom_right_.y() - top_left_.y())};
  }

 private:
  double steps_;
  Vec2 top_left_;
  Vec2 bottom_right_;
};

// Calls `draw` with each step whose point and next one are known, and with these.
template <class Draw>
void for_each_stretch(const BandCurve& curve, Draw&& draw) {
  for (std::size_t i = 0; i + 1 < curve.points.size(); ++i) {
    if (curve.points[i] && curve.points[i + 1]) {
      draw(i, *curve.points[i], *curve.points[i + 1]);
    }
  }
}

void draw_curve(Canvas& canvas, const PanelScale& scale, const BandCurve& curve,
                const Colour& colour, double aside_px) {
  for_each_stretch(curve, [&](std::size_t i, const BandPoint& a, const BandPoint& b) {
    canvas.line(scale.to_px(i, a.mean, aside_px), scale.to_px(i + 1, b.mean, aside_px), colour,
                1.5);
  });
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    if (const auto& point = curve.points[i]) {
      canvas.line(scale.to_px(i, point->low, aside_px), scale.to_px(i, point->high, aside_px),
                  colour, 1);
      canvas.disc(scale.to_px(i, point->mean, aside_px), 3.5, colour);
    }
  }
}

void fill_band(Canvas& canvas, const PanelScale& scale, const BandCurve& curve,
               const Colour& colour, double aside_px) {
  for_each_stretch(curve, [&](std::size_t i, const BandPoint& a, const BandPoint& b) {
    canvas.polygon({scale.to_px(i, a.low, aside_px), scale.to_px(i, a.high, aside_px),
                    scale.to_px(i + 1, b.high, aside_px), scale.to_px(i + 1, b.low, aside_px)},
                   paler(colour));
  });
}

// So that none is hidden by a wider one.
std::vector<std::size_t> widest_first(const std::vector<BandCurve>& curves) {
  std::vector<double> widths(curves.size(), 0);
  std::vector<std::size_t> order(curves.size());
  for (std::size_t c = 0; c < curves.size(); ++c) {
    order[c] = c;
    for (const auto& point : curves[c].points) {
      widths[c] += point ? point->high - point->low : 0;
    }
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return widths[a] > widths[b]; });
  return order;
}

}  // namespace

cv::Mat draw_bands(const Bands& picture) {
  const std::size_t panels = picture.panels.size();
  const std::size_t curves = panels == 0 ? 0 : picture.panels.front().curves.size();
  const double foot_px = 3 * kLine_px + kLine_px * static_cast<double>(curves) + 8;
  const int height_px = kTop_px + kPanel_px * static_cast<int>(panels) + static_cast<int>(foot_px);
  Canvas canvas(kWidth_px, height_px, kPaper);
  canvas.text(picture.title, {kLeft_px, 30}, kInk, 20);
  const double right = kWidth_px - kRight_px;
  double bottom = kTop_px;
  for (std::size_t p = 0; p < panels; ++p) {
    const BandPanel& panel = picture.panels[p];
    const double top = kTop_px + kPanel_px * static_cast<double>(p);
    bottom = top + kPanel_px - kGap_px;
    const PanelScale scale(panel, picture.steps.size(), {kLeft_px, top}, {right, bottom});
    const auto aside_px = [&](std::size_t curve) {
      return 5 * (static_cast<double>(curve) - 0.5 * static_cast<double>(curves - 1));
    };
    canvas.text_upwards(panel.label, {22, (top + bottom) / 2}, kInk, 14, kPaper);
    for (const std::size_t c : widest_first(panel.curves)) {
      fill_band(canvas, scale, panel.curves[c], colour_of(c), aside_px(c));
    }
    for (const double value :
         round_values(scale.low(), scale.high(), round_step(scale.high() - scale.low(), 6))) {
      const double at = scale.to_px(0, value).y();
      canvas.line({kLeft_px, at}, {right, at}, kGridColour, 1);
      canvas.text(short_number(value), {kLeft_px - 8, at + 5}, kFaint, 13, 1);
    }
    for (std::size_t c = 0; c < panel.curves.size(); ++c) {
      draw_curve(canvas, scale, panel.curves[c], colour_of(c), aside_px(c));
    }
    canvas.frame({kLeft_px, top}, {right, bottom}, kFaint, 1);
  }
  const double step_px =
      (right - kLeft_px) / static_cast<double>(std::max<std::size_t>(1, picture.steps.size()));
  for (std::size_t i = 0; i < picture.steps.size(); ++i) {
    const double at = kLeft_px + (static_cast<double>(i) + 0.5) * step_px;
    canvas.text(cut(picture.steps[i], std::min(2 * step_px - 12, 2 * (kWidth_px - 4 - at)), 13),
                {at, bottom + kLine_px * (i % 2 == 0 ? 1 : 2)}, kInk, 13, 0.5);
  }
  for (std::size_t c = 0; c < curves; ++c) {
    const double at = bottom + kLine_px * (3.3 + static_cast<double>(c));
    canvas.disc({kLeft_px + 6, at - 5}, 4, colour_of(c));
    canvas.text(picture.panels.front().curves[c].name, {kLeft_px + 18, at}, kInk, 14);
  }
  return canvas.shrunk();
}

}  // namespace panoptes
