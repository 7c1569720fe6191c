// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/mono_start.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/base/median.h"

namespace panoptes {
namespace {

constexpr double kFirstDue_px = 3;
// What moved less has not moved.
constexpr double kRests_px = 1;
// Of the first picture's points, in a later one.
constexpr std::size_t kFewestShared = 8;
constexpr std::size_t kMostViews = 12;
// Depths known to such a share, and a turn to less than a pixel, leave the filter little to
// linearise wrongly: before one flat wall a turn and a shift are told apart late.
constexpr double kKnown = 0.1;
constexpr double kKnown_px = 0.7;
constexpr double kLeastParallax_px = 1.5;  // ten times as much as points are badly seen
constexpr double kDueAgain = 1.5;

}  // namespace

MonoStart::MonoStart(const MonoFilterOptions& options, const Intrinsics& lens,
                     double match_sigma_px)
    : options_(options),
      lens_(lens),
      match_sigma_px_(match_sigma_px),
      pictures_(1),
      due_px_(kFirstDue_px) {}

void MonoStart::see(const std::vector<PointMatch>& first_seen) {
  pictures_.back().first_seen = first_seen;
  if (pictures_.size() == 1) {
    for (const PointMatch& point : first_seen) {
      first_px_[point.point] = point.px;
    }
  }
}

void MonoStart::add(double dt_s, const std::vector<PointMatch>& matches,
                    const StartBelieved& believed) {
  std::vector<double> moved_px;
  for (const PointMatch& match : matches) {
    if (const auto first = first_px_.find(match.point); first != first_px_.end()) {
      moved_px.push_back((match.px - first->second).norm());
    }
  }
  const bool shares = moved_px.size() >= kFewestShared;
  moved_px_ = shares ? median(std::move(moved_px)) : 0;
  const bool has_grown = std::any_of(pictures_.begin() + 1, pictures_.end(),
                                     [](const Picture& p) { return !p.first_seen.empty(); });
  if (shares && moved_px_ < kRests_px && !has_grown) {
    pictures_.resize(1);
  }
  pictures_.push_back({dt_s, matches, {}, believed});
}

bool MonoStart::is_due() const { return moved_px_ > due_px_; }

// Evenly, the latest among them.
std::vector<StartView> MonoStart::views() const {
  std::vector<StartView> views;
  const std::size_t count = pictures_.size() - 1;
  const std::size_t most = std::min(count, kMostViews);
  for (std::size_t i = 1; i <= most; ++i) {
    const Picture& picture = pictures_[i * count / most];
    StartView view;
    for (const PointMatch& match : picture.matches) {
      if (first_px_.contains(match.point)) {
        view.seen_px[match.point] = match.px;
      }
    }
    if (view.seen_px.size() >= kFewestShared) {
      views.push_back(std::move(view));
    }
  }
  return views;
}

std::optional<MonoStart::Again> MonoStart::again() {
  due_px_ = std::max(due_px_, kDueAgain * moved_px_);
  const std::vector<StartView> views = this->views();
  if (views.empty()) {
    return std::nullopt;
  }
  const auto depths =
      start_depths({match_sigma_px_, options_.inverse_depth_per_m, options_.inverse_depth_sigma},
                   lens_, first_px_, views);
  if (!depths) {
    return std::nullopt;
  }
  Again again{MonoFilter(options_, lens_), {}, {}, {}, false};
  std::size_t agreed = 0;
  std::size_t agreed_before = 0;
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    const Picture& picture = pictures_[i];
    if (i > 0) {
      again.filter.predict(picture.dt_s);
      again.latest = again.filter.update(picture.matches);
      again.filter.convert();
      again.pictures.push_back(
          {again.filter.T_map_camera(), inliers(picture.matches, again.latest)});
      agreed += again.pictures.back().inliers.size();
      agreed_before += picture.believed.inliers.size();
    }
    for (const PointMatch& seen : picture.first_seen) {
      const auto depth = depths->inverse_depth_per_m.find(seen.point);
      const int number = again.filter.add(
          seen.px, seen.sigma_px,
          depth != depths->inverse_depth_per_m.end() ? std::optional(depth->second) : std::nullopt);
      PANOPTES_CHECK(number == seen.point, "points come in the same order again");
      again.T_map_first[number] = again.filter.T_map_camera();
    }
    if (i == 0) {
      again.filter.fix_metre();
    }
  }
  if (agreed < agreed_before) {
    return std::nullopt;
  }
  const double turn_sigma_rad =
      std::sqrt(again.filter.pose_covariance().bottomRightCorner<3, 3>().trace() / 3);
  again.is_determined = depths->known_ratio < kKnown && depths->parallax_px > kLeastParallax_px &&
                        turn_sigma_rad * lens_.fx_px < kKnown_px;
  for (std::size_t i = 1; i < pictures_.size(); ++i) {
    pictures_[i].believed = again.pictures[i - 1];
  }
  return again;
}

}  // namespace panoptes
