// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/map_alignment.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <opencv2/features2d.hpp>

#include "core/base/median.h"
#include "core/calib/reprojection_cost.h"
#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

constexpr double kLeastNoise_px = 0.05;
// No map of one camera is as straight as its points are sharp.
constexpr double kBent = 0.01;      // of how far a point is from the middle of the camera's path
constexpr double kMostSigma = 0.1;  // likewise
constexpr double kInlierSigmas = 3;

/// How well keyframes know a point, by where they show it; empty where they do not tell its depth.
std::optional<Mat3> known_by(const std::vector<std::pair<Pose3, Vec2>>& seen,
                             const Intrinsics& lens, const Vec3& p_map, double sigma_px) {
  Mat3 information = Mat3::Zero();
  for (const auto& [T_map_camera, px] : seen) {
    const Pose3 T_camera_map = T_map_camera.inverse();
    const Vec3 p_camera = T_camera_map * p_map;
    if (!can_draw(lens, p_camera)) {
      continue;
    }
    const Projection drawn = project_with_jacobian(lens, p_camera);
    if ((drawn.px - px).norm() < kInlierSigmas * std::sqrt(2.0) * sigma_px) {
      const Eigen::Matrix<double, 2, 3> J =
          drawn.px_by_point * T_camera_map.rotation.toRotationMatrix() / sigma_px;
      information += J.transpose() * J;
    }
  }
  constexpr double kNothing = 1e-12;
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(information);
  if (!(eigen.eigenvalues()[0] > kNothing * eigen.eigenvalues()[2])) {
    return std::nullopt;
  }
  return Mat3(information.ldlt().solve(Mat3::Identity()));
}

}  // namespace

std::vector<DescribedPoint> described_points(FeatureMethod method, const MonoMap& map,
                                             const AdjustedMap& adjusted,
                                             const std::function<cv::Mat(int frame)>& picture) {
  std::map<int, Pose3> T_map_camera;  // by frame
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < adjusted.T_map_camera.size(); ++i) {
    T_map_camera[adjusted.keyframes[i]] = adjusted.T_map_camera[i];
    middle += adjusted.T_map_camera[i].translation / static_cast<double>(adjusted.keyframes.size());
  }
  const double sigma_px = std::max(kLeastNoise_px, adjusted.rms_after_px / std::sqrt(2.0));
  std::vector<DescribedPoint> points;
  std::map<int, std::vector<std::pair<std::size_t, const MonoMap::Point*>>> of_frame;
  auto next = map.points.begin();
  for (std::size_t i = 0; i < adjusted.points.size(); ++i) {
    const AdjustedMap::Point& point = adjusted.points[i];
    next = std::find_if(next, map.points.end(),
                        [&](const MonoMap::Point& each) { return each.number == point.number; });
    if (next == map.points.end() || point.observations < 2) {
      continue;
    }
    std::vector<std::pair<Pose3, Vec2>> seen;
    for (const MonoMap::Seen& each : next->seen) {
      if (const auto keyframe = T_map_camera.find(each.frame); keyframe != T_map_camera.end()) {
        seen.emplace_back(keyframe->second, each.px);
      }
    }
    const double far = (point.p_map - middle).norm();
    const std::optional<Mat3> covariance = known_by(seen, adjusted.lens, point.p_map, sigma_px);
    if (covariance && std::sqrt(covariance->trace()) < kMostSigma * far) {
      const double bent = kBent * far;
      if (next->descriptor.empty()) {  // a map that was kept has none
        of_frame[next->seen.front().frame].emplace_back(points.size(), &*next);
      }
      points.push_back(
          {i, point.p_map, *covariance + bent * bent * Mat3::Identity(), next->descriptor});
    }
  }
  for (const auto& [frame, first_seen] : of_frame) {
    const cv::Mat grey = picture(frame);
    for (const auto& [at, point] : first_seen) {
      points[at].descriptor = describe(method, grey, point->feature);
    }
  }
  std::erase_if(points, [](const DescribedPoint& point) { return point.descriptor.empty(); });
  return points;
}

LooksOptions LooksOptions::of(FeatureMethod method) {
  LooksOptions options;
  switch (method) {
    case FeatureMethod::kSift:
      options.most_apart = 0.5;
      break;
    case FeatureMethod::kAkaze:
    case FeatureMethod::kSurf:
      options.most_apart = 0.4;
      break;
    case FeatureMethod::kOrb:
      options.most_apart = 64;  // of 256 bits
      break;
  }
  return options;
}

std::vector<std::pair<std::size_t, std::size_t>> alike_points(
    const LooksOptions& options, const std::vector<DescribedPoint>& a,
    const std::vector<DescribedPoint>& b) {
  std::vector<std::pair<std::size_t, std::size_t>> alike;
  if (a.empty() || b.size() < 2) {
    return alike;
  }
  const auto rows = [](const std::vector<DescribedPoint>& points) {
    cv::Mat all;
    for (const DescribedPoint& point : points) {
      all.push_back(point.descriptor);
    }
    return all;
  };
  const cv::Mat of_a = rows(a);
  const cv::BFMatcher matcher(of_a.depth() == CV_8U ? cv::NORM_HAMMING : cv::NORM_L2);
  std::vector<std::vector<cv::DMatch>> nearest;
  matcher.knnMatch(of_a, rows(b), nearest, 2);
  std::map<int, cv::DMatch> best;  // by the point of b
  for (const std::vector<cv::DMatch>& two : nearest) {
    if (two[0].distance < options.most_apart &&
        two[0].distance < options.ratio * static_cast<double>(two[1].distance)) {
      const auto [at, is_new] = best.emplace(two[0].trainIdx, two[0]);
      if (!is_new && two[0].distance < at->second.distance) {
        at->second = two[0];
      }
    }
  }
  for (const auto& [at, match] : best) {
    alike.emplace_back(static_cast<std::size_t>(match.queryIdx), static_cast<std::size_t>(at));
  }
  std::sort(alike.begin(), alike.end());
  return alike;
}

MapAlignment align_maps(const LooksOptions& looks, const SimilarityOptions& options, std::size_t a,
                        std::size_t b, const std::vector<std::vector<DescribedPoint>>& maps,
                        const Rng& rng) {
  MapAlignment out{a, b, alike_points(looks, maps[a], maps[b]), {}, 0};
  std::vector<PointPair> pairs;
  for (const auto& [of_a, of_b] : out.alike) {
    const DescribedPoint& in_a = maps[a][of_a];
    const DescribedPoint& in_b = maps[b][of_b];
    pairs.push_back({in_a.p_map, in_b.p_map, in_a.covariance, in_b.covariance});
  }
  out.agreed = agreed_similarity(options, pairs, rng.fork(fmt::format("maps {} {}", a, b)));
  std::vector<double> far;
  for (const std::size_t i : out.agreed.agree) {
    far.push_back(pairs[i].in_a.norm());
  }
  out.far = far.empty() ? 0 : median(std::move(far));
  return out;
}

}  // namespace panoptes
