// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/mono_filter.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/base/check.h"
#include "core/camera/lens_parameters.h"
#include "core/camera/mounting.h"
#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

// Where the camera's numbers stand in the covariance.
constexpr Eigen::Index kShift = 0;
constexpr Eigen::Index kTurn = 3;
constexpr Eigen::Index kVelocity = 6;
constexpr Eigen::Index kTurnRate = 9;
constexpr Eigen::Index kCamera = 12;  // without its lens, which comes next

// A point's depth is told by others where at least so many are known to such a share.
constexpr int kFewestNeighbours = 3;
constexpr double kKnownRatio = 0.3;
// Of what they tell, at least; things stand before one another.
constexpr double kLeastSpread = 0.5;

/// How the end of a turn moves with the turn, both as small turns about the axes at the end.
Mat3 right_jacobian(const Vec3& turn_rad) {
  const double angle = turn_rad.norm();
  const Mat3 cross = cross_matrix(turn_rad);
  if (angle < 1e-4) {  // the next term is a billionth
    return Mat3::Identity() - cross / 2;
  }
  return Mat3::Identity() - (1 - std::cos(angle)) / (angle * angle) * cross +
         (angle - std::sin(angle)) / (angle * angle * angle) * cross * cross;
}

Vec3 as_turn(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace

std::vector<PointMatch> inliers(const std::vector<PointMatch>& matches,
                                const FilterUpdate& update) {
  std::vector<PointMatch> out;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (update.inlier[i]) {
      out.push_back(matches[i]);
    }
  }
  return out;
}

MonoFilter::MonoFilter(const MonoFilterOptions& options, const Intrinsics& lens)
    : options_(options), lens_(lens), P_(Eigen::MatrixXd::Zero(kCamera, kCamera)) {
  const Eigen::Index parameters = lens_parameters(lens).size();
  if (options.focal_ratio > 0 && options.centre_px > 0) {
    // Both focal lengths, each as a share; the centre; the distortion.
    lens_by_held_.setZero(parameters, parameters - 1);
    lens_by_held_.block<2, 1>(0, 0) << lens.fx_px, lens.fy_px;
    lens_by_held_.bottomRightCorner(parameters - 2, parameters - 2).setIdentity();
    P_.setZero(kCamera + parameters - 1, kCamera + parameters - 1);
    P_.diagonal().tail(parameters - 1).setConstant(options.focal_ratio * options.focal_ratio);
    P_.diagonal().segment<2>(kCamera + 1).setConstant(options.centre_px * options.centre_px);
  } else {
    lens_by_held_.setZero(parameters, 0);
  }
  const double speed = options.start_speed_mps;
  const double turn = options.start_turn_radps;
  P_.diagonal().segment<3>(kVelocity).setConstant(speed * speed);
  P_.diagonal().segment<3>(kTurnRate).setConstant(turn * turn);
}

void MonoFilter::transform_camera(const Eigen::Matrix<double, 12, 12>& F,
                                  const Eigen::Matrix<double, 12, 12>& Q) {
  P_.topRows<kCamera>() = (F * P_.topRows<kCamera>()).eval();
  P_.leftCols<kCamera>() = (P_.leftCols<kCamera>() * F.transpose()).eval();
  P_.topLeftCorner<kCamera, kCamera>() += Q;
}

void MonoFilter::predict(double dt_s, const std::optional<MotionTold>& told) {
  PANOPTES_CHECK(dt_s >= 0, "a picture is not before the one before it");
  if (told) {
    predict_as_told(dt_s, *told);
    return;
  }
  const Vec3 turn_rad = turn_rate_radps_ * dt_s;
  const Mat3 end_by_rate = right_jacobian(turn_rad) * dt_s;
  const Eigen::Quaterniond turn = turned_by(turn_rad);
  Eigen::Matrix<double, 12, 12> F = Eigen::Matrix<double, 12, 12>::Identity();
  F.block<3, 3>(kShift, kVelocity) = dt_s * Mat3::Identity();
  F.block<3, 3>(kTurn, kTurn) = turn.conjugate().toRotationMatrix();
  F.block<3, 3>(kTurn, kTurnRate) = end_by_rate;
  Eigen::Matrix<double, 12, 6> by_impulse = Eigen::Matrix<double, 12, 6>::Zero();
  by_impulse.block<3, 3>(kShift, 0) = dt_s * Mat3::Identity();
  by_impulse.block<3, 3>(kVelocity, 0).setIdentity();
  by_impulse.block<3, 3>(kTurn, 3) = end_by_rate;
  by_impulse.block<3, 3>(kTurnRate, 3).setIdentity();
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Vec3::Constant(options_.acceleration_mps2 * dt_s),
      Vec3::Constant(options_.turn_acceleration_radps2 * dt_s);
  const Eigen::Matrix<double, 12, 6> scaled = by_impulse * sigma.asDiagonal();
  transform_camera(F, scaled * scaled.transpose());
  T_map_camera_.translation += velocity_map_ * dt_s;
  T_map_camera_.rotation = (T_map_camera_.rotation * turn).normalized();
}

void MonoFilter::predict_turned(double dt_s, const MotionTold& told) {
  PANOPTES_CHECK(dt_s > 0, "a told turn takes time");
  const Eigen::Quaterniond turn = told.T_before_now.rotation;
  Eigen::Matrix<double, 12, 12> F = Eigen::Matrix<double, 12, 12>::Zero();
  F.block<3, 3>(kShift, kShift).setIdentity();
  F.block<3, 3>(kShift, kVelocity) = dt_s * Mat3::Identity();
  F.block<3, 3>(kVelocity, kVelocity).setIdentity();
  F.block<3, 3>(kTurn, kTurn) = turn.conjugate().toRotationMatrix();
  Eigen::Matrix<double, 12, 6> by_error = Eigen::Matrix<double, 12, 6>::Zero();
  by_error.block<3, 3>(kShift, 0) = dt_s * Mat3::Identity();
  by_error.block<3, 3>(kVelocity, 0).setIdentity();
  by_error.block<3, 3>(kTurn, 3).setIdentity();
  by_error.block<3, 3>(kTurnRate, 3) = Mat3::Identity() / dt_s;
  Eigen::Matrix<double, 6, 6> Q = Eigen::Matrix<double, 6, 6>::Zero();
  Q.diagonal().head<3>().setConstant(std::pow(options_.acceleration_mps2 * dt_s, 2));
  Q.bottomRightCorner<3, 3>() = told.covariance.bottomRightCorner<3, 3>();
  transform_camera(F, by_error * Q * by_error.transpose());
  turn_rate_radps_ = as_turn(turn) / dt_s;
  T_map_camera_.translation += velocity_map_ * dt_s;
  T_map_camera_.rotation = (T_map_camera_.rotation * turn).normalized();
}

void MonoFilter::predict_as_told(double dt_s, const MotionTold& told) {
  PANOPTES_CHECK(dt_s > 0, "a told motion takes time");
  const Pose3& T_before_now = told.T_before_now;
  const Mat3 R_map_before = T_map_camera_.rotation.toRotationMatrix();
  Eigen::Matrix<double, 12, 12> F = Eigen::Matrix<double, 12, 12>::Zero();
  F.block<3, 3>(kShift, kShift).setIdentity();
  F.block<3, 3>(kShift, kTurn) = -R_map_before * cross_matrix(T_before_now.translation);
  F.block<3, 3>(kTurn, kTurn) = T_before_now.rotation.conjugate().toRotationMatrix();
  Eigen::Matrix<double, 12, 6> by_error = Eigen::Matrix<double, 12, 6>::Zero();
  by_error.block<3, 3>(kShift, 0) = R_map_before;
  by_error.block<3, 3>(kTurn, 3).setIdentity();
  by_error.block<3, 3>(kVelocity, 0) = R_map_before / dt_s;
  by_error.block<3, 3>(kTurnRate, 3) = Mat3::Identity() / dt_s;
  transform_camera(F, by_error * told.covariance * by_error.transpose());
  velocity_map_ = R_map_before * T_before_now.translation / dt_s;
  turn_rate_radps_ = as_turn(T_before_now.rotation) / dt_s;
  T_map_camera_ = T_map_camera_ * T_before_now;
}

std::optional<MonoFilter::Observed> MonoFilter::observe(const Pose3& T_map_camera,
                                                        const FilteredPoint& point) const {
  const PointSeen seen = seen_from(T_map_camera, point);
  if (!lens_.sees(seen.p_camera)) {
    return std::nullopt;
  }
  const Projection drawn = project_with_jacobian(lens_, seen.p_camera);
  Observed observed{drawn.px, drawn.px_by_point * seen.by_camera, drawn.px_by_lens * lens_by_held_,
                    drawn.px_by_point * seen.by_state, std::nullopt};
  if (point.is_inverse_depth()) {
    observed.by_shift_and_depth =
        drawn.px_by_point * T_map_camera.rotation.conjugate().toRotationMatrix();
  }
  return observed;
}

// A point's inverse depth and the camera's shift from where it was first seen move its place only
// by their product, which has no slope where there is no shift: what their errors make of it
// together is noise (Gaussian second-order filter: Jazwinski 1970, 9.3).
Vec2 MonoFilter::mean_of(const Held& of, const Observed& o) const {
  if (!o.by_shift_and_depth) {
    return o.px;
  }
  return o.px + *o.by_shift_and_depth *
                    (P_.block<3, 1>(of.at, of.at + 5) - P_.block<3, 1>(kShift, of.at + 5));
}

Mat2 MonoFilter::second_order(const Held& of, const Observed& o) const {
  if (!o.by_shift_and_depth) {
    return Mat2::Zero();
  }
  const Mat3 across = P_.block<3, 3>(of.at, kShift);
  const Mat3 shift =
      P_.block<3, 3>(of.at, of.at) + P_.block<3, 3>(kShift, kShift) - across - across.transpose();
  const Vec3 both = P_.block<3, 1>(of.at, of.at + 5) - P_.block<3, 1>(kShift, of.at + 5);
  const Mat3 product = P_(of.at + 5, of.at + 5) * shift + both * both.transpose();
  return *o.by_shift_and_depth * product * o.by_shift_and_depth->transpose();
}

Eigen::Matrix<double, Eigen::Dynamic, 2> MonoFilter::covariance_with(const Held& of,
                                                                     const Observed& o) const {
  return P_.leftCols<6>() * o.by_camera.transpose() +
         P_.middleCols(kCamera, o.by_lens.cols()) * o.by_lens.transpose() +
         P_.middleCols(of.at, o.by_state.cols()) * o.by_state.transpose();
}

// How its place moves with all that is held.
template <class Rows>
Eigen::Matrix<double, 2, Rows::ColsAtCompileTime> MonoFilter::moved_px(const Held& of,
                                                                       const Observed& o,
                                                                       const Rows& all) const {
  return o.by_camera * all.template topRows<6>() +
         o.by_lens * all.middleRows(kCamera, o.by_lens.cols()) +
         o.by_state * all.middleRows(of.at, o.by_state.cols());
}

Mat2 MonoFilter::covariance_of(const Held& of, const Observed& o) const {
  const Eigen::Index size = o.by_state.cols();
  const Eigen::Index lens = o.by_lens.cols();
  const Mat2 across = o.by_camera * (P_.block(0, of.at, 6, size) * o.by_state.transpose() +
                                     P_.block(0, kCamera, 6, lens) * o.by_lens.transpose()) +
                      o.by_lens * P_.block(kCamera, of.at, lens, size) * o.by_state.transpose();
  return o.by_camera * P_.topLeftCorner<6, 6>() * o.by_camera.transpose() + across +
         across.transpose() +
         o.by_lens * P_.block(kCamera, kCamera, lens, lens) * o.by_lens.transpose() +
         o.by_state * P_.block(of.at, of.at, size, size) * o.by_state.transpose() +
         second_order(of, o);
}

std::optional<PointExpected> MonoFilter::expected(int number) const {
  const Held& of = held(number);
  const std::optional<Observed> o = observe(T_map_camera_, of.point);
  if (!o) {
    return std::nullopt;
  }
  return PointExpected{mean_of(of, *o), covariance_of(of, *o)};
}

void MonoFilter::move(const Eigen::VectorXd& by) {
  T_map_camera_.translation += by.segment<3>(kShift);
  T_map_camera_.rotation = (T_map_camera_.rotation * turned_by(by.segment<3>(kTurn))).normalized();
  velocity_map_ += by.segment<3>(kVelocity);
  turn_rate_radps_ += by.segment<3>(kTurnRate);
  if (const Eigen::Index lens = lens_by_held_.cols(); lens > 0) {
    lens_ =
        with_parameters(lens_, lens_parameters(lens_) + lens_by_held_ * by.segment(kCamera, lens));
  }
  for (Held& each : points_) {
    each.point.state += by.segment(each.at, each.point.state.size());
  }
}

// What the matches tell together.
MonoFilter::Linearised MonoFilter::linearised(const std::vector<PointMatch>& matches,
                                              const std::vector<std::size_t>& which) const {
  std::vector<const Held*> of;
  std::vector<Observed> observed;
  for (const std::size_t i : which) {
    of.push_back(&held(matches[i].point));
    const std::optional<Observed> o = observe(T_map_camera_, of.back()->point);
    PANOPTES_CHECK(o.has_value(), "a match is of a point that is expected on the picture");
    observed.push_back(*o);
  }
  const auto count = static_cast<Eigen::Index>(which.size());
  Linearised out;
  out.innovation.resize(2 * count);
  out.PHt.resize(P_.rows(), 2 * count);
  out.S.resize(2 * count, 2 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Observed& o = observed[k];
    out.innovation.segment<2>(2 * i) = matches[which[k]].px - mean_of(*of[k], o);
    out.PHt.middleCols<2>(2 * i) = covariance_with(*of[k], o);
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Observed& o = observed[k];
    out.S.middleRows<2>(2 * i) = moved_px(*of[k], o, out.PHt);
    const double sigma_px = matches[which[k]].sigma_px;
    out.S.block<2, 2>(2 * i, 2 * i) +=
        second_order(*of[k], o) + sigma_px * sigma_px * Mat2::Identity();
  }
  return out;
}

// The match that is farthest from where all others tell it to be, of those that are too far: the
// others' word on it stands in the joint information.
std::optional<std::size_t> MonoFilter::farthest_off(const Linearised& told) const {
  const Eigen::MatrixXd information =
      told.S.llt().solve(Eigen::MatrixXd::Identity(told.S.rows(), told.S.cols()));
  const Eigen::VectorXd weighed = information * told.innovation;
  double worst = options_.gate_chi2;
  std::optional<std::size_t> out;
  for (Eigen::Index i = 0; 2 * i < told.S.rows(); ++i) {
    const Vec2 w = weighed.segment<2>(2 * i);
    const double squared = w.dot(Mat2(information.block<2, 2>(2 * i, 2 * i)).inverse() * w);
    if (squared > worst) {
      worst = squared;
      out = static_cast<std::size_t>(i);
    }
  }
  return out;
}

// Those of the matches that agree with all others together are taken in.
std::vector<std::size_t> MonoFilter::take_in(const std::vector<PointMatch>& matches,
                                             std::vector<std::size_t> which,
                                             double& squared_sigmas) {
  Linearised told = linearised(matches, which);
  while (which.size() > 1) {
    const std::optional<std::size_t> out = farthest_off(told);
    if (!out) {
      break;
    }
    which.erase(which.begin() + static_cast<std::ptrdiff_t>(*out));
    told = linearised(matches, which);
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(told.S);
  PANOPTES_CHECK(factor.info() == Eigen::Success, "the innovations' covariance is one");
  factor.matrixL().solveInPlace(told.innovation);
  const Eigen::MatrixXd W = factor.matrixL().solve(told.PHt.transpose());
  P_.selfadjointView<Eigen::Lower>().rankUpdate(W.transpose(), -1);
  P_.triangularView<Eigen::StrictlyUpper>() = P_.transpose();
  move(W.transpose() * told.innovation);
  squared_sigmas += told.innovation.squaredNorm();
  return which;
}

FilterUpdate MonoFilter::update(const std::vector<PointMatch>& matches, int fewest) {
  FilterUpdate result;
  result.inlier.assign(matches.size(), false);
  struct Hypothesis {
    const Held* of = nullptr;
    Observed expected;
    Eigen::Matrix<double, Eigen::Dynamic, 2> PHt;
    Mat2 S_inverse;
    Eigen::VectorXd move;  // of all that is held, were this match alone believed
  };
  std::vector<std::optional<Hypothesis>> all;
  for (const PointMatch& match : matches) {
    const Held& of = held(match.point);
    const std::optional<Observed> o = observe(T_map_camera_, of.point);
    all.emplace_back();
    if (o) {
      Hypothesis h{&of, *o, covariance_with(of, *o), Mat2::Zero(), {}};
      const Mat2 S = moved_px(of, *o, h.PHt) + second_order(of, *o) +
                     match.sigma_px * match.sigma_px * Mat2::Identity();
      h.S_inverse = S.inverse();
      h.move = h.PHt * (h.S_inverse * (match.px - mean_of(of, *o)));
      all.back() = std::move(h);
    }
  }
  // What agrees with each: that is where it would then be expected, as well as it would be known.
  const auto agree = [&](const Hypothesis& hypothesis, const Pose3& T, std::size_t i) {
    const Hypothesis& other = *all[i];
    FilteredPoint point = other.of->point;
    point.state += hypothesis.move.segment(other.of->at, point.state.size());
    const PointSeen seen = seen_from(T, point);
    if (!lens_.sees(seen.p_camera)) {
      return false;
    }
    const Observed& o = other.expected;
    const Mat2 across = moved_px(*other.of, o, hypothesis.PHt);
    const double sigma_px = matches[i].sigma_px;
    const Mat2 S = other.S_inverse.inverse() - across * hypothesis.S_inverse * across.transpose() +
                   (&hypothesis == &other ? 1 : 0) * sigma_px * sigma_px * Mat2::Identity();
    const Vec2 off = lens_.project(seen.p_camera) +
                     o.by_lens * hypothesis.move.segment(kCamera, o.by_lens.cols()) - matches[i].px;
    return off.dot(S.inverse() * off) < options_.gate_chi2;
  };
  std::vector<std::size_t> agreed;
  for (const std::optional<Hypothesis>& hypothesis : all) {
    if (!hypothesis) {
      continue;
    }
    Pose3 T = T_map_camera_;
    T.translation += hypothesis->move.segment<3>(kShift);
    T.rotation = (T.rotation * turned_by(hypothesis->move.segment<3>(kTurn))).normalized();
    std::vector<std::size_t> with_it;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (all[i] && agree(*hypothesis, T, i)) {
        with_it.push_back(i);
      }
    }
    if (with_it.size() > agreed.size()) {
      agreed = with_it;
    }
  }
  const auto take = [&](const std::vector<std::size_t>& which) {
    if (which.empty()) {
      return;
    }
    for (const std::size_t i : take_in(matches, which, result.squared_sigmas)) {
      result.inlier[i] = true;
      result.dof += 2;
    }
  };
  if (2 * agreed.size() < matches.size() || agreed.size() < static_cast<std::size_t>(fewest)) {
    return result;  // chance finds a few that agree
  }
  take(agreed);
  // Those that agree with all of these, if not with the one alone.
  std::vector<std::size_t> rescued;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (result.inlier[i] || std::find(agreed.begin(), agreed.end(), i) != agreed.end()) {
      continue;
    }
    const std::optional<PointExpected> now = expected(matches[i].point);
    if (!now) {
      continue;
    }
    const double sigma_px = matches[i].sigma_px;
    const Mat2 S = now->covariance_px2 + sigma_px * sigma_px * Mat2::Identity();
    const Vec2 off = matches[i].px - now->px;
    if (off.dot(S.inverse() * off) < options_.gate_chi2) {
      rescued.push_back(i);
    }
  }
  take(rescued);
  return result;
}

// By the known points on the picture: their mean, and in `sigma` their spread.
double MonoFilter::expected_inverse_depth(double& sigma) const {
  int count = 0;
  double sum = 0;
  double squares = 0;
  for (const Held& each : points_) {
    if (!each.point.is_inverse_depth() ||
        (each.point.state[5] > 0 &&
         std::sqrt(P_(each.at + 5, each.at + 5)) < kKnownRatio * each.point.state[5])) {
      const Vec3 from_camera = each.point.p_map() - T_map_camera_.translation;
      if (lens_.sees(T_map_camera_.rotation.conjugate() * from_camera)) {
        const double per_m = 1 / from_camera.norm();
        ++count;
        sum += per_m;
        squares += per_m * per_m;
      }
    }
  }
  if (count < kFewestNeighbours) {
    sigma = options_.inverse_depth_sigma;
    return options_.inverse_depth_per_m;
  }
  const double mean = sum / count;
  sigma = std::max(kLeastSpread * mean, std::sqrt(std::max(0.0, squares / count - mean * mean)));
  return mean;
}

int MonoFilter::add(const Vec2& px, double sigma_px, std::optional<double> inverse_depth_per_m) {
  const std::optional<Vec3> direction = lens_.direction(px);
  PANOPTES_CHECK(direction.has_value(), "a pixel that a point is made of has a direction");
  const auto by_px = direction_by_px(lens_, *direction);
  PANOPTES_CHECK(by_px.has_value(), "a pixel that a point is made of has a direction of its own");
  double inverse_depth_sigma = options_.inverse_depth_sigma;
  const double inverse_depth =
      inverse_depth_per_m ? *inverse_depth_per_m : expected_inverse_depth(inverse_depth_sigma);
  const Mat3 R = T_map_camera_.rotation.toRotationMatrix();
  const Vec3 direction_map = R * *direction;
  const Eigen::Matrix<double, 2, 3> angles = angles_by_direction(direction_map) * R;
  Eigen::Matrix<double, 6, 6> by_camera = Eigen::Matrix<double, 6, 6>::Zero();
  by_camera.topLeftCorner<3, 3>().setIdentity();
  by_camera.block<2, 3>(3, kTurn) = -angles * cross_matrix(*direction);
  const Mat2 angles_by_px = angles * *by_px;
  const Eigen::Index lens = lens_by_held_.cols();
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 9> by_lens =
      Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 9>::Zero(6, lens);
  by_lens.middleRows<2>(3) =
      -angles_by_px * project_with_jacobian(lens_, *direction).px_by_lens * lens_by_held_;

  const Eigen::Index n = P_.rows();
  P_.conservativeResize(n + 6, n + 6);
  P_.block(n, 0, 6, n) =
      by_camera * P_.topLeftCorner(6, n) + by_lens * P_.block(kCamera, 0, lens, n);
  P_.block(0, n, n, 6) = P_.block(n, 0, 6, n).transpose();
  Eigen::Matrix<double, 6, 6> own = P_.block<6, 6>(n, 0) * by_camera.transpose() +
                                    P_.block(n, kCamera, 6, lens) * by_lens.transpose();
  own.block<2, 2>(3, 3) += sigma_px * sigma_px * angles_by_px * angles_by_px.transpose();
  own(5, 5) += inverse_depth_sigma * inverse_depth_sigma;
  P_.bottomRightCorner<6, 6>() = own;
  points_.push_back(
      {next_number_, n, seen_point(T_map_camera_.translation, direction_map, inverse_depth)});
  return next_number_++;
}

void MonoFilter::fix_metre() {
  Eigen::VectorXd PHt = Eigen::VectorXd::Zero(P_.rows());
  int count = 0;
  for (const Held& each : points_) {
    if (each.point.is_inverse_depth()) {
      PHt += P_.col(each.at + 5);
      ++count;
    }
  }
  double variance = 0;
  for (const Held& each : points_) {
    variance += each.point.is_inverse_depth() ? PHt[each.at + 5] : 0;
  }
  if (count > 1 && variance > 0) {
    P_ -= PHt * PHt.transpose() / variance;
  }
}

// The numbers of one block become fewer: by * them.
void MonoFilter::shrink(std::size_t which, const Eigen::Matrix<double, Eigen::Dynamic, 6>& by) {
  const Eigen::Index at = points_[which].at;
  const Eigen::Index was = points_[which].point.state.size();
  const Eigen::Index is = by.rows();
  const Eigen::Index after = P_.rows() - at - was;
  const Eigen::MatrixXd rows = by.leftCols(was) * P_.middleRows(at, was);
  P_.middleRows(at, is) = rows;
  P_.middleRows(at + is, after) = P_.bottomRows(after).eval();
  const Eigen::MatrixXd columns = P_.middleCols(at, was) * by.leftCols(was).transpose();
  P_.middleCols(at, is) = columns;
  P_.middleCols(at + is, after) = P_.rightCols(after).eval();
  P_.conservativeResize(P_.rows() - was + is, P_.cols() - was + is);
  for (std::size_t i = which + 1; i < points_.size(); ++i) {
    points_[i].at -= was - is;
  }
}

void MonoFilter::remove(int number) {
  const Held& of = held(number);
  const auto which = static_cast<std::size_t>(&of - points_.data());
  shrink(which, Eigen::Matrix<double, Eigen::Dynamic, 6>(0, 6));
  points_.erase(points_.begin() + static_cast<std::ptrdiff_t>(which));
}

void MonoFilter::convert() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const FilteredPoint& point = points_[i].point;
    if (!point.is_inverse_depth() || point.state[5] <= 0) {
      continue;
    }
    const Eigen::Index rho = points_[i].at + 5;
    const double depth_sigma_m =
        std::sqrt(std::max(0.0, P_(rho, rho))) / (point.state[5] * point.state[5]);
    const PointOfRay as_point = point_of_ray(point);
    const Vec3 from_first = as_point.p_map - point.state.head<3>();
    const Vec3 from_now = as_point.p_map - T_map_camera_.translation;
    const double cosine = from_first.dot(from_now) / (from_first.norm() * from_now.norm());
    if (4 * depth_sigma_m / from_now.norm() * std::abs(cosine) < options_.linearity) {
      shrink(i, as_point.by_state);
      points_[i].point.state = as_point.p_map;
    }
  }
}

Eigen::Matrix<double, 6, 6> MonoFilter::pose_covariance() const { return P_.topLeftCorner<6, 6>(); }

std::vector<int> MonoFilter::points() const {
  std::vector<int> numbers;
  for (const Held& each : points_) {
    numbers.push_back(each.number);
  }
  return numbers;
}

const MonoFilter::Held* MonoFilter::find(int number) const {
  const auto at = std::lower_bound(points_.begin(), points_.end(), number,
                                   [](const Held& h, int n) { return h.number < n; });
  return at != points_.end() && at->number == number ? &*at : nullptr;
}

const MonoFilter::Held& MonoFilter::held(int number) const {
  const Held* found = find(number);
  PANOPTES_CHECK(found != nullptr, "a point that is asked for is in the map");
  return *found;
}

const FilteredPoint& MonoFilter::point(int number) const { return held(number).point; }

Mat3 MonoFilter::point_covariance(int number) const {
  const Held& of = held(number);
  if (!of.point.is_inverse_depth()) {
    return P_.block<3, 3>(of.at, of.at);
  }
  const PointOfRay as_point = point_of_ray(of.point);
  return as_point.by_state * P_.block<6, 6>(of.at, of.at) * as_point.by_state.transpose();
}

void MonoFilter::place(const Pose3& T_map_camera, const Eigen::Matrix<double, 6, 6>& covariance) {
  T_map_camera_ = T_map_camera;
  velocity_map_.setZero();
  turn_rate_radps_.setZero();
  P_.topRows<kCamera>().setZero();
  P_.leftCols<kCamera>().setZero();
  P_.topLeftCorner<6, 6>() = covariance;
  const double speed = options_.start_speed_mps;
  const double turn = options_.start_turn_radps;
  P_.diagonal().segment<3>(kVelocity).setConstant(speed * speed);
  P_.diagonal().segment<3>(kTurnRate).setConstant(turn * turn);
}

}  // namespace panoptes
