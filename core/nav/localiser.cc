// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/localiser.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/error.h"
#include "core/geometry/covariance.h"

namespace panoptes {
namespace {

bool is_lost(const CameraReports& cameras, const std::string& name) {
  const auto found = cameras.find(name);
  return found != cameras.end() && found->second.state != CameraState::kGood;
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
  f.choice("odometry", o.odometry);
  f("wheels", o.wheels);
  f("visual_heading", o.visual_heading);
  f("loops", o.loops);
}

Localiser::Localiser(const LocaliserOptions& options, const OdometrySource& odometry,
                     const Rig& rig, Rng rng)
    : options_(options),
      odometry_(odometry),
      closer_(options.loops, loop_cameras(rig), rng.fork("loops")) {}

// Empty while a camera that is not lost has no picture in the set.
std::optional<Localiser::Views> Localiser::views_of(const Observation& seen,
                                                    const CameraReports& reports) const {
  Views views;
  for (const LoopCamera& camera : cameras()) {
    const auto found = seen.pictures.find(camera.name);
    if (found == seen.pictures.end() && !is_lost(reports, camera.name)) {
      return std::nullopt;
    }
    views.push_back(found != seen.pictures.end() ? &found->second : nullptr);
  }
  return views;
}

// Of a camera that is lost the other's picture takes the place.
PlaceSignature Localiser::signature_of(const Views& views) const {
  const Picture* front = views[kLoopFront] != nullptr ? views[kLoopFront] : views[kLoopBack];
  const Picture* back = views[kLoopBack] != nullptr ? views[kLoopBack] : views[kLoopFront];
  return front == nullptr ? last_signature_
                          : place_signature(options_.signature, front->bgr, back->bgr);
}

bool Localiser::keyframe_due(const Pose2& T_last_body, const LoopPlace& now) const {
  const KeyframeOptions& o = options_.keyframe;
  if (T_last_body.position().norm() >= o.distance_m ||
      std::abs(T_last_body.theta_rad) >= o.turn_rad) {
    return true;
  }
  // what is usual from one keyframe to the next is known once there have been a few
  constexpr std::size_t kEnough = 8;
  return steps_grey_.size() >= kEnough && !now.partial &&
         emd_grey(now.signature, last_signature_) >
             o.dissimilarity * static_cast<double>(steps_grey_[steps_grey_.size() / 2]);
}

Pose2 Localiser::link_to_last(const LoopPlace& place, Time taken, const Pose2& T_last_body) {
  const int last = static_cast<int>(keyframes_.size()) - 1;
  const MotionPrior prior{T_last_body,
                          odometry_.covariance(keyframes_.back().stamp, taken, T_last_body)};
  GraphEdge edge{last, last + 1, T_last_body, prior.covariance.inverse(), false};
  if (options_.visual_heading) {
    const auto seen = closer_.motion_to(place, last, prior);
    if (const auto information = seen ? inverse_of(seen->covariance) : std::nullopt) {
      edge.T_from_to = seen->T_a_b;
      edge.information = *information;
    }
  }
  graph_.edges.push_back(edge);
  return edge.T_from_to;
}

void Localiser::add_keyframe(const Observation& seen, Time taken, const LoopPlace& place,
                             Located& out) {
  const int made = static_cast<int>(keyframes_.size());
  const Pose2 T_now_then = T_body_then(seen, taken);
  Keyframe keyframe{taken, seen.odometry.T_odom_body * T_now_then, Pose2{}};
  if (made == 0) {
    graph_.T_map_node.push_back(Pose2{});
  } else {
    const Pose2 T_last_then = link_to_last(place, taken, out.T_last_body * T_now_then);
    keyframe.T_odom_body = keyframes_.back().T_odom_body * T_last_then;
    graph_.T_map_node.push_back(graph_.T_map_node.back() * T_last_then);
    if (!place.featureless()) {
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
                        const StageListener& listener, const CameraReports& cameras) {
  Located out;
  LoopPlace place;
  {
    const StageScope scope(listener, "odometry");
    if (!keyframes_.empty()) {
      out.T_last_body = keyframes_.back().T_wheels_body.inverse() * seen.odometry.T_odom_body;
    }
    if (const std::optional<Views> views = views_of(seen, cameras)) {
      place.partial = (*views)[kLoopFront] == nullptr || (*views)[kLoopBack] == nullptr;
      place.signature = signature_of(*views);
      if (keyframes_.empty() || keyframe_due(out.T_last_body, place)) {
        for (const Picture* view : *views) {
          place.features.push_back(view == nullptr
                                       ? LocalFeatures()
                                       : local_features(options_.loops.features, view->bgr));
        }
        const auto first = std::find_if(views->begin(), views->end(),
                                        [](const Picture* view) { return view != nullptr; });
        add_keyframe(seen, first == views->end() ? seen.stamp : (*first)->stamp, place, out);
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
