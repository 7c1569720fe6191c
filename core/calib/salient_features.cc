// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/salient_features.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#if __has_include(<opencv2/xfeatures2d/nonfree.hpp>)
#include <opencv2/xfeatures2d/nonfree.hpp>
#define PANOPTES_HAS_SURF
#endif

#include "core/base/check.h"
#include "core/base/error.h"

namespace panoptes {
namespace {

constexpr int kOctaves = 2;
constexpr int kMost = 10000;
// Around an area or a feature, for the filters that reach out of it.
constexpr int kBorder_px = 32;

cv::Ptr<cv::Feature2D> detector(FeatureMethod method) {
  switch (method) {
    case FeatureMethod::kSift:
      return cv::SIFT::create();
    case FeatureMethod::kAkaze:
      return cv::AKAZE::create(cv::AKAZE::DESCRIPTOR_KAZE_UPRIGHT, 0, 3, 0.0005F, kOctaves);
    case FeatureMethod::kOrb:
      // Steps of the eighth root of 4: two octaves.
      return cv::ORB::create(kMost, 1.189207F, 8, 16, 0, 2, cv::ORB::HARRIS_SCORE, 31, 6);
    case FeatureMethod::kSurf:
#ifdef PANOPTES_HAS_SURF
      return cv::xfeatures2d::SURF::create(100, kOctaves);
#else
      break;
#endif
  }
  throw ConfigError(feature_method_fault(method));
}

// SIFT numbers its octaves from -1, the picture doubled, in the lowest byte.
int octave_of(FeatureMethod method, int packed) {
  return method == FeatureMethod::kSift  ? static_cast<std::int8_t>(packed & 255) + 1
         : method == FeatureMethod::kOrb ? 0
                                         : packed;
}

cv::Rect around(const cv::Mat& picture, const cv::Rect& area) {
  return cv::Rect(area.x - kBorder_px, area.y - kBorder_px, area.width + 2 * kBorder_px,
                  area.height + 2 * kBorder_px) &
         cv::Rect(0, 0, picture.cols, picture.rows);
}

}  // namespace

std::string_view name(FeatureMethod method) {
  switch (method) {
    case FeatureMethod::kSift:
      return "sift";
    case FeatureMethod::kAkaze:
      return "akaze";
    case FeatureMethod::kOrb:
      return "orb";
    case FeatureMethod::kSurf:
      return "surf";
  }
  return "";
}

std::string feature_method_fault(FeatureMethod method) {
#ifdef PANOPTES_HAS_SURF
  (void)method;
  return {};
#else
  return method == FeatureMethod::kSurf
             ? "surf is not built in: this OpenCV lacks xfeatures2d; akaze is the nearest to it"
             : "";
#endif
}

std::vector<SalientFeature> salient_features(FeatureMethod method, const cv::Mat& grey,
                                             const cv::Rect& area) {
  PANOPTES_CHECK(grey.type() == CV_8U, "features are found in grey pictures");
  const cv::Rect with_border = around(grey, area);
  std::vector<cv::KeyPoint> found;
  detector(method)->detect(grey(with_border), found);
  std::vector<SalientFeature> features;
  for (const cv::KeyPoint& point : found) {
    const Vec2 px(point.pt.x + with_border.x, point.pt.y + with_border.y);
    if (octave_of(method, point.octave) < kOctaves && px.x() >= area.x && px.y() >= area.y &&
        px.x() < area.x + area.width && px.y() < area.y + area.height) {
      features.push_back({px, point.size, deg_to_rad(point.angle), point.response, point.octave});
    }
  }
  std::sort(features.begin(), features.end(), [](const SalientFeature& a, const SalientFeature& b) {
    return a.saliency != b.saliency ? a.saliency > b.saliency
           : a.px.y() != b.px.y()   ? a.px.y() < b.px.y()
           : a.px.x() != b.px.x()   ? a.px.x() < b.px.x()
                                    : a.angle_rad < b.angle_rad;
  });
  return features;
}

cv::Mat describe(FeatureMethod method, const cv::Mat& grey, const SalientFeature& feature) {
  // As far as the descriptor's window may reach.
  const int reach = static_cast<int>(std::ceil(6 * feature.size_px));
  const cv::Rect window = around(
      grey, cv::Rect(static_cast<int>(feature.px.x()) - reach,
                     static_cast<int>(feature.px.y()) - reach, 2 * reach + 1, 2 * reach + 1));
  std::vector<cv::KeyPoint> point{cv::KeyPoint(
      static_cast<float>(feature.px.x() - window.x), static_cast<float>(feature.px.y() - window.y),
      static_cast<float>(feature.size_px), static_cast<float>(rad_to_deg(feature.angle_rad)),
      static_cast<float>(feature.saliency), feature.octave, 0)};
  cv::Mat row;
  detector(method)->compute(grey(window), point, row);
  if (method == FeatureMethod::kSift && !row.empty()) {
    row /= std::max(1.0, cv::norm(row, cv::NORM_L1));
    cv::sqrt(row, row);
  }
  return row;
}

}  // namespace panoptes
