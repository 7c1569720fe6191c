// SPDX-License-Identifier: BSD-3-Clause
#include "apps/recognition/recognition_picture.h"

#include <algorithm>
#include <cstdint>

#include <opencv2/imgproc.hpp>

#include "apps/draw/canvas.h"
#include "apps/draw/pictures.h"
#include "core/base/check.h"

namespace panoptes {
namespace {

constexpr int kPanel_px = 720;
constexpr double kMargin_px = 44;
constexpr double kHead_px = 48;
constexpr double kFoot_px = 64;

cv::Mat greys_of(const cv::Mat& distance) {
  double farthest = 0;
  cv::minMaxLoc(distance, nullptr, &farthest);
  cv::Mat grey(distance.size(), CV_8U, cv::Scalar(255));
  for (int row = 0; row < distance.rows; ++row) {
    for (int column = 0; column < row; ++column) {
      const double share = farthest > 0 ? distance.at<float>(row, column) / farthest : 0;
      grey.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(40 + 200 * share);
    }
  }
  cv::Mat panel;
  cv::resize(grey, panel, cv::Size(kPanel_px, kPanel_px), 0, 0,
             distance.rows < kPanel_px ? cv::INTER_NEAREST : cv::INTER_AREA);
  cv::Mat bgr;
  cv::cvtColor(panel, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

}  // namespace

cv::Mat draw_recognition(const RecognitionPicture& picture) {
  PANOPTES_CHECK(picture.distance.type() == CV_32F && picture.distance.rows > 0 &&
                     picture.distance.rows == picture.distance.cols,
                 "a row and a column a picture");
  Canvas canvas(static_cast<int>(kPanel_px + 2 * kMargin_px),
                static_cast<int>(kHead_px + kPanel_px + kFoot_px), kPaper);
  const Vec2 corner(kMargin_px, kHead_px);
  canvas.text(picture.title, {kMargin_px, 30}, kInk);
  canvas.paste(greys_of(picture.distance), corner);
  canvas.frame(corner, corner + Vec2(kPanel_px, kPanel_px), kFaint, 1);
  const double cell_px = static_cast<double>(kPanel_px) / picture.distance.rows;
  const double radius_px = std::clamp(cell_px / 2, 2.0, 5.0);
  for (const FoundPlace& found : picture.found) {
    const Vec2 at = corner + cell_px * Vec2(found.earlier + 0.5, found.picture + 0.5);
    canvas.disc(at, radius_px,
                !found.right   ? kLoopColour
                : *found.right ? kTruthColour
                               : kWrongColour);
  }
  canvas.text_upwards("picture", {kMargin_px / 2, kHead_px + kPanel_px / 2.0}, kInk, 15, kPaper);
  double x = kMargin_px;
  const double base = kHead_px + kPanel_px + 36;
  canvas.text("earlier picture; dark: alike at a glance", {x, base}, kInk);
  x += Canvas::text_width("earlier picture; dark: alike at a glance", 15) + 30;
  const auto entry = [&](const std::string& name, const Colour& colour) {
    canvas.disc({x, base - 5}, 5, colour);
    canvas.text(name, {x + 12, base}, kInk);
    x += 12 + Canvas::text_width(name, 15) + 20;
  };
  const bool judged = std::any_of(picture.found.begin(), picture.found.end(),
                                  [](const FoundPlace& found) { return found.right.has_value(); });
  entry(judged ? "not counted" : "the same place", kLoopColour);
  if (judged) {
    entry("rightly", kTruthColour);
    entry("wrongly", kWrongColour);
  }
  return canvas.shrunk();
}

}  // namespace panoptes
