// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/mono_map.h"

namespace panoptes {

std::vector<LostSpan> lost_spans(const MonoMap& map) {
  std::vector<LostSpan> spans;
  const auto at_s = [&map](std::size_t frame) {
    return map.begins_s + to_seconds(map.frames[frame].stamp - map.frames.front().stamp);
  };
  for (std::size_t i = 1; i < map.frames.size(); ++i) {
    if (map.frames[i].lost) {
      if (!map.frames[i - 1].lost || spans.empty()) {
        spans.push_back({at_s(i - 1), 0});
      }
      spans.back().to_s = at_s(i);
    }
  }
  return spans;
}

void MonoMapBuilder::add(Time stamp, const MonoSlamStep& step) {
  if (step.begins_anew) {
    const std::optional<Time> first_picture = first_picture_;
    *this = {};
    first_picture_ = first_picture;
  }
  if (!first_picture_) {
    first_picture_ = stamp;
  }
  const int frame = static_cast<int>(frames_.size());
  const int first_retold = frame - static_cast<int>(step.retold.size());
  if (!step.retold.empty()) {
    for (auto& [number, seen] : seen_) {
      std::erase_if(seen, [&](const MonoMap::Seen& each) {
        return each.frame >= first_retold && &each != &seen.front();
      });
    }
  }
  for (std::size_t i = 0; i < step.retold.size(); ++i) {
    const int retold = first_retold + static_cast<int>(i);
    MonoMap::Frame& before = frames_[static_cast<std::size_t>(retold)];
    before.T_map_camera = step.retold[i].T_map_camera;
    before.lost = before.lost && step.retold[i].inliers.empty();
    for (const PointMatch& match : step.retold[i].inliers) {
      seen_[match.point].push_back({retold, match.px});
    }
  }
  for (const PointSought& sought : step.sought) {
    if (sought.inlier) {
      seen_[sought.point].push_back({frame, *sought.found_px});
    }
  }
  for (const PointMatch& added : step.added) {
    seen_[added.point].push_back({frame, added.px});
  }
  if (step.closes && !closed_) {
    closed_ = frames_.size();
  }
  squared_sigmas_ += step.squared_sigmas;
  dof_ += step.dof;
  frames_.push_back({stamp, step.T_map_camera, step.lost});
}

MonoMap MonoMapBuilder::map(const MonoSlam& slam) const {
  MonoMap map;
  map.frames = frames_;
  map.closed = closed_;
  if (!frames_.empty()) {
    map.begins_s = to_seconds(frames_.front().stamp - *first_picture_);
  }
  map.normalised_innovation = dof_ > 0 ? squared_sigmas_ / static_cast<double>(dof_) : 0;
  for (std::size_t i = 1; i < frames_.size(); ++i) {
    if (frames_[i].lost) {
      map.lost_s += to_seconds(frames_[i].stamp - frames_[i - 1].stamp);
    }
  }
  const MonoFilter& filter = slam.filter();
  map.lens = filter.lens();
  map.start_is_known = slam.start_is_known();
  for (const auto& [number, point] : slam.points()) {
    const Vec3 p_map = filter.point(number).p_map();
    if (!filter.point(number).is_inverse_depth() && p_map.allFinite()) {
      map.points.push_back({number, p_map, filter.point_covariance(number), point.feature,
                            point.descriptor, seen_.at(number)});
    }
  }
  return map;
}

}  // namespace panoptes
