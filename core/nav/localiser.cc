// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/localiser.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <limits>

#include <Eigen/LU>

#include "core/base/error.h"
#include "core/geometry/covariance.h"

namespace panoptes {
namespace {

bool is_lost(const CameraReports& cameras, const std::string& name) {
  const auto found = cameras.find(name);
  return found != cameras.end() && found->second.state != CameraState::kGood;
}

int last_of(const JointEdge& joint) {
  return joint.first + static_cast<int>(joint.T_first_node.size());
}

RigState prior_sigmas(const LoopCameras& cameras, const WheelPrior& wheels) {
  RigState sigmas(rig_states(cameras.size()));
  for (int camera = 0; camera < static_cast<int>(cameras.size()); ++camera) {
    const CameraSigmas& told = cameras[camera].sigma;
    auto s = sigmas.segment<kCameraStates>(camera_state(camera));
    s.segment<3>(kRotation) = told.rotation_rad;
    s.segment<3>(kPosition) = told.position_m;
    s[kFocal] = told.focal_ratio;
    s.segment<2>(kCentre).setConstant(told.centre_px);
    s[kClock] = told.clock_s;
  }
  sigmas.tail<kWheelStates>() << wheels.scale_share, wheels.difference_share, wheels.base_share;
  constexpr double kExact = 1e-6;  // rad, m, share, px or s: what a file takes for exact is held
  return sigmas.cwiseMax(kExact);
}

/// How the states of cameras go together that were calibrated together; wheels with nothing.
Eigen::MatrixXd prior_correlations(const LoopCameras& cameras, const JointCovariance& joint) {
  std::vector<std::string> parameters(rig_states(cameras.size()));  // of no name: the wheels'
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto at = parameters.begin() + camera_state(static_cast<int>(i));
    const auto put = [&](int first, std::initializer_list<const char*> names) {
      std::transform(names.begin(), names.end(), at + first,
                     [&](const char* parameter) { return cameras[i].name + "." + parameter; });
    };
    put(kRotation, {"rotation_x_rad", "rotation_y_rad", "rotation_z_rad"});
    put(kPosition, {"position_x_m", "position_y_m", "position_z_m"});
    put(kFocal, {"fx_px"});
    put(kCentre, {"cx_px", "cy_px"});
    put(kClock, {"clock_s"});
  }
  constexpr double kLoose = 1e-6;  // what is told to be off by the very same has an inverse, too
  const Eigen::MatrixXd told = correlations(joint, parameters);
  return (1 - kLoose) * told + kLoose * Eigen::MatrixXd::Identity(told.rows(), told.cols());
}

Eigen::MatrixXd prior_information_of(const RigState& sigmas, const LoopCameras& cameras,
                                     const std::optional<JointCovariance>& joint) {
  if (!joint) {
    return sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
  }
  const RigState by = sigmas.cwiseInverse();
  const Eigen::MatrixXd information =
      by.asDiagonal() * prior_correlations(cameras, *joint).inverse() * by.asDiagonal();
  return 0.5 * (information + information.transpose());
}

/// The same of all others when nothing is known of the mounting any more, but these sigmas.
void forget_mounting(Eigen::MatrixXd& information, int state, const MountingChange& sigmas) {
  const Eigen::MatrixXd of_all = information.middleCols<kMountingStates>(state);
  const Eigen::Matrix<double, kMountingStates, kMountingStates> own =
      of_all.middleRows<kMountingStates>(state);
  information -= of_all * own.inverse() * of_all.transpose();
  information.middleRows<kMountingStates>(state).setZero();
  information.middleCols<kMountingStates>(state).setZero();
  information.diagonal().segment<kMountingStates>(state) = sigmas.cwiseAbs2().cwiseInverse();
}

}  // namespace

void bind(Fields& f, KeyframeOptions& o) {
  f("distance_m", o.distance_m, positive);
  f.angle("turn", o.turn_rad, positive);
  f("dissimilarity", o.dissimilarity, at_least(1));
}

void bind(Fields& f, WheelPrior& o) {
  f("scale_share", o.scale_share, positive);
  f("difference_share", o.difference_share, positive);
  f("base_share", o.base_share, positive);
}

void bind(Fields& f, LocaliserOptions& o) {
  f("keyframe", o.keyframe);
  f("signature", o.signature);
  f.choice("odometry", o.odometry);
  f("wheels", o.wheels);
  f("bundle", o.bundle);
  f("wheel_prior", o.wheel_prior);
  f("visual_heading", o.visual_heading);
  f("knocks_at_once", o.knocks_at_once);
  f("loops", o.loops);
}

Localiser::Localiser(const LocaliserOptions& options, const OdometrySource& odometry,
                     const Rig& rig, Rng rng)
    : options_(options),
      odometry_(odometry),
      believed_(loop_cameras(rig)),
      facings_(facings(believed_)),
      rig_check_(options.loops.features, believed_),
      keyframe_odometry_(options.bundle, options.loops.features, believed_),
      closer_(options.loops, believed_, rng.fork("loops")) {
  graph_.state = RigState::Zero(rig_states(believed_.size()));
  graph_.prior_information =
      prior_information_of(prior_sigmas(believed_, options.wheel_prior), believed_, rig.covariance);
  state_information_ = graph_.prior_information;
}

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

// Of a camera that is lost another's picture takes the place.
PlaceSignature Localiser::signature_of(const Views& views) const {
  const auto good =
      std::find_if(views.begin(), views.end(), [](const Picture* view) { return view != nullptr; });
  if (good == views.end()) {
    return last_signature_;
  }
  std::vector<cv::Mat> pictures;
  for (const Picture* view : views) {
    pictures.push_back((view != nullptr ? view : *good)->bgr);
  }
  return place_signature(options_.signature, pictures);
}

PlaceFeatures Localiser::features_of(const Views& views) const {
  PlaceFeatures features;
  for (std::size_t camera = 0; camera < views.size(); ++camera) {
    features.push_back(views[camera] == nullptr
                           ? LocalFeatures()
                           : local_features(options_.loops.features, views[camera]->bgr,
                                            believed_[camera].looks_steeply()
                                                ? DescriptorPose::kTurned
                                                : DescriptorPose::kUpright));
  }
  return features;
}

PictureTimes Localiser::times_of(const Views& views, Time taken, const Twist2& twist_body) const {
  PictureTimes times{twist_body, {}};
  for (std::size_t camera = 0; camera < views.size(); ++camera) {
    times.late_s.push_back(views[camera] == nullptr ? 0
                                                    : to_seconds(views[camera]->stamp - taken) -
                                                          believed_[camera].clock_offset_s);
  }
  return times;
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

// Adds what wheels and pictures say of the motion since the last keyframe, and tells it.
Pose2 Localiser::link_to_last(Time taken, const LoopPlace& place, const Pose2& T_last_body) {
  BundleFrame frame;
  frame.taken = place.taken;
  if (!keyframes_.empty()) {
    frame.T_before_here = T_last_body;
    frame.covariance = odometry_.covariance(keyframes_.back().stamp, taken, T_last_body);
    frame.by_wheels = [&odometry = odometry_](const Pose2& T_from_to) {
      return odometry.by_wheels(T_from_to);
    };
  }
  const PlaceFeatures none(believed_.size());
  frames_.push_back(frame);
  KeyframeOdometry::Motion motion = keyframe_odometry_.add(
      frame, options_.visual_heading && !place.features.empty() ? place.features : none,
      {graph_.state, state_information_});
  take_in(std::move(motion.closed), motion.open);
  return motion.T_last_here;
}

// The open bundle's edges are made anew with each keyframe.
void Localiser::take_in(std::optional<JointEdge> closed, const std::vector<SharedEdge>& open) {
  std::erase_if(graph_.edges, [](const SharedEdge& shared) { return !shared.edge.closure; });
  graph_.edges.insert(graph_.edges.end(), open.begin(), open.end());
  graph_.edges.insert(graph_.edges.end(), look_backs_.begin(), look_backs_.end());
  if (closed) {
    graph_.joints.push_back(*std::move(closed));
    adjusted_about_.push_back(graph_.state);
    bundle_to_relax_ = true;
  }
}

// Whether a camera sits otherwise than it did.
void Localiser::check_for_knock() {
  to_check_for_knock_ = false;
  const RigPriorState rig{graph_.state, state_information_};
  const std::optional<JointEdge> part = keyframe_odometry_.part(rig);
  if (!part) {
    return;
  }
  const std::optional<Knock> knock =
      knock_check_.add(*part, graph_.state, known_covariance(state_information_, variance_factor_),
                       variance_factor_);
  if (knock) {
    take_note(*knock);
  }
}

JumpCheck::Shows Localiser::shown_jumps() const {
  const RigPriorState rig{graph_.state,
                          known_covariance(state_information_, variance_factor_).inverse()};
  return [this, rig](int at, int before, int most,
                     const std::optional<KeyframeOdometry::PictureThird>& without) {
    return keyframe_odometry_.jump(rig, at, before, most, without);
  };
}

// The keyframes that are to be judged, one at a time.
void Localiser::judge_jump() {
  if (const std::optional<Knock> knock =
          jump_check_.judge(keyframe_odometry_.newest(), shown_jumps())) {
    take_note(*knock);
  }
}

// All bundles end before it is asked what they say.
void Localiser::take_note(const Knock& knock) {
  const int newest = keyframe_odometry_.newest();
  if (graph_.joints.empty() || last_of(graph_.joints.back()) < newest) {
    take_in(keyframe_odometry_.close({graph_.state, state_information_}), {});
  }
  begin_anew(knock);
  jump_check_.begin_anew(newest);
}

// A bundle from what its keyframes saw, but for one camera.
JointEdge Localiser::adjusted_anew(const JointEdge& joint, const RigPriorState& rig, int without,
                                   bool near) const {
  const int last = last_of(joint);
  std::vector<PlaceFeatures> features;
  for (int k = joint.first; k <= last; ++k) {
    features.push_back(closer_.place(k).features);
    features.back().resize(believed_.size());
    if (without >= 0) {
      features.back()[without] = {};
    }
  }
  return keyframe_odometry_.bundle_again(
      joint, {frames_.begin() + joint.first, frames_.begin() + last + 1}, features, rig, near);
}

// The first bundles were linearised about a rig that was hardly known. The first of those from
// which it has gone far is adjusted again: one a keyframe.
void Localiser::linearise_again() {
  to_linearise_ = false;
  constexpr double kFar_rad = deg_to_rad(0.15);
  constexpr double kFar_m = 0.002;
  constexpr double kFar = 0.001;
  constexpr double kFar_px = 0.4;
  constexpr double kFar_s = 0.001;
  RigState far = RigState::Constant(graph_.state.size(), kFar);
  for (int camera = 0; camera < static_cast<int>(believed_.size()); ++camera) {
    const int first = camera_state(camera);
    far.segment<3>(first + kRotation).setConstant(kFar_rad);
    far.segment<2>(first + kPosition).setConstant(kFar_m);
    far[first + kHeight] = std::numeric_limits<double>::infinity();  // bundles do not show it
    far.segment<2>(first + kCentre).setConstant(kFar_px);
    far[first + kClock] = kFar_s;
  }
  for (std::size_t k = settled_; k < graph_.joints.size(); ++k) {
    JointEdge& joint = graph_.joints[k];
    if (((graph_.state - adjusted_about_[k]).cwiseAbs().array() > far.array()).any()) {
      joint = adjusted_anew(joint, {graph_.state, state_information_}, -1, true);
      adjusted_about_[k] = graph_.state;
      return;
    }
  }
}

// What bundles showed of the camera before it was knocked is of another mounting; those since are
// adjusted anew, the ones during which it was knocked without it.
void Localiser::begin_anew(const Knock& knock) {
  constexpr double kTurned_rad = deg_to_rad(3);
  constexpr double kShifted_m = 0.03;
  MountingChange sigmas;
  sigmas << kTurned_rad, kTurned_rad, kTurned_rad, kShifted_m, kShifted_m, kShifted_m;
  const int state = camera_state(knock.camera);
  Eigen::MatrixXd covariance = state_information_.inverse();
  covariance.middleRows<kMountingStates>(state).setZero();
  covariance.middleCols<kMountingStates>(state).setZero();
  covariance.diagonal().segment<kMountingStates>(state) = sigmas.cwiseAbs2();
  forget_mounting(graph_.prior_information, state, sigmas);
  const RigState before = graph_.state;
  graph_.state.segment<kMountingStates>(state) += knock.change;
  const RigPriorState now{graph_.state, covariance.inverse()};

  std::vector<JointEdge>& joints = graph_.joints;
  // the first that shows it as it sits now, and the first that may not show it as it sat before
  const auto after = std::find_if(joints.begin(), joints.end(),
                                  [&](const JointEdge& joint) { return joint.first >= knock.end; });
  const auto during = std::find_if(
      joints.begin(), after, [&](const JointEdge& joint) { return last_of(joint) > knock.begin; });
  std::for_each(joints.begin(), during,
                [&](JointEdge& joint) { hold(joint, state, kMountingStates, before); });
  for (auto joint = during; joint != joints.end(); ++joint) {
    *joint = adjusted_anew(*joint, now, joint < after ? knock.camera : -1, false);
    adjusted_about_[joint - joints.begin()] = now.state;
  }
  settled_ = std::max(0, static_cast<int>(after - joints.begin()));
  const auto is_between = [&](const SharedEdge& shared) { return shared.edge.to > during->first; };
  for (std::vector<SharedEdge>* edges : {&graph_.edges, &look_backs_}) {
    std::erase_if(*edges, is_between);
    for (SharedEdge& shared : *edges) {
      hold(shared, state, kMountingStates, before);
    }
  }
  closer_.forget(knock.camera, after == joints.end() ? last_of(joints.back()) : after->first);
  knock_check_.begin_anew();
  knocks_.push_back({believed_[knock.camera].name, keyframes_[knock.begin].stamp,
                     keyframes_.back().stamp, knock.change.head<3>().norm(),
                     knock.change.segment<2>(kPosition).norm()});
}

// What the last bundle showed moves all keyframes.
void Localiser::relax_bundle(Located& out) {
  relax(graph_);
  state_information_ = state_covariance(graph_).inverse();
  variance_factor_ = variance_factor(graph_);
  bundle_to_relax_ = false;
  out.relaxed = true;
}

void Localiser::add_keyframe(const Observation& seen, const LoopPlace& place, Located& out) {
  const int made = static_cast<int>(keyframes_.size());
  Keyframe keyframe{seen.stamp, seen.odometry.T_odom_body, Pose2{}};
  if (!place.features.empty()) {
    rig_check_.add_keyframe(seen.stamp, place.taken, place.features, out.T_last_body);
  }
  const Pose2 T_last_here = link_to_last(seen.stamp, place, out.T_last_body);
  if (made == 0) {
    graph_.T_map_node.push_back(Pose2{});
  } else {
    keyframe.T_odom_body = keyframes_.back().T_odom_body * T_last_here;
    graph_.T_map_node.push_back(graph_.T_map_node.back() * T_last_here);
    if (!place.featureless()) {
      const auto step_grey = static_cast<float>(emd_grey(place.signature, last_signature_));
      steps_grey_.insert(std::upper_bound(steps_grey_.begin(), steps_grey_.end(), step_grey),
                         step_grey);
    }
  }
  if (not_this_rig_.empty()) {
    not_this_rig_ = not_this_rig(believed_, graph_.state);
  }
  to_check_for_knock_ = true;
  to_look_for_jump_ = options_.knocks_at_once;
  to_look_back_ = true;
  to_look_for_loops_ = true;
  loops_to_close_ = true;
  to_linearise_ = options_.visual_heading && !bundle_to_relax_;
  last_signature_ = place.signature;
  keyframes_.push_back(keyframe);
  out.keyframe_made = made;
  out.T_last_body = Pose2{};
}

// Of the keyframes not long ago and about where the newest is, the one whose heading differs from
// its heading by about `turn_rad`; -1 where there is none.
int Localiser::keyframe_turned_by(double turn_rad) const {
  constexpr int kMemory = 80;  // keyframes: two turns
  constexpr int kAway = 8;
  constexpr double kNear_m = 0.3;
  const int here = static_cast<int>(graph_.T_map_node.size()) - 1;
  int best = -1;
  double least_rad = options_.keyframe.turn_rad;
  for (int k = std::max(0, here - kMemory); k <= here - kAway; ++k) {
    const Pose2 T = graph_.T_map_node[k].inverse() * graph_.T_map_node[here];
    const double off_rad = std::abs(wrap_angle(T.theta_rad - turn_rad));
    if (T.position().norm() <= kNear_m && off_rad < least_rad && !closer_.place(k).featureless()) {
      best = k;
      least_rad = off_rad;
    }
  }
  return best;
}

// A body that turns on the spot looks the same way again after a whole turn, and with its back
// camera where it looked with its front camera after half of one.
void Localiser::look_back() {
  to_look_back_ = false;
  const int here = static_cast<int>(graph_.T_map_node.size()) - 1;
  const LoopPlace& place = closer_.place(here);
  if (place.featureless()) {
    return;
  }
  std::optional<SharedUncertainty> uncertainty;
  for (const Facing& facing : facings_) {
    const int then = keyframe_turned_by(facing.turn_rad);
    if (then < 0) {
      continue;
    }
    if (!uncertainty) {
      uncertainty.emplace(graph_);
    }
    const LoopPlace& place_then = closer_.place(then);
    const Pose2 T_then_here = graph_.T_map_node[then].inverse() * graph_.T_map_node[here];
    std::optional<SharedEdge> edge =
        &facing == &facings_.front()
            ? heading_edge(options_.bundle.bundle, options_.loops.features, believed_, graph_.state,
                           {then, &frames_[then], &place_then.features},
                           {here, &frames_[here], &place.features}, T_then_here,
                           uncertainty->relative(then, here))
            : facing_edge(
                  options_.loops.motion, options_.loops.features, believed_, graph_.state, facing,
                  {then, {place_then.taken, place_then.features, closer_.depths(then, graph_)}},
                  {here, {place.taken, place.features, closer_.depths(here, graph_)}}, T_then_here,
                  *uncertainty);
    if (edge) {
      look_backs_.push_back(*edge);
      graph_.edges.push_back(*std::move(edge));
    }
  }
}

void Localiser::close_loops(const ContourSource& contours, Located& out) {
  loops_to_close_ = false;
  out.closures = closer_.close(graph_, contours);
  out.relaxed = out.relaxed || std::any_of(out.closures.begin(), out.closures.end(),
                                           [](const ClosureReport& c) { return c.accepted; });
}

// One thing that the last keyframe has left to do.
void Localiser::catch_up(const ContourSource& contours, Located& out) {
  if (to_check_for_knock_) {
    check_for_knock();
  } else if (to_look_for_jump_) {
    to_look_for_jump_ = false;
    jump_check_.look(keyframe_odometry_.newest(), shown_jumps());
  } else if (jump_check_.to_judge(keyframe_odometry_.newest())) {
    judge_jump();
  } else if (to_look_back_) {
    look_back();
  } else if (to_look_for_loops_) {
    to_look_for_loops_ = false;
    closer_.look(graph_, contours);
  } else if (loops_to_close_) {
    close_loops(contours, out);
  } else if (bundle_to_relax_) {
    relax_bundle(out);
  } else if (to_linearise_) {
    linearise_again();
  }
}

// Of the states whose information by the graph alone this is: as keyframes disagree, and no surer
// than pictures are.
Eigen::MatrixXd Localiser::known_covariance(const Eigen::MatrixXd& information,
                                            double variance_factor) const {
  const Eigen::MatrixXd& prior = graph_.prior_information;
  const Eigen::MatrixXd told = (information - prior) / variance_factor;
  const Eigen::MatrixXd unsurer = Eigen::MatrixXd::Identity(prior.rows(), prior.cols()) +
                                  systematic_covariance(believed_) * told;
  const Eigen::MatrixXd known = told * unsurer.inverse();
  return (prior + 0.5 * (known + known.transpose())).inverse();
}

RigEstimate Localiser::rig_estimate() const {
  return {believed_, graph_.state,
          known_covariance(state_covariance(graph_).inverse(), variance_factor(graph_)),
          graph_.prior_information.inverse(), knocks_};
}

Located Localiser::step(const Observation& seen, const ContourSource& contours,
                        const StageListener& listener, const CameraReports& cameras) {
  Located out;
  LoopPlace place;
  {
    const StageScope scope(listener, "odometry");
    rig_check_.add_odometry(seen.stamp, seen.odometry.T_odom_body.theta_rad);
    if (!keyframes_.empty()) {
      out.T_last_body = keyframes_.back().T_wheels_body.inverse() * seen.odometry.T_odom_body;
    }
    if (const std::optional<Views> views = views_of(seen, cameras)) {
      place.partial = std::find(views->begin(), views->end(), nullptr) != views->end();
      place.signature = signature_of(*views);
      if (keyframes_.empty() || keyframe_due(out.T_last_body, place)) {
        while (to_check_for_knock_ || to_look_for_jump_ ||
               jump_check_.to_judge(keyframe_odometry_.newest()) || to_look_back_ ||
               to_look_for_loops_ || loops_to_close_ || bundle_to_relax_) {
          catch_up(contours, out);
        }
        place.features = features_of(*views);
        place.taken = times_of(*views, seen.stamp, seen.odometry.twist_body);
        add_keyframe(seen, place, out);
        closer_.add(std::move(place), graph_);
      }
    }
  }
  const StageScope scope(listener, "slam");
  if (!out.keyframe_made) {
    catch_up(contours, out);
  }
  if (!keyframes_.empty()) {
    out.keyframe = static_cast<int>(keyframes_.size()) - 1;
    out.T_odom_body = keyframes_.back().T_odom_body * out.T_last_body;
    out.T_map_body = graph_.T_map_node.back() * out.T_last_body;
  }
  return out;
}

}  // namespace panoptes
