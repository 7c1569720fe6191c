// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/heading_edge.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "core/geometry/covariance.h"

namespace panoptes {
namespace {

constexpr int kFewest = 20;                    // features that agree
constexpr double kFewestShare = 0.4;           // of those that match
constexpr double kOff_m = 0.005;               // a place is never known better from afar,
constexpr double kOff_rad = 0.0007;            // nor a heading: an eighth of a pixel
constexpr double kMost_squared_sigmas = 14.2;  // of three freedoms: once in 400 right ones
constexpr double kAnyHeading_rad = 1;
constexpr double kAnyPosition_m = 1e3;

}  // namespace

std::optional<SharedEdge> heading_edge(const BundleOptions& options, const FeatureOptions& features,
                                       const LoopCameras& cameras, const RigState& state,
                                       const HeadingView& from, const HeadingView& to,
                                       const Pose2& T_from_to, const Mat3& covariance) {
  std::vector<Track> tracks;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    const LocalFeatures& a = (*from.features)[camera];
    const LocalFeatures& b = (*to.features)[camera];
    for (const FeatureMatch& match : match_features(features, a, b)) {
      tracks.push_back({static_cast<int>(camera),
                        {{0, match.a, a.px[match.a].cast<double>()},
                         {1, match.b, b.px[match.b].cast<double>()}}});
    }
  }
  if (tracks.size() < kFewest) {
    return std::nullopt;
  }
  std::vector<BundleFrame> frames{*from.frame, *to.frame};
  frames[1].T_before_here = T_from_to;
  frames[1].by_wheels = nullptr;
  frames[1].covariance = covariance;
  frames[1].covariance.row(2).setZero();
  frames[1].covariance.col(2).setZero();
  frames[1].covariance(2, 2) = kAnyHeading_rad * kAnyHeading_rad;
  const BundleSolution solution =
      adjust_bundle(options, cameras, {state, {}}, frames, tracks, {Pose2{}, T_from_to});
  if (std::count(solution.inlier.begin(), solution.inlier.end(), true) < kFewest) {
    return std::nullopt;
  }
  const Eigen::Index states = state.size();
  const Eigen::LDLT<Eigen::MatrixXd> poses(solution.information.topLeftCorner<3, 3>());
  const Mat3 found = poses.solve(Mat3::Identity());
  const Eigen::MatrixXd by_state = -poses.solve(solution.information.topRightCorner(3, states));
  const Vec3 left = -poses.solve(solution.gradient.head<3>());
  SharedEdge edge;
  edge.edge.from = from.keyframe;
  edge.edge.to = to.keyframe;
  edge.edge.T_from_to = {T_from_to.x_m, T_from_to.y_m,
                         wrap_angle(solution.T_first_frame[1].theta_rad + left.z())};
  edge.edge.information = Mat3::Zero();
  edge.edge.information.diagonal() << 1 / (kAnyPosition_m * kAnyPosition_m),
      1 / (kAnyPosition_m * kAnyPosition_m), 1 / found(2, 2);
  edge.state = state;
  edge.by_state = Eigen::MatrixXd::Zero(3, states);
  edge.by_state.row(2) = by_state.row(2);
  return edge;
}

std::optional<SharedEdge> facing_edge(const MotionOptions& options, const FeatureOptions& features,
                                      const LoopCameras& cameras, const RigState& state,
                                      const Facing& facing, const FacingView& from,
                                      const FacingView& to, const Pose2& T_from_to,
                                      const SharedUncertainty& uncertainty) {
  const std::vector<PlaceMatch> matches =
      match_places(features, from.place.features, to.place.features, facing);
  MotionPrior prior{T_from_to, uncertainty.relative(from.keyframe, to.keyframe)};
  prior.covariance.diagonal() += Vec3(kOff_m, kOff_m, kOff_rad).cwiseAbs2();
  const LoopCameras cameras_from = at_keyframe(cameras, state, from.place.taken);
  const LoopCameras cameras_to = at_keyframe(cameras, state, to.place.taken);
  const std::optional<PlanarMotion> motion =
      motion_by_features(options, {cameras_from, from.place.features, from.place.depths},
                         {cameras_to, to.place.features, to.place.depths}, matches, prior, nullptr);
  if (!motion || motion->inliers < kFewest ||
      motion->inliers < kFewestShare * static_cast<double>(matches.size())) {
    return std::nullopt;
  }
  SharedEdge edge;
  edge.edge = {from.keyframe, to.keyframe, motion->T_a_b_seen, Mat3::Zero(), false};
  edge.state = state;
  edge.by_state = motion_by_rig(options, cameras, state, from.place, to.place,
                                motion->inlier_matches, motion->T_a_b_seen);
  const std::optional<Mat3> seen = inverse_of(motion->information_seen);
  if (!seen || !edge.by_state.allFinite()) {
    return std::nullopt;
  }
  Mat3 unsure = *seen;
  unsure.diagonal() += Vec3(kOff_m, kOff_m, kOff_rad).cwiseAbs2();
  const Vec3 off(motion->T_a_b_seen.x_m - T_from_to.x_m, motion->T_a_b_seen.y_m - T_from_to.y_m,
                 wrap_angle(motion->T_a_b_seen.theta_rad - T_from_to.theta_rad));
  const Mat3 expected = uncertainty.relative(from.keyframe, to.keyframe, edge.by_state);
  if (!(squared_sigmas(off, expected + unsure) <= kMost_squared_sigmas)) {
    return std::nullopt;
  }
  edge.edge.information = unsure.inverse();
  return edge;
}

}  // namespace panoptes
