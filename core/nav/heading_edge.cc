// SPDX-License-Identifier: BSD-3-Clause
#include "core/nav/heading_edge.h"

#include <algorithm>

#include <Eigen/Cholesky>

namespace panoptes {
namespace {

constexpr int kFewest = 20;  // features that agree
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

}  // namespace panoptes
