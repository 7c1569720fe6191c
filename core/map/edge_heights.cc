// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/edge_heights.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace panoptes {
namespace {

constexpr double kStep_m = 0.08;    // of driving between the pictures that are compared,
constexpr double kLongest_m = 1.2;  // and from the first to the last: wheels drift
constexpr double kWheels = 0.01;    // of the way
constexpr double kWheels_m = 0.003;
constexpr int kRayStride = 2;
constexpr int kShares = 3;  // a picture's rays are looked at in so many calls

constexpr int kContrast = 6;        // of the scan's 32, across an edge
constexpr double kNoise_px = 0.5;   // of its place
constexpr double kOther = 4.5;      // nats, three sigmas: this is another edge
constexpr double kSame = 2;         // two sigmas: it is this one
constexpr int kViews = 4;           // that must agree,
constexpr double kShare = 0.7;      // and of those that should show it
constexpr double kClear = 8;        // nats between a height and all others
constexpr double kSurely = 3;       // sigmas
constexpr double kIndependent = 4;  // of the views that agree: wheels and mounting err together

constexpr double kUpright_m = 0.03;  // surely higher it stands up, and surely lower it is flat
constexpr double kHighest = 0.6;     // of the camera's height
constexpr double kVague_m = 0.06;    // a place known no better is of no use

constexpr double kSupport_m = 0.05;  // a mark is found again so near,
constexpr int kSupport = 2;          // in so many other pictures
constexpr int kViewsKept = 40;       // of late

constexpr int kSecondViews = 3;         // that must agree
constexpr double kSecondStep_m = 0.16;  // of driving between them
constexpr int kSecondRayStride = 2;     // of the rays that are looked at
constexpr double kThick_m = 0.005;      // of what lies on the floor
constexpr double kTogether = 9;         // the edges of one thing err alike
constexpr double kLonger_px = 1;        // what is no floor looks, at either end

}  // namespace

EdgeHeights::Fit& EdgeHeights::Fit::operator+=(const Fit& other) {
  score += other.score;
  seen += other.seen;
  agree += other.agree;
  information += other.information;
  vector += other.vector;
  lean += other.lean;
  return *this;
}

EdgeHeights::EdgeHeights(std::shared_ptr<const FloorProjection> projection,
                         std::optional<SecondView> second)
    : projection_(std::move(projection)), second_(std::move(second)) {
  constexpr double kFinest = 0.02;  // an edge's noise a metre of driving on
  for (double slide = -3 * kFinest; slide < kHighest / (1 - kHighest);
       slide += std::max(kFinest, 0.1 * slide)) {
    slides_.push_back(slide);
  }
  for (int ray = 0; ray < projection_->rays; ++ray) {
    const double angle = projection_->first_ray_rad + ray * projection_->ray_step_rad;
    directions_.emplace_back(std::cos(angle), std::sin(angle));
  }
  if (second_) {
    error_.covariance.topLeftCorner<3, 3>() = second_->covariance;
    error_.covariance(3, 3) = kLonger_px * kLonger_px;
  }
}

EdgeHeights::View EdgeHeights::look(const Samples& samples, const std::vector<std::int8_t>& floor,
                                    const Pose2& T_odom_body) const {
  const FloorProjection& p = *projection_;
  const auto rays = static_cast<std::size_t>(p.rays);
  View view;
  view.height_m = samples.height_m;
  view.T_odom_view = T_odom_body * p.T_body_view;
  view.foot_odom = view.T_odom_view * samples.foot_view;
  view.begin.reserve(rays + 1);
  view.near_m.assign(rays, 0);
  view.far_m.assign(rays, 0);
  for (std::size_t ray = 0; ray < rays; ++ray) {
    view.begin.push_back(static_cast<std::int32_t>(view.edges.size()));
    int before = 0;  // what the last clear sample said
    float before_m = 0;
    for (std::size_t i = ray; i < floor.size(); i += rays) {
      const int now = floor[i];
      if (samples.pixel[i] < 0) {
        continue;
      }
      view.near_m[ray] = view.far_m[ray] > 0 ? view.near_m[ray] : p.range_m[i];
      view.far_m[ray] = p.range_m[i];
      const bool changes = before != 0 && (now > 0) != (before > 0);
      if (changes && std::abs(now - before) < kContrast) {
        continue;  // it may grow clearer
      }
      if (changes) {
        const float share = static_cast<float>(before) / static_cast<float>(before - now);
        view.edges.push_back({before_m + share * (p.range_m[i] - before_m),
                              static_cast<float>(kNoise_px) * samples.depth_m[i], before > 0});
      }
      before = now;
      before_m = p.range_m[i];
    }
  }
  view.begin.push_back(static_cast<std::int32_t>(view.edges.size()));
  return view;
}

EdgeHeights::Since EdgeHeights::since(const View& view) const {
  const View& now = views_.back();
  const Mat2 R_view_odom = view.T_odom_view.rotation().transpose();
  const Vec2 way = now.foot_odom - view.foot_odom;
  const double wheels_m = kWheels * way.norm() + kWheels_m;
  return {&view, R_view_odom * now.T_odom_view.rotation(), R_view_odom * way, wheels_m * wheels_m};
}

// Where another view shows what is `sight` away on the floor, if that slides so.
std::optional<EdgeHeights::Seen> EdgeHeights::seen(const Since& since, const Vec2& sight,
                                                   double slide) const {
  const FloorProjection& p = *projection_;
  const View& view = *since.view;
  // The point is at this share of the line of sight, and that much lower than the other camera.
  const double share = 1 / (1 + slide);
  const double below_m = view.height_m - p.height_m * (1 - share);
  if (below_m < 0.1 * view.height_m) {
    return std::nullopt;
  }
  const Vec2 turned = since.R_then_now * sight;
  const double stretch = view.height_m / below_m;
  const Vec2 at = stretch * (share * turned + since.foot_then);
  const double ray = (std::atan2(at.y(), at.x()) - p.first_ray_rad) / p.ray_step_rad;
  if (!(ray > -0.5 && ray < p.rays - 0.5)) {
    return std::nullopt;
  }
  Seen out;
  out.ray = static_cast<std::size_t>(std::lround(ray));
  out.range_m = at.norm();
  constexpr double kEnd = 0.05;  // edges may be missed there
  if (out.range_m > (1 - kEnd) * static_cast<double>(view.far_m[out.ray]) ||
      out.range_m < (1 + kEnd) * static_cast<double>(view.near_m[out.ray])) {
    return std::nullopt;
  }
  const Vec2 by_share = stretch * turned - at * p.height_m / below_m;
  out.by_slide = -share * share * at.dot(by_share) / out.range_m;
  out.direction_rad = p.first_ray_rad + ray * p.ray_step_rad;
  if (view.second) {
    const Vec3 by_mounting = second_->range_error(out.range_m, out.direction_rad);
    out.range_m += by_mounting.dot(error_.mean.head<3>());
  }
  return out;
}

const EdgeHeights::Edge* EdgeHeights::nearest(const View& view, const Edge& edge, const Seen& at) {
  const Edge* found = nullptr;
  const auto off = [&](const Edge& other) {
    return std::abs(static_cast<double>(other.range_m) - at.range_m);
  };
  for (auto k = view.begin[at.ray]; k < view.begin[at.ray + 1]; ++k) {
    const Edge& other = view.edges[static_cast<std::size_t>(k)];
    if (other.floor_ends == edge.floor_ends && (found == nullptr || off(other) < off(*found))) {
      found = &other;
    }
  }
  return found;
}

// How far off an edge is that another view shows, with that one's errors.
Eigen::Vector4d EdgeHeights::error_by(const View& view, const Seen& at, const Edge& edge,
                                      const Edge& found) const {
  if (!view.second) {
    return Eigen::Vector4d::Zero();
  }
  const double wider_m = static_cast<double>(found.sigma_m - edge.sigma_m) / kNoise_px;
  Eigen::Vector4d by;
  by << second_->range_error(at.range_m, at.direction_rad), edge.floor_ends ? -wider_m : wider_m;
  return by;
}

// How well the views show the edge if its line of sight slides so.
EdgeHeights::Fit EdgeHeights::fit(const std::vector<Since>& views, const Edge& edge,
                                  const Vec2& direction, double slide) const {
  const Vec2 sight = static_cast<double>(edge.range_m) * direction;
  const double here = static_cast<double>(edge.sigma_m * edge.sigma_m);
  Fit out;
  for (const Since& since : views) {
    const std::optional<Seen> at = seen(since, sight, slide);
    if (!at) {
      continue;
    }
    ++out.seen;
    const Edge* found = nearest(*since.view, edge, *at);
    if (found == nullptr) {
      continue;
    }
    const Eigen::Vector4d by = error_by(*since.view, *at, edge, *found);
    const double off = static_cast<double>(found->range_m) - at->range_m - by.w() * error_.mean.w();
    const double variance =
        static_cast<double>(found->sigma_m * found->sigma_m) + here + since.variance_m2;
    const double nats = 0.5 * off * off / (variance + by.dot(error_.covariance * by));
    out.score += std::max(0.0, kOther - nats);
    if (nats < kSame) {
      ++out.agree;
      out.information += at->by_slide * at->by_slide / variance;
      out.vector += at->by_slide * off / variance;
      out.lean += at->by_slide / variance * by;
    }
  }
  return out;
}

// The height that the views agree on, if they do; `fits` are of the slides that are tried.
std::optional<EdgeHeights::Height> EdgeHeights::settle(const Edge& edge, const Vec2& direction,
                                                       const std::vector<Fit>& fits,
                                                       bool second) const {
  const FloorProjection& p = *projection_;
  const auto best = std::max_element(fits.begin(), fits.end(),
                                     [](const Fit& a, const Fit& b) { return a.score < b.score; });
  double slide = slides_[static_cast<std::size_t>(best - fits.begin())];
  Fit found = *best;
  int independent = 0;
  for (int round = 0; round < 2; ++round) {
    if (found.agree < kViews || found.agree < kShare * found.seen || found.information <= 0) {
      return std::nullopt;
    }
    slide += found.vector / found.information;
    found = fit(since_, edge, direction, slide);
    independent = found.agree;
    if (second) {
      const Fit other = fit(second_since_, edge, direction, slide);
      if (other.agree < kSecondViews || other.agree < kShare * other.seen) {
        return std::nullopt;
      }
      found += other;
      independent = other.agree;
    }
  }
  if (found.information <= 0) {
    return std::nullopt;
  }
  const double sigma = 1 / std::sqrt(found.information);
  for (std::size_t k = 0; k < slides_.size(); ++k) {
    const double width = std::sqrt(2 * kClear) * sigma;  // there it is as much less likely
    const bool other = std::abs(slides_[k] - slide) > width + slides_[1] - slides_[0];
    if (other && fits[k].score > found.score - kClear) {
      return std::nullopt;
    }
  }
  const double share = 1 / (1 + slide);
  const Eigen::Vector4d lean = found.lean / found.information;
  const double variance = std::max(1.0, independent / kIndependent) / found.information +
                          lean.dot(error_.covariance * lean);
  const double sigma_share = share * share * std::sqrt(variance);
  const double range_m = static_cast<double>(edge.range_m);
  const View& now = views_.back();
  Height height;
  height.point.p_odom = now.foot_odom + now.T_odom_view.rotation() * (share * range_m * direction);
  height.point.height_m = p.height_m * (1 - share);
  height.point.sigma_m = range_m * sigma_share;
  height.sigma_m = p.height_m * sigma_share;
  height.by_second = second;
  return height;
}

// `fit`: to no slide at all.
bool EdgeHeights::is_surely_flat(const Fit& fit) const {
  if (fit.agree < kViews || !(fit.information > 0)) {
    return false;
  }
  const double sigma = std::sqrt(std::max(1.0, fit.agree / kIndependent) / fit.information);
  const double slide = std::abs(fit.vector / fit.information);
  return projection_->height_m * (slide + 2 * sigma) < kUpright_m;
}

std::optional<EdgeHeights::Height> EdgeHeights::height_of(const Edge& edge, const Vec2& direction,
                                                          bool ask_second) {
  const auto missed = [](const Fit& f) { return f.seen * kOther - f.score; };
  // most edges at which the floor ends are its own: joints and stains
  if (edge.floor_ends) {
    if (const Fit flat = fit(since_, edge, direction, 0); missed(flat) < kClear) {
      if (is_surely_flat(flat)) {
        learn(edge, direction);
      }
      return std::nullopt;
    }
  }
  std::vector<Fit> fits;
  fits.reserve(slides_.size());
  for (const double slide : slides_) {
    fits.push_back(fit(since_, edge, direction, slide));
  }
  std::optional<Height> height = settle(edge, direction, fits, false);
  if (height || !ask_second) {
    return height;
  }
  for (std::size_t k = 0; k < slides_.size(); ++k) {
    fits[k] += fit(second_since_, edge, direction, slides_[k]);
  }
  return settle(edge, direction, fits, true);
}

// An edge that the motion shows to lie on the floor tells of the second view's error.
void EdgeHeights::learn(const Edge& edge, const Vec2& direction) {
  if (second_since_.empty() || second_views_.back().instant != views_.back().instant) {
    return;
  }
  const Since& now = second_since_.back();
  const std::optional<Seen> at = seen(now, static_cast<double>(edge.range_m) * direction, 0);
  const Edge* found = at ? nearest(*now.view, edge, *at) : nullptr;
  if (found == nullptr) {
    return;
  }
  const Eigen::Vector4d by = error_by(*now.view, *at, edge, *found);
  const double off = static_cast<double>(found->range_m) - at->range_m - by.w() * error_.mean.w();
  const double thick = kThick_m * at->range_m / now.view->height_m;
  const double variance =
      kTogether *
      (static_cast<double>(found->sigma_m * found->sigma_m + edge.sigma_m * edge.sigma_m) +
       now.variance_m2 + thick * thick);
  const Eigen::Vector4d gain = error_.covariance * by;
  const double expected = by.dot(gain) + variance;
  if (off * off > kSurely * kSurely * expected) {
    return;
  }
  error_.mean += gain * (off / expected);
  error_.covariance -= gain * gain.transpose() / expected;
}

// Whether other pictures found the same place flat.
bool EdgeHeights::is_supported(const Vec2& p_odom) const {
  int others = 0;
  int last = view_;
  for (const Flat& flat : flat_) {
    if (flat.view != last && (flat.p_odom - p_odom).squaredNorm() < kSupport_m * kSupport_m) {
      last = flat.view;
      ++others;
    }
  }
  return others >= kSupport;
}

bool EdgeHeights::is_due(const Pose2& T_odom_body) const {
  const Vec2 foot_odom = T_odom_body * projection_->T_body_view * projection_->foot_view;
  return views_.empty() || (views_.back().foot_odom - foot_odom).norm() >= kStep_m;
}

void EdgeHeights::take(const std::vector<std::int8_t>& floor, const Pose2& T_odom_body,
                       const std::optional<Second>& second) {
  const FloorProjection& p = *projection_;
  ++view_;
  views_.push_back(look({p.pixel, p.depth_m, p.foot_view, p.height_m}, floor, T_odom_body));
  views_.back().instant = view_;
  const auto far_enough = [&] {
    return second_views_.empty() ||
           (second_views_.back().foot_odom - views_.back().foot_odom).norm() >= kSecondStep_m;
  };
  if (second_ && second && far_enough()) {
    second_views_.push_back(
        look({second_->pixel, second_->depth_m, second_->foot_view, second_->height_m},
             second->floor, second->T_odom_body));
    second_views_.back().second = true;
    second_views_.back().instant = view_;
  }
  const auto drop_old = [&](std::deque<View>& views) {
    while (!views.empty() &&
           (views.front().T_odom_view.position() - views_.back().T_odom_view.position()).norm() >
               kLongest_m) {
      views.pop_front();
    }
  };
  drop_old(views_);
  drop_old(second_views_);
  since_.clear();
  second_since_.clear();
  for (std::size_t i = 0; i + 1 < views_.size(); ++i) {
    since_.push_back(since(views_[i]));
  }
  for (const View& view : second_views_) {
    second_since_.push_back(since(view));
  }
  rays_left_ = p.rays / kRayStride;
  while (!flat_.empty() && view_ - flat_.front().view > kViewsKept) {
    flat_.pop_front();
  }
}

EdgeHeights::Found EdgeHeights::add(const std::vector<std::int8_t>& floor, const Pose2& T_odom_body,
                                    const std::optional<Second>& second) {
  const FloorProjection& p = *projection_;
  if (is_due(T_odom_body)) {
    take(floor, T_odom_body, second);
  }
  Found found;
  if (since_.size() < kViews) {
    return found;
  }
  const View& now = views_.back();
  const int some = std::min(rays_left_, p.rays / kRayStride / kShares + 1);
  rays_left_ -= some;
  for (int i = 0; i < some; ++i) {
    const auto ray = static_cast<std::size_t>(next_ray_);
    const bool ask_second = second_since_.size() >= kSecondViews &&
                            (next_ray_ / kRayStride + view_) % kSecondRayStride == 0;
    next_ray_ = (next_ray_ + kRayStride) % p.rays;
    for (auto k = now.begin[ray]; k < now.begin[ray + 1]; ++k) {
      const Edge& edge = now.edges[static_cast<std::size_t>(k)];
      // The second view is asked for marks alone: with what it found to stand maps leaked more.
      const std::optional<Height> height =
          height_of(edge, directions_[ray], ask_second && !edge.floor_ends);
      if (!height || height->point.sigma_m >= kVague_m) {
        continue;
      }
      const UprightPoint& point = height->point;
      if (point.height_m - kSurely * height->sigma_m > kUpright_m) {
        if (!height->by_second) {
          found.upright.push_back(point);
        }
      } else if (!edge.floor_ends && point.height_m + 2 * height->sigma_m < kUpright_m) {
        if (is_supported(point.p_odom)) {
          found.marks_odom.push_back(point.p_odom);
          if (!height->by_second) {
            learn(edge, directions_[ray]);
          }
        }
        flat_.push_back({point.p_odom, view_});
      }
    }
  }
  return found;
}

}  // namespace panoptes
