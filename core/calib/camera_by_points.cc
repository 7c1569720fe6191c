// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/camera_by_points.h"

#include <algorithm>
#include <limits>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr std::size_t kMostFeatures = 300;  // of a picture
constexpr double kRatio = 0.8;              // of the nearest descriptor to the second (Lowe 2004)
constexpr int kFewestInliers = 8;           // three of them give a pose, the others confirm it
constexpr double kInlier_px = 2;
constexpr int kHypotheses = 2000;
// Of the matches: less than that, agreeing, would be a copy of what is looked for.
constexpr double kLeastShare = 0.2;

}  // namespace

std::optional<Pose3> camera_by_points(FeatureMethod method, const Intrinsics& lens,
                                      const cv::Mat& grey, const std::vector<KnownPoint>& known) {
  std::vector<SalientFeature> features =
      salient_features(method, grey, cv::Rect(0, 0, grey.cols, grey.rows));
  features.resize(std::min(features.size(), kMostFeatures));
  const int norm = method == FeatureMethod::kOrb ? cv::NORM_HAMMING : cv::NORM_L2;
  // For each known point the feature that looks most like it, of those that look like no other.
  struct Match {
    double distance = std::numeric_limits<double>::infinity();
    Vec3 direction = Vec3::Zero();
  };
  std::vector<Match> matches(known.size());
  for (const SalientFeature& feature : features) {
    const std::optional<Vec3> direction = lens.direction(feature.px);
    const cv::Mat descriptor = describe(method, grey, feature);
    if (!direction || direction->z() <= 0 || descriptor.empty()) {
      continue;
    }
    double nearest = std::numeric_limits<double>::infinity();
    double second = nearest;
    std::size_t of = 0;
    for (std::size_t i = 0; i < known.size(); ++i) {
      const double distance = cv::norm(descriptor, known[i].descriptor, norm);
      if (distance < nearest) {
        second = nearest;
        nearest = distance;
        of = i;
      } else {
        second = std::min(second, distance);
      }
    }
    if (nearest < kRatio * second && nearest < matches[of].distance) {
      matches[of] = {nearest, *direction};
    }
  }
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> rays;  // where a pinhole of focal length 1 would draw them
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (const Vec3& ray = matches[i].direction; ray.z() > 0) {
      const Vec3& p = known[i].p_map;
      points.emplace_back(p.x(), p.y(), p.z());
      rays.emplace_back(ray.x() / ray.z(), ray.y() / ray.z());
    }
  }
  if (points.size() < kFewestInliers) {
    return std::nullopt;
  }
  cv::Mat rotation;
  cv::Mat translation;
  std::vector<int> inliers;
  const bool solved = cv::solvePnPRansac(
      points, rays, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotation, translation, false,
      kHypotheses, static_cast<float>(kInlier_px / lens.fx_px), 0.999, inliers, cv::SOLVEPNP_P3P);
  if (!solved || inliers.size() < kFewestInliers ||
      static_cast<double>(inliers.size()) < kLeastShare * static_cast<double>(points.size())) {
    return std::nullopt;
  }
  const Vec3 turn(rotation.at<double>(0), rotation.at<double>(1), rotation.at<double>(2));
  const Pose3 T_camera_map{
      turned_by(turn),
      Vec3(translation.at<double>(0), translation.at<double>(1), translation.at<double>(2))};
  return T_camera_map.inverse();
}

}  // namespace panoptes
