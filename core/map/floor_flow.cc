// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/floor_flow.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Dense>
#include <opencv2/imgproc.hpp>

namespace panoptes {
namespace {

constexpr double kStep_m = 0.15;  // pictures so far apart, or turned by so much, are compared,
constexpr double kStep_rad = deg_to_rad(10);
constexpr double kFar_m = 0.4;  // and none farther
constexpr double kFar_rad = deg_to_rad(35);

constexpr double kSample_m = 0.01;  // a pixel covers about as much 0.7 m before a camera 0.6 m high
constexpr double kApart_m = 0.08;   // of patches' middles
constexpr double kRange_m = 1.2;    // from the nearest mapped floor
constexpr std::size_t kMostPatches = 60;
constexpr std::size_t kFewestPatches = 10;

constexpr float kLeastContrast = 1;  // grey: what is less is rounding
constexpr int kIterations = 6;
constexpr double kConverged_m = 1e-4;
constexpr double kFarthest_m = 0.05;  // from where it was expected
constexpr double kCorrelation = 0.7;  // noise alone does not reach half of it
constexpr double kSingular = 0.01;    // of a gradient matrix's trace: along an edge nothing is seen
constexpr double kInterpolation_m = 5e-4;  // a twentieth of a pixel

constexpr double kForward_m = 0.0015;
constexpr double kForwardShare = 0.015;
constexpr double kSideways_m = 0.0005;
constexpr double kSidewaysShare = 0.003;
constexpr double kTurn_rad = deg_to_rad(0.3);
constexpr double kTurnShare = 0.03;

constexpr int kMotion = 3;
constexpr int kUnknowns = kMotion + kFloorStates;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Rows = Eigen::Matrix<double, 2, kUnknowns>;

// Bilinear; negative outside.
float grey_at(const cv::Mat& grey, float u, float v) {
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(grey.cols - 1) &&
        v < static_cast<float>(grey.rows - 1))) {
    return -1;
  }
  const int column = static_cast<int>(u);
  const int row = static_cast<int>(v);
  const float fu = u - static_cast<float>(column);
  const float fv = v - static_cast<float>(row);
  const std::uint8_t* a = grey.ptr<std::uint8_t>(row) + column;
  const std::uint8_t* b = a + grey.step;
  return (1 - fv) * ((1 - fu) * static_cast<float>(a[0]) + fu * static_cast<float>(a[1])) +
         fv * ((1 - fu) * static_cast<float>(b[0]) + fu * static_cast<float>(b[1]));
}

double square(double x) { return x * x; }

// Takes out the mean and what rises evenly, which vignetting and lamps make of any floor. Returns
// the rise for each sample, along x and y.
template <std::size_t kSide>
Eigen::Vector2f level(std::array<float, kSide * kSide>& grey) {
  constexpr int kHalf = static_cast<int>(kSide) / 2;
  constexpr float kMoment = kSide * kHalf * (kHalf + 1) * kSide / 3.0F;  // sum of x^2
  float sum = 0;
  Eigen::Vector2f rise = Eigen::Vector2f::Zero();
  std::size_t k = 0;
  for (int y = -kHalf; y <= kHalf; ++y) {
    for (int x = -kHalf; x <= kHalf; ++x, ++k) {
      sum += grey[k];
      rise += grey[k] * Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y));
    }
  }
  rise /= kMoment;
  const float mean = sum / (kSide * kSide);
  k = 0;
  for (int y = -kHalf; y <= kHalf; ++y) {
    for (int x = -kHalf; x <= kHalf; ++x, ++k) {
      grey[k] -= mean + rise.x() * static_cast<float>(x) + rise.y() * static_cast<float>(y);
    }
  }
  return rise;
}

// The twist of a frame that is rigidly joined to another one: Ad(T) xi.
Vec3 carried(const Pose2& T, const Vec3& twist) {
  Vec3 out;
  out.head<2>() = T.rotation() * twist.head<2>() + twist.z() * Vec2(T.y_m, -T.x_m);
  out.z() = twist.z();
  return out;
}

}  // namespace

struct FloorFlow::Look {
  const Patch* patch;
  std::array<float, kSide * kSide> grey;                // levelled
  std::array<Eigen::Vector2f, kSide * kSide> gradient;  // along x and y of view, per metre
  Mat2 gradients;                                       // summed squares
  double square;                                        // of the grey, summed
};

struct FloorFlow::Track {
  Vec2 off_view;           // where it was less where it was expected, in view now
  Mat2 information;        // of it
  Rows by = Rows::Zero();  // how the unknowns move it
};

Vec3 step_sigma(const Pose2& T_before_now) {
  const double moved_m = T_before_now.position().norm();
  return {kForward_m + kForwardShare * moved_m, kSideways_m + kSidewaysShare * moved_m,
          kTurn_rad + kTurnShare * std::abs(T_before_now.theta_rad)};
}

FloorFlow::FloorFlow(std::shared_ptr<const FloorProjection> projection, const Intrinsics& lens)
    : projection_(std::move(projection)) {
  const FloorProjection& p = *projection_;
  H_px_view_ = p.H_view_px.inverse();
  const Vec2 middle(p.front_m + 0.1, p.foot_view.y());
  if ((H_px_view_ * middle.homogeneous()).z() < 0) {
    H_px_view_ = -H_px_view_;
  }
  const double half_m = kSample_m * (kRim / 2);
  const auto cell_at = [&](const Vec2& at) -> std::optional<std::size_t> {
    const Vec2 cell = (at - p.origin_view) / p.cell_m;
    const auto column = static_cast<int>(std::floor(cell.x()));
    const auto row = static_cast<int>(std::floor(cell.y()));
    if (column < 0 || row < 0 || column >= p.cell_columns || row >= p.cell_rows) {
      return std::nullopt;
    }
    const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(p.cell_columns) +
                          static_cast<std::size_t>(column);
    return p.sample[i] < 0 ? std::nullopt : std::optional(i);
  };
  const double end_x =
      std::min(p.front_m + kRange_m, p.origin_view.x() + p.cell_columns * p.cell_m);
  const double end_y = p.origin_view.y() + p.cell_rows * p.cell_m;
  for (double x = p.front_m + half_m; x + half_m < end_x; x += kApart_m) {
    for (double y = p.origin_view.y() + half_m; y + half_m < end_y; y += kApart_m) {
      Patch patch;
      patch.p_view = {x, y};
      bool whole = true;
      for (std::size_t k = 0; k < patch.cells.size(); ++k) {
        const Vec2 corner = k == 0 ? Vec2(0, 0) : Vec2(k % 2 == 0 ? 1 : -1, k < 3 ? 1 : -1);
        const std::optional<std::size_t> cell = cell_at(patch.p_view + half_m * corner);
        whole = whole && cell;
        patch.cells[k] = cell.value_or(0);
      }
      for (int k = 0; whole && k < kRim * kRim; ++k) {
        const Vec2 at = patch.p_view + kSample_m * Vec2(k % kRim - kRim / 2, k / kRim - kRim / 2);
        const Vec2 px = (H_px_view_ * at.homogeneous()).hnormalized();
        patch.px[static_cast<std::size_t>(k)] = px.cast<float>();
        whole =
            px.x() >= 0 && px.y() >= 0 && px.x() < lens.width_px - 1 && px.y() < lens.height_px - 1;
      }
      if (whole) {
        patches_.push_back(patch);
      }
    }
  }
}

// How a point that the picture shows on the floor is displaced by the camera's states but for its
// clock: its ray turns and its centre moves.
Eigen::Matrix<double, 2, 6> FloorFlow::moved_by(const Vec2& p_view) const {
  const Vec2 d = p_view - projection_->foot_view;
  const double h = projection_->height_m;
  Eigen::Matrix<double, 2, 6> by;
  by.col(kFloorRoll) = Vec2(d.x() * d.y() / h, h + d.y() * d.y() / h);
  by.col(kFloorPitch) = Vec2(-h - d.x() * d.x() / h, -d.x() * d.y() / h);
  by.col(kFloorYaw) = Vec2(-d.y(), d.x());
  by.col(kFloorShift) = Vec2(1, 0);
  by.col(kFloorShift + 1) = Vec2(0, 1);
  by.col(kFloorShift + 2) = d / h;
  return by;
}

// The patches of floor that have the most texture.
std::vector<FloorFlow::Look> FloorFlow::looks(const cv::Mat& grey,
                                              const std::vector<std::int8_t>& evidence) const {
  std::vector<Look> looks;
  for (const Patch& patch : patches_) {
    if (!std::all_of(patch.cells.begin(), patch.cells.end(),
                     [&](std::size_t cell) { return evidence[cell] > 0; })) {
      continue;
    }
    std::array<float, kRim * kRim> rim;
    for (std::size_t k = 0; k < rim.size(); ++k) {
      rim[k] = grey_at(grey, patch.px[k].x(), patch.px[k].y());
    }
    Look look{&patch, {}, {}, Mat2::Zero(), 0};
    for (std::size_t row = 0; row < kSide; ++row) {
      for (std::size_t column = 0; column < kSide; ++column) {
        const std::size_t at = (row + 1) * kRim + column + 1;
        const std::size_t k = row * kSide + column;
        look.grey[k] = rim[at];
        look.gradient[k] =
            Eigen::Vector2f(rim[at + 1] - rim[at - 1], rim[at + kRim] - rim[at - kRim]) /
            static_cast<float>(2 * kSample_m);
      }
    }
    const Eigen::Vector2f rise = level<kSide>(look.grey) / static_cast<float>(kSample_m);
    Eigen::Matrix2f gradients = Eigen::Matrix2f::Zero();
    for (std::size_t k = 0; k < look.grey.size(); ++k) {
      look.square += square(look.grey[k]);
      look.gradient[k] -= rise;
      gradients += look.gradient[k] * look.gradient[k].transpose();
    }
    if (look.square < kSide * kSide * square(kLeastContrast)) {
      continue;
    }
    look.gradients = gradients.cast<double>();
    looks.push_back(look);
  }
  if (looks.size() > kMostPatches) {
    std::nth_element(
        looks.begin(), looks.begin() + kMostPatches, looks.end(),
        [](const Look& a, const Look& b) { return a.gradients.trace() > b.gradients.trace(); });
    looks.resize(kMostPatches);
  }
  return looks;
}

std::optional<FloorFlow::Track> FloorFlow::track(const Look& look, const Seen& before,
                                                 const Pose2& T_before_now) const {
  // pixels of the picture before, from floor now
  Mat3 T;
  T.setIdentity();
  T.topLeftCorner<2, 2>() = T_before_now.rotation();
  T.topRightCorner<2, 1>() = T_before_now.position();
  const Eigen::Matrix3f H = (H_px_view_ * T).cast<float>();
  const Mat2 inverse =
      (look.gradients + kSingular * look.gradients.trace() * Mat2::Identity()).inverse();
  Vec2 off = Vec2::Zero();
  double mean_square = 0;
  double correlation = 0;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    std::array<float, kSide * kSide> was;
    const Vec2 corner = look.patch->p_view + off - Vec2::Constant(kSample_m * (kSide / 2));
    const Eigen::Vector3f along_x = H.col(0) * static_cast<float>(kSample_m);
    for (int row = 0; row < kSide; ++row) {
      Eigen::Vector3f at = H * Eigen::Vector3f(static_cast<float>(corner.x()),
                                               static_cast<float>(corner.y() + row * kSample_m), 1);
      for (int column = 0; column < kSide; ++column, at += along_x) {
        const float one = at.z() > 0 ? grey_at(before.grey, at.x() / at.z(), at.y() / at.z()) : -1;
        if (one < 0) {
          return std::nullopt;
        }
        was[static_cast<std::size_t>(row * kSide + column)] = one;
      }
    }
    level<kSide>(was);
    double was_square = 0;
    double product = 0;
    for (std::size_t k = 0; k < was.size(); ++k) {
      was_square += square(was[k]);
      product += was[k] * look.grey[k];
    }
    correlation = product / std::sqrt(std::max(was_square * look.square, 1e-9));
    // exposures differ
    const auto gain = static_cast<float>(
        std::clamp(std::sqrt(look.square / std::max(was_square, 1e-9)), 0.7, 1.4));
    Eigen::Vector2f pull = Eigen::Vector2f::Zero();
    double error = 0;
    for (std::size_t k = 0; k < was.size(); ++k) {
      const float e = gain * was[k] - look.grey[k];
      pull += look.gradient[k] * e;
      error += square(e);
    }
    mean_square = error / (kSide * kSide);
    const Vec2 step = -(inverse * pull.cast<double>());
    off += step;
    if (off.norm() > kFarthest_m) {
      return std::nullopt;
    }
    if (step.norm() < kConverged_m) {
      break;
    }
  }
  if (correlation < kCorrelation) {
    return std::nullopt;
  }
  const Mat2 shown = look.gradients / std::max(mean_square, square(kLeastContrast) / 12);
  return Track{off, (Mat2::Identity() + square(kInterpolation_m) * shown).inverse() * shown};
}

std::optional<FloorEvidence> FloorFlow::add(const cv::Mat& bgr,
                                            const std::vector<std::int8_t>& evidence,
                                            const Pose2& T_odom_body, const Twist2& twist_body) {
  const double heading_rad = projection_->T_body_view.theta_rad;
  const Pose2 T_odom_view = T_odom_body * projection_->T_body_view;
  Pose2 T_before_now;
  if (last_) {
    T_before_now = last_->T_odom_view.inverse() * T_odom_view;
    if (T_before_now.position().norm() < kStep_m && std::abs(T_before_now.theta_rad) < kStep_rad) {
      return std::nullopt;
    }
  }
  Seen now{T_odom_view,
           Vec3(twist_body.v_mps * std::cos(heading_rad), -twist_body.v_mps * std::sin(heading_rad),
                twist_body.w_radps),
           {}};
  cv::cvtColor(bgr, now.grey, cv::COLOR_BGR2GRAY);
  const std::optional<Seen> before = std::exchange(last_, now);
  const double moved_m = T_before_now.position().norm();
  const double turned_rad = std::abs(T_before_now.theta_rad);
  if (!before || moved_m > kFar_m || turned_rad > kFar_rad) {
    return std::nullopt;
  }

  const Mat2 R_now_before = T_before_now.rotation().transpose();
  const Vec3 by_clock = now.twist_view - carried(T_before_now.inverse(), before->twist_view);
  std::vector<Track> tracks;
  for (const Look& look : looks(now.grey, evidence)) {
    std::optional<Track> track = this->track(look, *before, T_before_now);
    if (!track) {
      continue;
    }
    const Vec2 p = look.patch->p_view;
    Rows& by = track->by;
    by.leftCols<kMotion>() << 1, 0, -p.y(), 0, 1, p.x();
    by.middleCols<6>(kMotion) = moved_by(p) - R_now_before * moved_by(T_before_now * p);
    by.col(kMotion + kFloorClock) = by.leftCols<kMotion>() * by_clock;
    tracks.push_back(*track);
  }
  if (tracks.size() < kFewestPatches) {
    return std::nullopt;
  }

  const Vec3 sigma = step_sigma(T_before_now);
  Mat3 to_view = Mat3::Identity();
  to_view.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-heading_rad).toRotationMatrix();
  const Mat3 motion_information =
      to_view * sigma.cwiseAbs2().cwiseInverse().asDiagonal() * to_view.transpose();
  FloorState state_sigma;
  state_sigma << Vec3::Constant(deg_to_rad(2)), Vec3::Constant(0.02), 0.01;

  // Cauchy's weights, scaled by the median
  constexpr double kMedianOfTwo = 1.386;  // of a chi-square of two degrees
  constexpr double kCauchy = 5.7;
  constexpr int kReweighted = 6;
  std::vector<double> weights(tracks.size(), 1);
  std::vector<double> squares(tracks.size());
  Square information;
  Unknowns vector;
  for (int round = 0; round <= kReweighted; ++round) {
    information.setZero();
    vector.setZero();
    for (std::size_t k = 0; k < tracks.size(); ++k) {
      const Track& track = tracks[k];
      const Eigen::Matrix<double, kUnknowns, 2> weighted =
          weights[k] * track.by.transpose() * track.information;
      information += weighted * track.by;
      vector += weighted * track.off_view;
    }
    information.topLeftCorner<kMotion, kMotion>() += motion_information;
    if (round == kReweighted) {
      break;
    }
    Square with_prior = information;
    with_prior.diagonal().tail<kFloorStates>() += state_sigma.cwiseAbs2().cwiseInverse();
    const Unknowns fit = with_prior.ldlt().solve(vector);
    for (std::size_t k = 0; k < tracks.size(); ++k) {
      const Vec2 rest = tracks[k].off_view - tracks[k].by * fit;
      squares[k] = rest.dot(tracks[k].information * rest);
    }
    std::vector<double> sorted = squares;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double scale = std::max(*middle / kMedianOfTwo, 1.0);
    for (std::size_t k = 0; k < tracks.size(); ++k) {
      weights[k] = 1 / (scale + squares[k] / kCauchy);
    }
  }
  const Eigen::Matrix<double, kFloorStates, kMotion> mixed =
      information.bottomLeftCorner<kFloorStates, kMotion>() *
      information.topLeftCorner<kMotion, kMotion>().inverse();
  FloorEvidence out;
  out.information = information.bottomRightCorner<kFloorStates, kFloorStates>() -
                    mixed * information.topRightCorner<kMotion, kFloorStates>();
  out.vector = vector.tail<kFloorStates>() - mixed * vector.head<kMotion>();
  return out;
}

}  // namespace panoptes
