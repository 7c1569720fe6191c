// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/pose2.h"

namespace panoptes {

struct Colour {
  unsigned char r = 0;
  unsigned char g = 0;
  unsigned char b = 0;
};
constexpr Colour kInk{38, 42, 48};
constexpr Colour kFaint{120, 126, 134};
constexpr Colour kGridColour{226, 229, 233};
constexpr Colour kPaper{255, 255, 255};

/// Draws in the final picture's pixels. Everything is drawn at twice its size and shrunk, which
/// smooths lines and letters alike.
class Canvas {
 public:
  static constexpr int kOver = 2;

  Canvas(int width, int height, const Colour& background);

  void line(const Vec2& a, const Vec2& b, const Colour& c, double width);
  void polyline(const std::vector<Vec2>& points, const Colour& c, double width);
  void polygon(const std::vector<Vec2>& corners, const Colour& fill);  ///< convex
  void cross(const Vec2& centre, double radius, const Colour& c, double width);
  void disc(const Vec2& centre, double radius, const Colour& c);
  void ring(const Vec2& centre, double radius, const Colour& c, double width);
  void box(const Vec2& low, const Vec2& high, const Colour& c);
  void frame(const Vec2& low, const Vec2& high, const Colour& c, double width);

  /// `at` is the left end of the baseline, or where `anchor` (0 left, 0.5 middle, 1 right) says.
  void text(const std::string& words, const Vec2& at, const Colour& c, double size_px = 15,
            double anchor = 0);
  /// The same on a bright ground of its own, so that it is read wherever it stands.
  void label(const std::string& words, const Vec2& at, const Colour& c, double size_px = 15,
             double anchor = 0);
  void text_upwards(const std::string& words, const Vec2& middle, const Colour& c, double size_px,
                    const Colour& background);
  static double text_width(const std::string& words, double size_px);

  /// A bar of so many metres that ends at `right_end`, its length written before it.
  void scale_bar(const Vec2& right_end, double length_m, double px_per_m);

  void paste(const cv::Mat& bgr, const Vec2& corner);       ///< pixel for pixel
  void paste_over(const cv::Mat& bgr, const Vec2& corner);  ///< one that is as fine as the drawing
  /// What lies inside of the box alone, to be drawn on: pixels are half as big there.
  cv::Mat fine(const Vec2& low, const Vec2& high);

  cv::Mat shrunk() const;

 private:
  cv::Mat mat_;
};

/// The values along an axis, with some room beyond the lowest and the highest.
class AxisSpan {
 public:
  void take(double value);
  /// `share` of what was taken, either way; of one value, or none, a span of 2.
  void make_room(double share);
  double low() const { return low_; }
  double high() const { return high_; }
  /// From 0 at the low end to 1 at the high one.
  double share(double value) const { return (value - low_) / (high_ - low_); }

 private:
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
};

/// The round number (1, 2 or 5 times a power of ten) that divides a length into at most `most`
/// steps.
double round_step(double length, int most);

/// The multiples of a step from `low` to `high`.
std::vector<double> round_values(double low, double high, double step);

/// Without digits that nobody reads.
std::string short_number(double value);

}  // namespace panoptes
