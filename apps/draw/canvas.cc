// SPDX-License-Identifier: BSD-3-Clause
#include "apps/draw/canvas.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/io/digits.h"

namespace panoptes {
namespace {

constexpr int kOver = Canvas::kOver;
constexpr int kShift = 4;  // fractional bits of OpenCV's line coordinates
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

cv::Scalar scalar(const Colour& c) { return {double(c.b), double(c.g), double(c.r)}; }

double scale(double size_px) { return size_px * kOver / 30.0; }  // capitals are 21/30 high
int weight(double size_px) { return size_px > 17 ? 3 : 2; }
int thick(double width) { return std::max(1, static_cast<int>(std::lround(width * kOver))); }
int fixed_length(double v) { return static_cast<int>(std::lround(v * kOver * (1 << kShift))); }
cv::Point fixed(const Vec2& p) { return {fixed_length(p.x()), fixed_length(p.y())}; }
cv::Point whole(const Vec2& p) {
  return {static_cast<int>(std::lround(p.x() * kOver)),
          static_cast<int>(std::lround(p.y() * kOver))};
}

}  // namespace

Canvas::Canvas(int width, int height, const Colour& background)
    : mat_(height * kOver, width * kOver, CV_8UC3, scalar(background)) {}

void Canvas::line(const Vec2& a, const Vec2& b, const Colour& c, double width) {
  cv::line(mat_, fixed(a), fixed(b), scalar(c), thick(width), cv::LINE_AA, kShift);
}

void Canvas::polyline(const std::vector<Vec2>& points, const Colour& c, double width) {
  std::vector<cv::Point> fixed_points;
  fixed_points.reserve(points.size());
  for (const Vec2& p : points) {
    fixed_points.push_back(fixed(p));
  }
  if (fixed_points.size() > 1) {
    cv::polylines(mat_, fixed_points, false, scalar(c), thick(width), cv::LINE_AA, kShift);
  }
}

void Canvas::polygon(const std::vector<Vec2>& corners, const Colour& fill) {
  std::vector<cv::Point> fixed_points;
  fixed_points.reserve(corners.size());
  for (const Vec2& p : corners) {
    fixed_points.push_back(fixed(p));
  }
  cv::fillConvexPoly(mat_, fixed_points, scalar(fill), cv::LINE_AA, kShift);
}

void Canvas::cross(const Vec2& centre, double radius, const Colour& c, double width) {
  for (const double up : {-radius, radius}) {
    line(centre + Vec2(-radius, up), centre + Vec2(radius, -up), c, width);
  }
}

void Canvas::disc(const Vec2& centre, double radius, const Colour& c) {
  cv::circle(mat_, fixed(centre), fixed_length(radius), scalar(c), cv::FILLED, cv::LINE_AA, kShift);
}

void Canvas::ring(const Vec2& centre, double radius, const Colour& c, double width) {
  cv::circle(mat_, fixed(centre), fixed_length(radius), scalar(c), thick(width), cv::LINE_AA,
             kShift);
}

void Canvas::box(const Vec2& low, const Vec2& high, const Colour& c) {
  cv::rectangle(mat_, whole(low), whole(high), scalar(c), cv::FILLED);
}

void Canvas::frame(const Vec2& low, const Vec2& high, const Colour& c, double width) {
  cv::rectangle(mat_, whole(low), whole(high), scalar(c), thick(width));
}

void Canvas::text(const std::string& words, const Vec2& at, const Colour& c, double size_px,
                  double anchor) {
  const Vec2 left = at - Vec2(anchor * text_width(words, size_px), 0);
  cv::putText(mat_, words, whole(left), kFont, scale(size_px), scalar(c), weight(size_px),
              cv::LINE_AA);
}

void Canvas::label(const std::string& words, const Vec2& at, const Colour& c, double size_px,
                   double anchor) {
  const double width_px = text_width(words, size_px);
  const Vec2 left = at - Vec2(anchor * width_px, 0);
  const Vec2 margin(3, 3);
  box(left - margin - Vec2(0, 0.72 * size_px), left + margin + Vec2(width_px, 0.1 * size_px),
      kPaper);
  text(words, left, c, size_px);
}

void Canvas::text_upwards(const std::string& words, const Vec2& middle, const Colour& c,
                          double size_px, const Colour& background) {
  const int width = static_cast<int>(text_width(words, size_px) * kOver) + 8;
  const int height = static_cast<int>(size_px * kOver * 1.6);
  cv::Mat upright(height, width, CV_8UC3, scalar(background));
  cv::putText(upright, words, {4, static_cast<int>(size_px * kOver * 1.1)}, kFont, scale(size_px),
              scalar(c), weight(size_px), cv::LINE_AA);
  cv::rotate(upright, upright, cv::ROTATE_90_COUNTERCLOCKWISE);
  const cv::Rect at(whole(middle).x - upright.cols / 2, whole(middle).y - upright.rows / 2,
                    upright.cols, upright.rows);
  if ((at & cv::Rect(0, 0, mat_.cols, mat_.rows)) == at) {
    upright.copyTo(mat_(at));
  }
}

double Canvas::text_width(const std::string& words, double size_px) {
  int below = 0;
  return cv::getTextSize(words, kFont, scale(size_px), weight(size_px), &below).width /
         double(kOver);
}

void Canvas::scale_bar(const Vec2& right_end, double length_m, double px_per_m) {
  const Vec2 left_end = right_end - Vec2(length_m * px_per_m, 0);
  const Vec2 up(0, 5);
  const Vec2 half(0, 6);
  line(left_end - up, right_end - up, kInk, 2);
  line(left_end - up - half, left_end - up + half, kInk, 2);
  line(right_end - up - half, right_end - up + half, kInk, 2);
  text(short_number(length_m) + " m", left_end - Vec2(10, 0), kInk, 15, 1);
}

void Canvas::paste(const cv::Mat& bgr, const Vec2& corner) {
  cv::Mat finer;
  cv::resize(bgr, finer, {}, kOver, kOver, cv::INTER_NEAREST);
  paste_over(finer, corner);
}

void Canvas::paste_over(const cv::Mat& bgr, const Vec2& corner) {
  bgr.copyTo(mat_(cv::Rect(whole(corner), bgr.size())));
}

cv::Mat Canvas::fine(const Vec2& low, const Vec2& high) {
  return mat_(cv::Rect(whole(low), whole(high)));
}

cv::Mat Canvas::shrunk() const {
  cv::Mat result;
  cv::resize(mat_, result, {mat_.cols / kOver, mat_.rows / kOver}, 0, 0, cv::INTER_AREA);
  return result;
}

void AxisSpan::take(double value) {
  low_ = std::min(low_, value);
  high_ = std::max(high_, value);
}

void AxisSpan::make_room(double share) {
  if (!(high_ > low_)) {
    const double middle = high_ == low_ ? low_ : 0;
    low_ = middle - 1;
    high_ = middle + 1;
  }
  const double room = share * (high_ - low_);
  low_ -= room;
  high_ += room;
}

double round_step(double length, int most) {
  const double decade = std::pow(10.0, std::floor(std::log10(length / most)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (step * decade * most >= length * (1 - 1e-9)) {
      return step * decade;
    }
  }
  return 10 * decade;
}

std::vector<double> round_values(double low, double high, double step) {
  std::vector<double> values;
  for (double i = std::ceil(low / step); i * step <= high + 1e-9; ++i) {
    values.push_back(i * step);
  }
  return values;
}

std::string short_number(double value) { return shortest(std::round(value * 1e6) / 1e6); }

}  // namespace panoptes
