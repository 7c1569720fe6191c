// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/upright_points.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/map/floor_flow.h"

namespace panoptes {
namespace {

constexpr double kStep_m = 0.04;  // pictures so far apart, or turned by so much, are looked at
constexpr double kStep_rad = deg_to_rad(4);
constexpr double kJump_m = 0.4;  // farther, and nothing is followed

constexpr int kMostTracks = 150;
constexpr int kApart_px = 8;
constexpr double kQuality = 0.02;  // of the strongest corner
constexpr int kWindow_px = 11;
constexpr int kLevels = 2;
constexpr double kNoise_px = 0.35;  // of a corner that is followed, at best
constexpr double kNoise_grey = 5;   // of its surroundings from one picture to the next
constexpr double kFarthest_m =
    8.0;  // a line of sight that meets the floor farther away says nothing
constexpr double kLongest_m = 0.8;   // of the path that a corner is followed along,
constexpr double kTurned_rad = 0.5;  // which turns it by no more than this
constexpr float kLeastGradient =
    1e-3F;  // of Lucas and Kanade's matrix: none is followed along an edge

// What grey tells of where a corner is (Lucas and Kanade), in square pixels: little along an edge.
Mat2 corner_covariance(const cv::Mat& grey, const cv::Point2f& px) {
  constexpr int kHalf = kWindow_px / 2;
  const int u0 = std::clamp(static_cast<int>(std::lround(px.x)), kHalf + 1, grey.cols - kHalf - 2);
  const int v0 = std::clamp(static_cast<int>(std::lround(px.y)), kHalf + 1, grey.rows - kHalf - 2);
  Mat2 gradients = Mat2::Zero();
  for (int v = v0 - kHalf; v <= v0 + kHalf; ++v) {
    const auto* above = grey.ptr<std::uint8_t>(v - 1);
    const auto* here = grey.ptr<std::uint8_t>(v);
    const auto* below = grey.ptr<std::uint8_t>(v + 1);
    for (int u = u0 - kHalf; u <= u0 + kHalf; ++u) {
      const Vec2 g(0.5 * (here[u + 1] - here[u - 1]), 0.5 * (below[u] - above[u]));
      gradients += g * g.transpose();
    }
  }
  gradients.diagonal().array() += 1e-6;
  return kNoise_px * kNoise_px * Mat2::Identity() + kNoise_grey * kNoise_grey * gradients.inverse();
}

constexpr double kUpright_m = 0.03;  // surely higher than this it stands up
constexpr double kSurely = 3;        // sigmas
constexpr double kOutlier = 9;       // chi-square of one degree
constexpr int kConfirmed = 3;
constexpr int kConfirmedAlone = 8;
constexpr double kVague_m = 0.06;  // a place known no better is of no use

constexpr double kSupport_m = 0.05;  // sightings nearer together are of one thing
constexpr int kSupport = 3;          // others that a place needs
constexpr int kNoTrack = 0;          // what another way of looking found

constexpr double kTaller = 1.25;
constexpr double kSame_m = 0.03;  // points nearer together are one
constexpr double kForgotten_m = 4;
constexpr double kForgotten_s = 20;
constexpr double kForgotten_rad = 2 * deg_to_rad(360);
constexpr double kOutOfReach_m = 4;
constexpr double kSuggested_m = 1;  // of driving, in which other pictures must agree

}  // namespace

UprightPoints::UprightPoints(std::shared_ptr<const FloorProjection> projection, double rate_hz)
    : projection_(std::move(projection)),
      forgotten_pictures_(static_cast<int>(std::lround(kForgotten_s * rate_hz))) {
  const FloorProjection& p = *projection_;
  H_px_view_ = p.H_view_px.inverse();
  const Vec2 ahead = p.foot_view + Vec2(1, 0);
  if ((H_px_view_ * ahead.homogeneous()).z() < 0) {
    H_px_view_ = -H_px_view_;
  }
}

std::optional<UprightPoints::Sight> UprightPoints::sight(const cv::Point2f& px,
                                                         const Mat2& covariance_px,
                                                         const Pose2& T_odom_view) const {
  const Mat3& H = projection_->H_view_px;
  const Vec3 h = H * Vec3(px.x, px.y, 1);
  const Vec2 p_view = h.hnormalized();
  // on this side of the horizon
  if ((H_px_view_ * p_view.homogeneous()).z() <= 0 ||
      (p_view - projection_->foot_view).norm() > kFarthest_m) {
    return std::nullopt;
  }
  const Mat2 by_px = (H.topLeftCorner<2, 2>() - p_view * H.bottomLeftCorner<1, 2>()) / h.z();
  const Mat2 by = T_odom_view.rotation() * by_px;
  return Sight{T_odom_view * p_view, by * covariance_px * by.transpose()};
}

// Whether the track is worth following on.
bool UprightPoints::judge(Track& track, const Sight& now, const Pose2& T_odom_body) {
  const double h = projection_->height_m;
  const Vec2 foot_odom = T_odom_body * projection_->T_body_view * projection_->foot_view;
  const Vec2 path = foot_odom - track.foot_odom;
  const double path_m = path.norm();
  if (path_m < kStep_m) {
    return true;
  }
  const Pose2 T_then_now = track.T_odom_body.inverse() * T_odom_body;
  if (std::abs(T_then_now.theta_rad) > kTurned_rad) {
    return false;
  }
  // what the wheels do not know of the way since then
  const Vec3 sigma = step_sigma(T_then_now);
  const Mat2 R = T_odom_body.rotation();
  const Vec2 lever = now.floor_odom - T_odom_body.position();
  const Vec2 by_turn(-lever.y(), lever.x());
  const Mat2 by_wheels = R * sigma.head<2>().cwiseAbs2().asDiagonal() * R.transpose() +
                         sigma.z() * sigma.z() * by_turn * by_turn.transpose();
  const Mat2 information = (track.first.covariance + now.covariance + by_wheels).inverse();
  const Vec2 off = now.floor_odom - track.first.floor_odom;
  const double shown = path.dot(information * path);
  const double slide = -path.dot(information * off) / shown;
  const double sigma_slide = 1 / std::sqrt(shown);
  const Vec2 rest = off + slide * path;
  if (rest.dot(information * rest) > kOutlier || slide < -kSurely * sigma_slide - 0.3) {
    return false;
  }
  track.slide = slide;
  const double least = slide - kSurely * sigma_slide;
  if (!(h * least > kUpright_m * (1 + least))) {
    track.confirmed = 0;
    return path_m < kLongest_m;
  }
  // what creeps along an edge stands here now and there then
  const double most = slide + kSurely * sigma_slide;
  track.low_slide = track.confirmed == 0 ? least : std::max(least, track.low_slide);
  track.high_slide = track.confirmed == 0 ? most : std::min(most, track.high_slide);
  if (track.low_slide > track.high_slide) {
    return false;
  }
  ++track.confirmed;
  const double share = 1 / (1 + slide);  // of the way from the camera to the floor
  const Vec2 sight = track.first.floor_odom - track.foot_odom;
  const double sigma_m = sight.norm() * share * share * sigma_slide;
  if (track.confirmed >= kConfirmed && sigma_m < kVague_m) {
    sighted({track.foot_odom + share * sight, h * (1 - share), sigma_m}, track.id, track.confirmed);
  }
  return path_m < kLongest_m;
}

// Notes it; it counts, and those that say so with it, once others say that something stands there.
void UprightPoints::sighted(const UprightPoint& point, int track, int confirmed) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < sightings_.size(); ++i) {
    const Sighting& other = sightings_[i];
    if ((other.track != track || track == kNoTrack) &&
        (other.point.p_odom - point.p_odom).squaredNorm() < kSupport_m * kSupport_m) {
      others.push_back(i);
    }
  }
  const bool supported = static_cast<int>(others.size()) >= kSupport;
  sightings_.push_back({point, track, picture_});
  const bool known = std::any_of(points_.begin(), points_.end(), [&](const UprightPoint& other) {
    return (other.p_odom - point.p_odom).squaredNorm() < kSame_m * kSame_m;
  });
  if (supported || known || confirmed >= kConfirmedAlone) {
    remember(point);
  }
  if (supported) {
    for (const std::size_t i : others) {
      if (!sightings_[i].counts) {
        remember(sightings_[i].point);
        sightings_[i].counts = true;
      }
    }
    sightings_.back().counts = true;
  }
}

void UprightPoints::remember(const UprightPoint& point) {
  const auto same = std::find_if(points_.begin(), points_.end(), [&](const UprightPoint& other) {
    return (other.p_odom - point.p_odom).squaredNorm() < kSame_m * kSame_m;
  });
  const Remembered now{driven_m_, turned_rad_, picture_, point.height_m};
  if (same == points_.end()) {
    points_.push_back(point);
    remembered_.push_back(now);
    new_.push_back(point);
    return;
  }
  Remembered& known = remembered_[static_cast<std::size_t>(same - points_.begin())];
  const double height_m = std::max(same->height_m, point.height_m);
  if (point.sigma_m < same->sigma_m) {
    *same = point;
  }
  same->height_m = height_m;
  const double told_m = known.told_height_m;
  known = now;
  known.told_height_m = told_m;
  if (height_m > kTaller * told_m) {  // and hides more
    known.told_height_m = height_m;
    new_.push_back(*same);
  }
}

void UprightPoints::suggest(const std::vector<UprightPoint>& points) {
  const std::size_t before = suggested_.size();
  for (const UprightPoint& point : points) {
    if (point.sigma_m >= kVague_m) {
      continue;
    }
    UprightPoint mean = point;
    double information = 1 / (point.sigma_m * point.sigma_m);
    mean.p_odom *= information;
    double seen_m = -1;
    int agreeing = 1;
    for (std::size_t i = 0; i < before; ++i) {
      const UprightPoint& other = suggested_[i];
      if ((other.p_odom - point.p_odom).norm() > 1.5 * std::hypot(other.sigma_m, point.sigma_m)) {
        continue;
      }
      const double weight = 1 / (other.sigma_m * other.sigma_m);
      mean.p_odom += weight * other.p_odom;
      mean.height_m = std::max(mean.height_m, other.height_m);  // it reaches at least as high
      information += weight;
      agreeing += suggested_at_[i].driven_m > seen_m ? 1 : 0;  // once for each picture
      seen_m = suggested_at_[i].driven_m;
    }
    if (agreeing >= kConfirmed) {
      sighted({mean.p_odom / information, mean.height_m,
               std::sqrt(static_cast<double>(agreeing) / information)},
              kNoTrack, agreeing);
    }
    suggested_.push_back(point);
    suggested_at_.push_back({driven_m_, turned_rad_, picture_, point.height_m});
  }
}

void UprightPoints::forget(const Vec2& robot_odom) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (picture_ - remembered_[i].picture < forgotten_pictures_ &&
        driven_m_ - remembered_[i].driven_m < kForgotten_m &&
        turned_rad_ - remembered_[i].turned_rad < kForgotten_rad &&
        (points_[i].p_odom - robot_odom).norm() < kOutOfReach_m) {
      points_[kept] = points_[i];
      remembered_[kept++] = remembered_[i];
    }
  }
  points_.resize(kept);
  remembered_.resize(kept);
  const auto late = std::find_if(
      sightings_.begin(), sightings_.end(),
      [&](const Sighting& sighting) { return picture_ - sighting.picture < forgotten_pictures_; });
  sightings_.erase(sightings_.begin(), late);
  std::size_t old = 0;
  while (old < suggested_.size() && driven_m_ - suggested_at_[old].driven_m > kSuggested_m) {
    ++old;
  }
  suggested_.erase(suggested_.begin(), suggested_.begin() + static_cast<std::ptrdiff_t>(old));
  suggested_at_.erase(suggested_at_.begin(),
                      suggested_at_.begin() + static_cast<std::ptrdiff_t>(old));
}

void UprightPoints::follow(const cv::Mat& grey, const Pose2& T_odom_body) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(grey, pyramid, {kWindow_px, kWindow_px}, kLevels);
  if (!tracks_.empty()) {
    const Pose2 T_odom_view = T_odom_body * projection_->T_body_view;
    const Pose2 T_view_odom = T_odom_view.inverse();
    const Vec2 foot_odom = T_odom_view * projection_->foot_view;
    std::vector<cv::Point2f> from;
    std::vector<cv::Point2f> to;
    for (const Track& track : tracks_) {
      const Vec2 expected =
          T_view_odom * (track.first.floor_odom - track.slide * (foot_odom - track.foot_odom));
      const Vec3 px = H_px_view_ * expected.homogeneous();
      from.push_back(track.px);
      to.push_back(px.z() > 0 ? cv::Point2f(static_cast<float>(px.x() / px.z()),
                                            static_cast<float>(px.y() / px.z()))
                              : track.px);
    }
    std::vector<std::uint8_t> found;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(pyramid_, pyramid, from, to, found, error, {kWindow_px, kWindow_px},
                             kLevels, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 10, 0.03},
                             cv::OPTFLOW_USE_INITIAL_FLOW, kLeastGradient);
    std::vector<Track> kept;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      Track& track = tracks_[i];
      track.px = to[i];
      const bool inside = track.px.x >= 0 && track.px.y >= 0 &&
                          track.px.x <= static_cast<float>(grey.cols - 1) &&
                          track.px.y <= static_cast<float>(grey.rows - 1);
      if (found[i] == 0 || !inside) {
        continue;
      }
      const std::optional<Sight> now = sight(track.px, track.covariance_px, T_odom_view);
      if (now && judge(track, *now, T_odom_body)) {
        kept.push_back(track);
      }
    }
    tracks_ = std::move(kept);
  }
  pyramid_ = std::move(pyramid);
}

void UprightPoints::find_new(const cv::Mat& grey, const Pose2& T_odom_body) {
  constexpr int kEnough = 2 * kMostTracks / 3;
  if (tracks_.size() >= kEnough) {
    return;
  }
  cv::Mat1b mask(grey.size(), 255);
  for (const Track& track : tracks_) {
    cv::circle(mask, track.px, kApart_px, 0, cv::FILLED);
  }
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(grey, corners, kMostTracks - static_cast<int>(tracks_.size()), kQuality,
                          kApart_px, mask);
  const Pose2 T_odom_view = T_odom_body * projection_->T_body_view;
  const Vec2 foot_odom = T_odom_view * projection_->foot_view;
  for (const cv::Point2f& px : corners) {
    const Mat2 covariance_px = corner_covariance(grey, px);
    if (const std::optional<Sight> first = sight(px, covariance_px, T_odom_view)) {
      tracks_.push_back({*first, T_odom_body, foot_odom, px, covariance_px, 0, ++last_track_});
    }
  }
}

std::vector<UprightPoint> UprightPoints::add(const cv::Mat& bgr, const Pose2& T_odom_body) {
  ++picture_;
  forget(T_odom_body.position());
  if (T_odom_last_) {
    const Pose2 T_last_now = T_odom_last_->inverse() * T_odom_body;
    const double moved_m = T_last_now.position().norm();
    const double turned_rad = std::abs(T_last_now.theta_rad);
    if (moved_m < kStep_m && turned_rad < kStep_rad) {
      return {};
    }
    driven_m_ += moved_m;
    turned_rad_ += turned_rad;
    if (moved_m > kJump_m) {
      tracks_.clear();
    }
  }
  T_odom_last_ = T_odom_body;
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  follow(grey, T_odom_body);
  find_new(grey, T_odom_body);
  return std::exchange(new_, {});
}

}  // namespace panoptes
