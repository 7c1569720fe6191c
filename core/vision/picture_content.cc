// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/picture_content.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <opencv2/imgproc.hpp>

namespace panoptes {
namespace {

constexpr int kCellsAcross = 16;
constexpr double kFine_px = 1;            // what the tests of a feature are smoothed by, about
constexpr double kCoarse_px = 4;          // four times that
constexpr float kLeastNoise_grey = 0.5F;  // rounding to grey levels, and to JPEG's blocks
// White noise alone, in a cell of some twenty independent gradients, exceeds three times its mean
// square once in a million.
constexpr float kBeyondNoise = 3;
constexpr float kUsual = 0.25F;  // of the usual steepness: contrasts vary so much within a run
// Steepness at 1 px to that at 4 px, of edges blurred by b px, is as the root of
// (16 + b^2) / (1 + b^2): of the usual 0.5 px this share is left at 1.7 px, the size of the
// coarsest features. Beyond it none is found again.
constexpr float kSharp = 0.6F;
constexpr double kLeastShare = 0.2;  // of the usual number of cells
constexpr std::size_t kLeastCells = 6;
constexpr int kBright_grey = 250;
constexpr int kDark_grey = 16;
constexpr double kMostSaturated = 0.5;

float quantile(std::vector<float> values, double share) {
  if (values.empty()) {
    return 0;
  }
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<cv::Rect> cells_of(cv::Size size) {
  const int side = std::max(4, size.width / kCellsAcross);
  std::vector<cv::Rect> cells;
  for (int y = 0; y + side <= size.height; y += side) {
    for (int x = 0; x + side <= size.width; x += side) {
      cells.emplace_back(x, y, side, side);
    }
  }
  return cells;
}

// Of white noise, by what is left of second differences both ways (Immerkaer 1996), in the
// smoothest cells: elsewhere it is texture.
float noise_grey(const cv::Mat& grey, const std::vector<cv::Rect>& cells) {
  const cv::Mat kernel = (cv::Mat_<float>(3, 3) << 1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat rest;
  cv::filter2D(grey, rest, CV_32F, kernel);
  rest = cv::abs(rest);
  std::vector<float> sigmas;
  for (const cv::Rect& cell : cells) {
    const double middle = cv::mean(grey(cell))[0];
    if (middle > kDark_grey && middle < kBright_grey) {  // clipped, noise is gone
      sigmas.push_back(
          static_cast<float>(std::sqrt(std::numbers::pi / 2) * cv::mean(rest(cell))[0] / 6));
    }
  }
  return std::max(kLeastNoise_grey, quantile(sigmas, 0.2));
}

// The root of the structure tensor's smaller eigenvalue; nothing below what noise explains.
std::vector<float> steepness(const cv::Mat& grey, const std::vector<cv::Rect>& cells,
                             double scale_px, float noise_grey) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, cv::Size(), scale_px);
  smooth.convertTo(smooth, CV_32F);
  cv::Mat dx;
  cv::Mat dy;
  const cv::Mat along = (cv::Mat_<float>(1, 3) << -0.5F, 0, 0.5F);
  cv::filter2D(smooth, dx, CV_32F, along);
  cv::filter2D(smooth, dy, CV_32F, along.t());
  const cv::Mat xx = dx.mul(dx);
  const cv::Mat xy = dx.mul(dy);
  const cv::Mat yy = dy.mul(dy);
  // the mean square of a derivative of Gaussian-smoothed white noise
  const double of_noise = noise_grey * noise_grey / (8 * std::numbers::pi * std::pow(scale_px, 4));
  std::vector<float> found;
  for (const cv::Rect& cell : cells) {
    const double a = cv::mean(xx(cell))[0];
    const double b = cv::mean(xy(cell))[0];
    const double c = cv::mean(yy(cell))[0];
    const double least = 0.5 * (a + c) - std::hypot(0.5 * (a - c), b);
    found.push_back(
        least > kBeyondNoise * of_noise ? static_cast<float>(std::sqrt(least - of_noise)) : 0.0F);
  }
  return found;
}

float sharpness(const PictureContent& picture) {
  return picture.coarse_grey_px > 0 ? picture.fine_grey_px / picture.coarse_grey_px : 0;
}

double share_of(const cv::Mat& mask) {
  return cv::countNonZero(mask) / static_cast<double>(mask.total());
}

}  // namespace

PictureContent picture_content(const cv::Mat& grey) {
  PictureContent content;
  const std::vector<cv::Rect> cells = cells_of(grey.size());
  const float noise = noise_grey(grey, cells);
  content.corners_grey_px = steepness(grey, cells, kFine_px, noise);
  content.fine_grey_px = quantile(content.corners_grey_px, 0.75);
  content.coarse_grey_px = quantile(steepness(grey, cells, kCoarse_px, noise), 0.75);
  content.bright_share = share_of(grey >= kBright_grey);
  content.dark_share = share_of(grey <= kDark_grey);
  return content;
}

std::vector<PictureFault> picture_faults(const std::vector<const PictureContent*>& pictures) {
  std::vector<float> steep;
  std::vector<float> sharp;
  std::vector<float> coarse;
  for (const PictureContent* picture : pictures) {
    steep.push_back(picture->fine_grey_px);
    sharp.push_back(sharpness(*picture));
    coarse.push_back(picture->coarse_grey_px);
  }
  const float least_steep = kUsual * quantile(steep, 0.5);
  const float least_sharp = kSharp * quantile(sharp, 0.5);
  const float least_coarse = kUsual * quantile(coarse, 0.5);
  std::vector<float> cells;
  for (const PictureContent* picture : pictures) {
    cells.push_back(static_cast<float>(
        std::count_if(picture->corners_grey_px.begin(), picture->corners_grey_px.end(),
                      [least_steep](float steepness) { return steepness > least_steep; })));
  }
  const double least =
      std::max(static_cast<double>(kLeastCells), kLeastShare * quantile(cells, 0.5));
  std::vector<PictureFault> faults;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const PictureContent& picture = *pictures[i];
    const bool soft = sharpness(picture) < least_sharp;
    const bool empty = cells[i] < least;
    faults.push_back(!empty && !soft                                 ? PictureFault::kNone
                     : picture.bright_share > kMostSaturated         ? PictureFault::kOverExposed
                     : picture.dark_share > kMostSaturated           ? PictureFault::kDark
                     : soft && picture.coarse_grey_px > least_coarse ? PictureFault::kBlurred
                                                                     : PictureFault::kBlank);
  }
  return faults;
}

}  // namespace panoptes
