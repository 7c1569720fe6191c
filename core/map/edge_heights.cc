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

}  // namespace

EdgeHeights::EdgeHeights(std::shared_ptr<const FloorProjection> projection)
    : projection_(std::move(projection)) {
  constexpr double kFinest = 0.02;  // an edge's noise a metre of driving on
  for (double slide = -3 * kFinest; slide < kHighest / (1 - kHighest);
       slide += std::max(kFinest, 0.1 * slide)) {
    slides_.push_back(slide);
  }
  for (int ray = 0; ray < projection_->rays; ++ray) {
    const double angle = projection_->first_ray_rad + ray * projection_->ray_step_rad;
    directions_.emplace_back(std::cos(angle), std::sin(angle));
  }
}

EdgeHeights::View EdgeHeights::look(const std::vector<std::int8_t>& floor,
                                    const Pose2& T_odom_body) const {
  const FloorProjection& p = *projection_;
  const auto rays = static_cast<std::size_t>(p.rays);
  View view;
  view.T_odom_view = T_odom_body * p.T_body_view;
  view.foot_odom = view.T_odom_view * p.foot_view;
  view.begin.reserve(rays + 1);
  view.far_m.assign(rays, 0);
  for (std::size_t ray = 0; ray < rays; ++ray) {
    view.begin.push_back(static_cast<std::int32_t>(view.edges.size()));
    int before = 0;  // what the last clear sample said
    float before_m = 0;
    for (std::size_t i = ray; i < floor.size(); i += rays) {
      const int now = floor[i];
      if (p.pixel[i] < 0) {
        continue;
      }
      view.far_m[ray] = p.range_m[i];
      const bool changes = before != 0 && (now > 0) != (before > 0);
      if (changes && std::abs(now - before) < kContrast) {
        continue;  // it may grow clearer
      }
      if (changes) {
        const float share = static_cast<float>(before) / static_cast<float>(before - now);
        view.edges.push_back({before_m + share * (p.range_m[i] - before_m),
                              static_cast<float>(kNoise_px) * p.depth_m[i], before > 0});
      }
      before = now;
      before_m = p.range_m[i];
    }
  }
  view.begin.push_back(static_cast<std::int32_t>(view.edges.size()));
  return view;
}

void EdgeHeights::relate() {
  since_.clear();
  const View& now = views_.back();
  for (std::size_t i = 0; i + 1 < views_.size(); ++i) {
    const View& view = views_[i];
    const Mat2 R_view_odom = view.T_odom_view.rotation().transpose();
    const Vec2 way = now.foot_odom - view.foot_odom;
    const double wheels_m = kWheels * way.norm() + kWheels_m;
    since_.push_back(
        {&view, R_view_odom * now.T_odom_view.rotation(), R_view_odom * way, wheels_m * wheels_m});
  }
}

// How well the earlier views show the edge if its line of sight slides so.
EdgeHeights::Fit EdgeHeights::fit(const Edge& edge, const Vec2& direction, double slide) const {
  const FloorProjection& p = *projection_;
  const double range_now = static_cast<double>(edge.range_m);
  const Vec2 sight = range_now * direction;
  const double here = static_cast<double>(edge.sigma_m * edge.sigma_m);
  Fit out;
  for (const Since& since : since_) {
    // where the line of sight of then meets the floor, from the foot of then
    const Vec2 at = since.R_then_now * sight + (1 + slide) * since.foot_then;
    const double ray = (std::atan2(at.y(), at.x()) - p.first_ray_rad) / p.ray_step_rad;
    const double range_m = at.norm();
    if (!(ray > -0.5 && ray < p.rays - 0.5)) {
      continue;
    }
    const View& view = *since.view;
    const auto nearest_ray = static_cast<std::size_t>(std::lround(ray));
    constexpr double kEnd = 0.05;  // edges may be missed there
    if (range_m > (1 - kEnd) * static_cast<double>(view.far_m[nearest_ray]) ||
        range_m < (1 + kEnd) * static_cast<double>(p.range_m[0])) {
      continue;
    }
    ++out.seen;
    const Edge* nearest = nullptr;
    double off = 0;
    for (auto k = view.begin[nearest_ray]; k < view.begin[nearest_ray + 1]; ++k) {
      const Edge& other = view.edges[static_cast<std::size_t>(k)];
      const double error = static_cast<double>(other.range_m) - range_m;
      if (other.floor_ends == edge.floor_ends &&
          (nearest == nullptr || std::abs(error) < std::abs(off))) {
        nearest = &other;
        off = error;
      }
    }
    if (nearest == nullptr) {
      continue;
    }
    const double variance =
        static_cast<double>(nearest->sigma_m * nearest->sigma_m) + here + since.variance_m2;
    const double nats = 0.5 * off * off / variance;
    out.score += std::max(0.0, kOther - nats);
    if (nats < kSame) {
      ++out.agree;
      const double by_slide = at.dot(since.foot_then) / range_m;
      out.information += by_slide * by_slide / variance;
      out.vector += by_slide * off / variance;
    }
  }
  return out;
}

std::optional<EdgeHeights::Height> EdgeHeights::height_of(const Edge& edge,
                                                          const Vec2& direction) const {
  const FloorProjection& p = *projection_;
  const auto missed = [](const Fit& f) { return f.seen * kOther - f.score; };
  // most edges at which the floor ends are its own: joints and stains
  if (edge.floor_ends) {
    if (const Fit flat = fit(edge, direction, 0); missed(flat) < kClear) {
      return std::nullopt;
    }
  }
  std::vector<Fit> fits;
  fits.reserve(slides_.size());
  for (const double slide : slides_) {
    fits.push_back(fit(edge, direction, slide));
  }
  const auto best = std::max_element(fits.begin(), fits.end(),
                                     [](const Fit& a, const Fit& b) { return a.score < b.score; });
  double slide = slides_[static_cast<std::size_t>(best - fits.begin())];
  Fit found = *best;
  for (int round = 0; round < 2; ++round) {
    if (found.agree < kViews || found.agree < kShare * found.seen || found.information <= 0) {
      return std::nullopt;
    }
    slide += found.vector / found.information;
    found = fit(edge, direction, slide);
  }
  if (found.information <= 0) {
    return std::nullopt;
  }
  const double sigma = 1 / std::sqrt(found.information);
  for (std::size_t k = 0; k < slides_.size(); ++k) {
    const bool other = std::abs(slides_[k] - slide) > kSurely * sigma + slides_[1] - slides_[0];
    if (other && fits[k].score > found.score - kClear) {
      return std::nullopt;
    }
  }
  const double share = 1 / (1 + slide);
  const double sigma_share =
      share * share * sigma * std::sqrt(std::max(1.0, found.agree / kIndependent));
  const double range_m = static_cast<double>(edge.range_m);
  Height height;
  const View& now = views_.back();
  height.point.p_odom = now.foot_odom + now.T_odom_view.rotation() * (share * range_m * direction);
  height.point.height_m = p.height_m * (1 - share);
  height.point.sigma_m = range_m * sigma_share;
  height.sigma_m = p.height_m * sigma_share;
  return height;
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

EdgeHeights::Found EdgeHeights::add(const std::vector<std::int8_t>& floor,
                                    const Pose2& T_odom_body) {
  const FloorProjection& p = *projection_;
  const Vec2 foot_odom = T_odom_body * p.T_body_view * p.foot_view;
  if (views_.empty() || (views_.back().foot_odom - foot_odom).norm() >= kStep_m) {
    while (!views_.empty() && (views_.front().foot_odom - foot_odom).norm() > kLongest_m) {
      views_.pop_front();
    }
    views_.push_back(look(floor, T_odom_body));
    relate();
    rays_left_ = p.rays / kRayStride;
    ++view_;
    while (!flat_.empty() && view_ - flat_.front().view > kViewsKept) {
      flat_.pop_front();
    }
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
    next_ray_ = (next_ray_ + kRayStride) % p.rays;
    for (auto k = now.begin[ray]; k < now.begin[ray + 1]; ++k) {
      const Edge& edge = now.edges[static_cast<std::size_t>(k)];
      const std::optional<Height> height = height_of(edge, directions_[ray]);
      if (!height || height->point.sigma_m >= kVague_m) {
        continue;
      }
      const UprightPoint& point = height->point;
      if (point.height_m - kSurely * height->sigma_m > kUpright_m) {
        found.upright.push_back(point);
      } else if (!edge.floor_ends && point.height_m + 2 * height->sigma_m < kUpright_m) {
        if (is_supported(point.p_odom)) {
          found.marks_odom.push_back(point.p_odom);
        }
        flat_.push_back({point.p_odom, view_});
      }
    }
  }
  return found;
}

}  // namespace panoptes
