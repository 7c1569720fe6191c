// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/localiser.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "core/base/error.h"

namespace panoptes {
namespace {

bool same_bits(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) {
    return false;
  }
  for (int row = 0; row < a.rows; ++row) {
    if (std::memcmp(a.ptr(row), b.ptr(row), a.elemSize() * static_cast<std::size_t>(a.cols)) != 0) {
      return false;
    }
  }
  return true;
}

}  // namespace

void bind(Fields& f, KeyframeOptions& o) {
  f("distance_m", o.distance_m, positive);
  f.angle("turn", o.turn_rad, positive);
  f("dissimilarity", o.dissimilarity, at_least(1));
}

void bind(Fields& f, LocaliserOptions& o) {
  f("keyframe", o.keyframe);
  f("signature", o.signature);
  f("wheels", o.wheels);
  f("visual_heading", o.visual_heading);
  f("loops", o.loops);
}

Localiser::Localiser(const LocaliserOptions& options, const Body& body, const Rig& rig, Rng rng)
    : options_(options),
      wheel_base_m_(body.wheel_base_m),
      cameras_{rig.with_role("loop_front"), rig.with_role("loop_back")},
      closer_(options.loops, loop_cameras(rig), rng.fork("loops")) {}

bool Localiser::frozen(Shown& last, const Picture& now, const Pose2& T_odom_body) {
  if (!same_bits(last.picture.bgr, now.bgr)) {
    last = {now, T_odom_body};
    return false;
  }
  return now.stamp != last.picture.stamp && T_odom_body != last.T_odom_body;
}

bool Localiser::keyframe_due(const Pose2& T_last_body, const PlaceSignature& now) const {
  const KeyframeOptions& o = options_.keyframe;
  if (T_last_body.position().norm() >= o.distance_m ||
      std::abs(T_last_body.theta_rad) >= o.turn_rad) {
    return true;
  }
  // what is usual from one keyframe to the next is known once there have been a few
  constexpr std::size_t kEnough = 8;
  return steps_grey_.size() >= kEnough &&
         emd_grey(now, last_signature_) >
             o.dissimilarity * static_cast<double>(steps_grey_[steps_grey_.size() / 2]);
}

Pose2 Localiser::link_to_last(const LoopPlace& place, const Pose2& T_last_body) {
  const int last = static_cast<int>(keyframes_.size()) - 1;
  const MotionPrior wheels{T_last_body,
                           wheel_covariance(options_.wheels, wheel_base_m_, T_last_body)};
  GraphEdge edge{last, last + 1, T_last_body, wheels.covariance.inverse(), false};
  if (options_.visual_heading) {
    if (const auto seen = closer_.motion_to(place, last, wheels)) {
      edge.T_from_to = seen->T_a_b;
      edge.information = seen->covariance.inverse();
    }
  }
  graph_.edges.push_back(edge);
  return edge.T_from_to;
}

void Localiser::add_keyframe(const Observation& seen, const LoopPlace& place, Located& out) {
  const int made = static_cast<int>(keyframes_.size());
  const Time taken = seen.pictures.at(cameras_[0]).stamp;
  const Pose2 T_now_then = T_body_then(seen, taken);
  Keyframe keyframe{taken, seen.odometry.T_odom_body * T_now_then, Pose2{}};
  if (made == 0) {
    graph_.T_map_node.push_back(Pose2{});
  } else {
    const Pose2 T_last_then = link_to_last(place, out.T_last_body * T_now_then);
    keyframe.T_odom_body = keyframes_.back().T_odom_body * T_last_then;
    graph_.T_map_node.push_back(graph_.T_map_node.back() * T_last_then);
    if (!place.blind()) {
      const auto step_grey = static_cast<float>(emd_grey(place.signature, last_signature_));
      steps_grey_.insert(std::upper_bound(steps_grey_.begin(), steps_grey_.end(), step_grey),
                         step_grey);
    }
  }
  last_signature_ = place.signature;
  keyframes_.push_back(keyframe);
  out.keyframe_made = made;
  out.T_last_body = T_now_then.inverse();
}

void Localiser::close_loops(LoopPlace place, const ContourSource& contours, Located& out) {
  out.closures = closer_.close(std::move(place), graph_, contours);
  for (const ClosureReport& closure : out.closures) {
    if (closure.accepted) {
      graph_.edges.push_back(closure_edge(closure));
      out.relaxed = true;
    }
  }
  if (out.relaxed) {
    relax(graph_, RelaxStart::kCurrent);
  }
}

Located Localiser::step(const Observation& seen, const ContourSource& contours,
                        const StageListener& listener) {
  Located out;
  LoopPlace place;
  {
    const StageScope scope(listener, "odometry");
    if (!keyframes_.empty()) {
      out.T_last_body = keyframes_.back().T_wheels_body.inverse() * seen.odometry.T_odom_body;
    }
    std::array<const Picture*, 2> pictures{};
    std::array<bool, 2> live{};
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (const auto found = seen.pictures.find(cameras_[i]); found != seen.pictures.end()) {
        pictures[i] = &found->second;
        live[i] = !frozen(shown_[i], found->second, seen.odometry.T_odom_body);
      }
    }
    if (pictures[0] != nullptr && pictures[1] != nullptr) {
      place.signature = place_signature(options_.signature, pictures[0]->bgr, pictures[1]->bgr);
      if (keyframes_.empty() || keyframe_due(out.T_last_body, place.signature)) {
        for (std::size_t i = 0; i < cameras_.size(); ++i) {
          if (live[i]) {
            place.features[i] = local_features(options_.loops.features, pictures[i]->bgr);
          }
        }
        add_keyframe(seen, place, out);
      }
    }
  }
  const StageScope scope(listener, "slam");
  if (out.keyframe_made) {
    close_loops(std::move(place), contours, out);
  }
  if (!keyframes_.empty()) {
    out.keyframe = static_cast<int>(keyframes_.size()) - 1;
    out.T_odom_body = keyframes_.back().T_odom_body * out.T_last_body;
    out.T_map_body = graph_.T_map_node.back() * out.T_last_body;
  }
  return out;
}

}  // namespace panoptes
