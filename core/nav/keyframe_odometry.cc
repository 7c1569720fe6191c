// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/keyframe_odometry.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/base/check.h"

namespace panoptes {
namespace {

JointEdge joint_edge(int first, const BundleSolution& solution) {
  return {first,
          {solution.T_first_frame.begin() + 1, solution.T_first_frame.end()},
          solution.state,
          solution.information,
          solution.gradient};
}

}  // namespace

void bind(Fields& f, BundleOdometryOptions& o) {
  f("keyframes", o.keyframes, between(2, 30));
  f("longest", o.longest, between(2, 60));
  f("before", o.before, between(0, 30));
  f("noise_px", o.bundle.noise_px, between(0.05, 10));
  f("inlier_sigma", o.bundle.inlier_sigma, between(1, 10));
  f("iterations", o.bundle.iterations, between(1, 100));
}

KeyframeOdometry::KeyframeOdometry(const BundleOdometryOptions& options,
                                   const FeatureOptions& features, LoopCameras cameras)
    : options_(options),
      features_(features),
      cameras_(std::move(cameras)),
      noise_px_(options.bundle.noise_px) {}

// Frames numbered from `first` on; what was seen from two of them or more.
std::vector<Track> KeyframeOdometry::tracks_since(int first) const {
  std::vector<Track> tracks;
  for (const Track& track : tracks_) {
    Track part{track.camera, {}};
    for (const Track::Seen& seen : track.seen) {
      if (seen.frame >= first) {
        part.seen.push_back({seen.frame - first, seen.feature, seen.px});
      }
    }
    if (part.seen.size() >= 2) {
      tracks.push_back(std::move(part));
    }
  }
  return tracks;
}

std::vector<BundleFrame> KeyframeOdometry::frames_since(int first) const {
  return {frames_.begin() + (first - kept_first_), frames_.end()};
}

std::vector<Pose2> KeyframeOdometry::path_since(int first) const {
  std::vector<Pose2> path{Pose2{}};
  for (auto step = T_before_here_.begin() + (first - kept_first_) + 1; step != T_before_here_.end();
       ++step) {
    path.push_back(path.back() * *step);
  }
  return path;
}

// Of all keyframes from `first` on.
BundleSolution KeyframeOdometry::adjust(int first, const RigPriorState& rig) const {
  return adjust_from(path_since(first), false, first, rig);
}

BundleSolution KeyframeOdometry::adjust_from(const std::vector<Pose2>& start_T_first_frame,
                                             bool near, int first, const RigPriorState& rig) const {
  BundleOptions options = options_.bundle;
  options.noise_px = noise_px_;
  options.starts_near = near;
  return adjust_bundle(options, cameras_, rig, frames_since(first), tracks_since(first),
                       start_T_first_frame);
}

MountingJump KeyframeOdometry::jump(const RigPriorState& rig, int at, int before, int most,
                                    const std::optional<PictureThird>& without) const {
  const int first = at - before;
  PANOPTES_CHECK(first >= kept_first_ && at > first && at <= newest_, "keyframes it remembers");
  std::vector<Track> tracks = tracks_since(first);
  if (without) {
    const double third_px = cameras_[without->camera].intrinsics.width_px / 3.0;
    std::erase_if(tracks, [&](const Track& track) {
      const auto after =
          std::find_if(track.seen.begin(), track.seen.end(),
                       [&](const Track::Seen& seen) { return seen.frame >= before; });
      return track.camera == without->camera && after != track.seen.begin() &&
             after != track.seen.end() &&
             static_cast<int>(after->px.x() / third_px) == without->third;
    });
  }
  std::stable_sort(tracks.begin(), tracks.end(),
                   [](const Track& a, const Track& b) { return a.seen.size() > b.seen.size(); });
  std::vector<int> begun((newest_ - first + 1) * cameras_.size(), 0);
  std::erase_if(tracks, [&](const Track& track) {
    return ++begun[track.seen.front().frame * cameras_.size() + track.camera] > most;
  });
  BundleOptions options = options_.bundle;
  options.noise_px = noise_px_;
  options.iterations = 3;  // from a path that has been adjusted
  return mounting_jump(options, cameras_, rig, frames_since(first), tracks, path_since(first),
                       before);
}

// Takes in the next keyframe: its features go on the tracks, its motion by the wheels is a start.
void KeyframeOdometry::follow(const BundleFrame& frame, const PlaceFeatures& features,
                              const RigState& state) {
  PANOPTES_CHECK(features.size() == cameras_.size(), "a picture's features a camera");
  ++newest_;
  std::vector<std::vector<int>> tracks_here(cameras_.size());
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    tracks_here[camera].assign(features[camera].px.size(), -1);
    if (newest_ == 0) {
      continue;
    }
    for (const FeatureMatch& match :
         match_features(features_, last_features_[camera], features[camera])) {
      int& track = last_tracks_[camera][match.a];
      if (track < 0) {
        track = static_cast<int>(tracks_.size());
        tracks_.push_back(
            {static_cast<int>(camera),
             {{newest_ - 1, match.a, last_features_[camera].px[match.a].cast<double>()}}});
      }
      tracks_[track].seen.push_back(
          {newest_, match.b, features[camera].px[match.b].cast<double>()});
      tracks_here[camera][match.b] = track;
    }
  }
  last_features_ = features;
  last_tracks_ = std::move(tracks_here);
  frames_.push_back(frame);
  const Vec3 by_state =
      frame.by_wheels ? (frame.by_wheels(frame.T_before_here) * state.tail<kWheelStates>()).eval()
                      : Vec3::Zero().eval();
  T_before_here_.push_back({frame.T_before_here.x_m + by_state.x(),
                            frame.T_before_here.y_m + by_state.y(),
                            wrap_angle(frame.T_before_here.theta_rad + by_state.z())});
}

JointEdge KeyframeOdometry::bundle_again(const JointEdge& before,
                                         const std::vector<BundleFrame>& frames,
                                         const std::vector<PlaceFeatures>& features,
                                         const RigPriorState& rig, bool near) const {
  KeyframeOdometry alone(options_, features_, cameras_);
  alone.noise_px_ = noise_px_;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    alone.follow(frames[k], features[k], rig.state);
  }
  if (!near) {
    return joint_edge(before.first, alone.adjust(0, rig));
  }
  std::vector<Pose2> start_T_first_frame{Pose2{}};
  start_T_first_frame.insert(start_T_first_frame.end(), before.T_first_node.begin(),
                             before.T_first_node.end());
  return joint_edge(before.first, alone.adjust_from(start_T_first_frame, true, 0, rig));
}

// Things that are seen during a turn on the spot alone show next to nothing of their depths, which
// a turn of cameras off the axis depends on: such a turn is of one bundle with the drive after it.
bool KeyframeOdometry::is_full() const {
  constexpr int kAfter = 2;
  constexpr double kDriven_m = 0.25;
  const int moved_over = newest_ - bundle_first_;
  if (moved_over < options_.keyframes || moved_over >= options_.longest) {
    return moved_over >= options_.keyframes;
  }
  double driven_m = 0;
  for (int k = 0; k < kAfter; ++k) {
    driven_m += (frames_.end() - 1 - k)->T_before_here.position().norm();
  }
  return driven_m >= kDriven_m;
}

KeyframeOdometry::Motion KeyframeOdometry::add(const BundleFrame& frame,
                                               const PlaceFeatures& features,
                                               const RigPriorState& rig) {
  follow(frame, features, rig.state);
  Motion motion;
  if (newest_ == 0) {
    return motion;
  }
  const bool full = is_full();
  // a full bundle is adjusted by itself, with the states free
  const int first = full ? bundle_first_
                         : std::max({kept_first_, bundle_first_ - options_.before,
                                     newest_ - options_.before - options_.keyframes + 1});
  const BundleSolution solution = full ? adjust(first, rig) : adjust(first, {rig.state, {}});
  for (int k = first + 1; k <= newest_; ++k) {
    T_before_here_[k - kept_first_] =
        solution.T_first_frame[k - first - 1].inverse() * solution.T_first_frame[k - first];
  }
  noise_px_ = solution.noise_px;
  motion.T_last_here = T_before_here_.back();
  if (!full) {
    const std::vector<SharedEdge> edges = pairwise_edges(joint_edge(first, solution), rig.state);
    const int anew = std::max(first, bundle_first_);
    open_.resize(anew - bundle_first_);
    open_.insert(open_.end(), edges.begin() + (anew - first), edges.end());
    motion.open = open_;
  } else {
    motion.closed = joint_edge(bundle_first_, solution);
  }
  part_.reset();
  if (full && part_first_ == bundle_first_ && newest_ - part_first_ == options_.keyframes) {
    part_ = motion.closed;
  }
  if (full) {
    begin_bundle();
  }
  return motion;
}

std::optional<JointEdge> KeyframeOdometry::part(const RigPriorState& rig) {
  if (newest_ - part_first_ < options_.keyframes) {
    return std::nullopt;
  }
  JointEdge part = part_ ? *part_ : joint_edge(part_first_, adjust(part_first_, rig));
  part_first_ = newest_;
  return part;
}

JointEdge KeyframeOdometry::close(const RigPriorState& rig) {
  JointEdge closed = joint_edge(bundle_first_, adjust(bundle_first_, rig));
  begin_bundle();
  return closed;
}

void KeyframeOdometry::begin_bundle() {
  open_.clear();
  bundle_first_ = newest_;
  const int forget =
      std::max(kept_first_,
               std::min({newest_ - options_.before, part_first_, newest_ - kRemembered + 1})) -
      kept_first_;
  frames_.erase(frames_.begin(), frames_.begin() + forget);
  T_before_here_.erase(T_before_here_.begin(), T_before_here_.begin() + forget);
  kept_first_ += forget;
  // tracks that have ended are no longer needed; those that go on are renumbered
  std::vector<Track> kept;
  for (std::vector<int>& of_camera : last_tracks_) {
    for (int& track : of_camera) {
      if (track >= 0) {
        kept.push_back(std::move(tracks_[track]));
        tracks_[track].seen.clear();
        track = static_cast<int>(kept.size()) - 1;
      }
    }
  }
  for (Track& track : tracks_) {
    if (!track.seen.empty() && track.seen.back().frame > kept_first_) {
      kept.push_back(std::move(track));
    }
  }
  tracks_ = std::move(kept);
}

}  // namespace panoptes
