// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/planar_hand_eye.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "core/base/median.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr double kLeastTurn_rad = deg_to_rad(90);
constexpr double kLeastDrive_m = 0.3;
constexpr double kLongestOffset_s = 0.5;  // that is looked for
constexpr double kOffsetStep_s = 0.01;
constexpr double kMostSigmas = 2;  // of what counts fully (Huber)
constexpr int kWeighings = 10;
// Of what wheels say between two pictures: a step of the encoder, and slip over a metre.
constexpr double kStep_m = 0.0005;
constexpr double kSlip_m = 0.01;

/// The axis of all turns, in map, that of the body's turns to the left.
struct Turning {
  Vec3 axis_map = Vec3::UnitZ();
  std::vector<double> angle_rad;  ///< since the first
};

Vec3 axis_of_turns(const std::vector<StampedCamera>& path) {
  Mat3 sum = Mat3::Zero();
  for (const StampedCamera& at : path) {
    const Eigen::Quaterniond q =
        at.T_map_camera.rotation * path.front().T_map_camera.rotation.conjugate();
    const Vec3 sine = 2 * q.w() * q.vec();  // sin(angle) * axis
    sum += sine * sine.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(sum).eigenvectors().col(2);
}

std::vector<double> turns_about(const Vec3& axis, const std::vector<StampedCamera>& path) {
  std::vector<double> angles;
  for (const StampedCamera& at : path) {
    const Eigen::Quaterniond q =
        at.T_map_camera.rotation * path.front().T_map_camera.rotation.conjugate();
    const double angle = 2 * std::atan2(q.vec().dot(axis), q.w());
    const double before = angles.empty() ? 0 : angles.back();
    angles.push_back(before + std::remainder(angle - before, 2 * std::numbers::pi));
  }
  return angles;
}

/// What the wheels say of the instants of a camera whose clock is off by so much; empty where they
/// do not reach.
std::vector<std::optional<Pose2>> wheels_at(const std::vector<StampedCamera>& path,
                                            const WheelReadings& wheels, double offset_s) {
  std::vector<std::optional<Pose2>> poses;
  for (const StampedCamera& at : path) {
    const std::optional<Odometry> odometry = wheels(at.stamp - from_seconds(offset_s));
    poses.push_back(odometry ? std::optional<Pose2>(odometry->T_odom_body) : std::nullopt);
  }
  return poses;
}

struct TurnFit {
  double gain = 0;  ///< the camera's turns by the wheels'
  double rms = std::numeric_limits<double>::infinity();
};

TurnFit fit_turns(const std::vector<double>& angle_rad,
                  const std::vector<std::optional<Pose2>>& wheels) {
  double xx = 0;
  double xy = 0;
  double yy = 0;
  int count = 0;
  for (std::size_t i = 0; i + 1 < angle_rad.size(); ++i) {
    if (wheels[i] && wheels[i + 1]) {
      const double x =
          std::remainder(wheels[i + 1]->theta_rad - wheels[i]->theta_rad, 2 * std::numbers::pi);
      const double y = angle_rad[i + 1] - angle_rad[i];
      xx += x * x;
      xy += x * y;
      yy += y * y;
      ++count;
    }
  }
  if (count == 0 || xx == 0) {
    return {};
  }
  const double gain = xy / xx;
  return {gain, std::sqrt(std::max(0.0, yy - gain * xy) / count)};
}

/// The one that makes the turns agree best, by steps and then by the parabola through the best.
double clock_offset(const std::vector<double>& angle_rad, const std::vector<StampedCamera>& path,
                    const WheelReadings& wheels, double about_s) {
  const auto cost = [&](double offset_s) {
    const double rms = fit_turns(angle_rad, wheels_at(path, wheels, offset_s)).rms;
    return rms * rms;
  };
  const int steps = static_cast<int>(std::lround(kLongestOffset_s / kOffsetStep_s));
  double best_s = about_s;
  double least = cost(about_s);
  for (int i = -steps; i <= steps; ++i) {
    const double offset_s = about_s + i * kOffsetStep_s;
    const double here = cost(offset_s);
    if (here < least) {
      least = here;
      best_s = offset_s;
    }
  }
  const double before = cost(best_s - kOffsetStep_s);
  const double after = cost(best_s + kOffsetStep_s);
  const double bend = before - 2 * least + after;
  return bend > 0 && std::isfinite(bend)
             ? best_s + std::clamp(0.5 * (before - after) / bend, -1.0, 1.0) * kOffsetStep_s
             : best_s;
}

Mat2 turn(double angle_rad) { return Eigen::Rotation2Dd(angle_rad).toRotationMatrix(); }

struct Mounted {
  Vec2 metre_and_heading = Vec2::Zero();  ///< of the levelled map in start: m (cos, sin)
  Vec2 position_body = Vec2::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  double driven_m = 0;
};

/// Between one instant and the next the body moves by R(-a_i) [m R(yaw) (q_j - q_i) -
/// (R(a_j) - R(a_i)) x] in its own frame, q being the camera in the levelled map: linear in
/// m (cos yaw, sin yaw) and in x.
std::optional<Mounted> mounted(const std::vector<Vec2>& q, const std::vector<double>& angle_rad,
                               const std::vector<std::optional<Pose2>>& wheels) {
  struct Row {
    Eigen::Matrix<double, 2, 4> A;
    Vec2 b;
    double sigma_m = 1;  ///< as the wheels' noise grows
  };
  std::vector<Row> rows;
  Mounted out;
  for (std::size_t i = 0; i + 1 < q.size(); ++i) {
    if (!wheels[i] || !wheels[i + 1]) {
      continue;
    }
    const Vec2 d = q[i + 1] - q[i];
    Row row;
    row.A.leftCols<2>() << d.x(), -d.y(), d.y(), d.x();
    row.A.rightCols<2>() = -(turn(angle_rad[i + 1]) - turn(angle_rad[i]));
    row.A = (turn(-angle_rad[i]) * row.A).eval();
    row.b = (wheels[i]->inverse() * *wheels[i + 1]).position();
    row.sigma_m = std::hypot(kStep_m, kSlip_m * std::sqrt(row.b.norm()));
    out.driven_m += row.b.norm();
    rows.push_back(row);
  }
  if (rows.size() < 4) {
    return std::nullopt;
  }
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  std::vector<double> weight(rows.size(), 1);
  double scatter = 1;
  for (int round = 0; round < kWeighings; ++round) {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double w = weight[i] / (rows[i].sigma_m * rows[i].sigma_m);
      H += w * rows[i].A.transpose() * rows[i].A;
      g += w * rows[i].A.transpose() * rows[i].b;
    }
    const Eigen::LDLT<Eigen::Matrix4d> solver(H);
    x = solver.solve(g);
    std::vector<double> off;
    for (const Row& row : rows) {
      off.push_back((row.A * x - row.b).squaredNorm() / (row.sigma_m * row.sigma_m));
    }
    const double median_of_chi2 = 2 * std::log(2);  // of two numbers
    scatter = std::max(1e-12, std::sqrt(median(std::vector<double>(off)) / median_of_chi2));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      weight[i] = std::min(1.0, kMostSigmas * scatter / std::sqrt(std::max(off[i], 1e-24)));
    }
    out.covariance = scatter * scatter * solver.solve(Eigen::Matrix4d::Identity());
  }
  out.metre_and_heading = x.head<2>();
  out.position_body = x.tail<2>();
  return out;
}

}  // namespace

PlanarHandEye planar_hand_eye(const std::vector<StampedCamera>& path, const WheelReadings& wheels,
                              const RigCamera& believed) {
  if (path.size() < 5) {
    throw HandEyeError(
        fmt::format("{} poses of the camera do not tell how it is mounted", path.size()));
  }
  Turning turning;
  turning.axis_map = axis_of_turns(path);
  turning.angle_rad = turns_about(turning.axis_map, path);
  const auto [least, most] =
      std::minmax_element(turning.angle_rad.begin(), turning.angle_rad.end());
  if (*most - *least < kLeastTurn_rad) {
    throw HandEyeError(fmt::format(
        "it turns by {:.0f} degrees in all (at least {:.0f}): roll and pitch, and where "
        "the camera is, are left open; drive a motion that turns",
        rad_to_deg(*most - *least), rad_to_deg(kLeastTurn_rad)));
  }
  PlanarHandEye out;
  out.clock_offset_s = clock_offset(turning.angle_rad, path, wheels, believed.clock_offset_s);
  std::vector<std::optional<Pose2>> at = wheels_at(path, wheels, out.clock_offset_s);
  TurnFit turned = fit_turns(turning.angle_rad, at);
  if (turned.gain < 0) {  // the axis points down; which way it points changes no cost
    turning.axis_map = -turning.axis_map;
    for (double& angle_rad : turning.angle_rad) {
      angle_rad = -angle_rad;
    }
    turned.gain = -turned.gain;
  }
  constexpr double kMostGain = 1.25;
  if (!(turned.gain < kMostGain && turned.gain > 1 / kMostGain)) {
    throw HandEyeError(fmt::format(
        "the camera turns {:.2f} times as far as the wheels say: they are not of one drive, or by "
        "clocks more than {:g} s apart",
        turned.gain, kLongestOffset_s));
  }
  const Eigen::Quaterniond R_level_map =
      Eigen::Quaterniond::FromTwoVectors(turning.axis_map, Vec3::UnitZ());
  std::vector<Vec2> q;
  for (const StampedCamera& each : path) {
    q.push_back((R_level_map * each.T_map_camera.translation).head<2>());
  }
  const std::optional<Mounted> fit = mounted(q, turning.angle_rad, at);
  if (!fit || fit->driven_m < kLeastDrive_m) {
    throw HandEyeError(
        fmt::format("it drives {:.2f} m in all (at least {:g}): a turn on the spot "
                    "tells no metre; drive a motion with legs, or a rose",
                    fit ? fit->driven_m : 0, kLeastDrive_m));
  }
  out.map_metre_m = fit->metre_and_heading.norm();
  const double heading_rad = std::atan2(fit->metre_and_heading.y(), fit->metre_and_heading.x());
  const double metre_sigma = std::sqrt(fit->covariance.topLeftCorner<2, 2>().trace() / 2);
  constexpr double kLeastSure = 5;
  if (!(out.map_metre_m > kLeastSure * metre_sigma)) {
    throw HandEyeError(
        "the camera's path and the wheels' do not fit one another: no metre comes of them");
  }
  const Eigen::Quaterniond R_start_map = turned_by({0, 0, heading_rad}) * R_level_map;
  const Pose3& first = path.front().T_map_camera;
  out.T_body_camera.rotation = (R_start_map * first.rotation).normalized();
  out.T_body_camera.translation << fit->position_body, believed.T_body_camera.translation.z();
  out.T_start_map.rotation = R_start_map;
  out.T_start_map.translation =
      out.T_body_camera.translation - out.map_metre_m * (R_start_map * first.translation);
  out.yaw_sigma_rad = metre_sigma / out.map_metre_m;
  out.position_sigma_m = std::sqrt(fit->covariance.bottomRightCorner<2, 2>().diagonal().maxCoeff());
  return out;
}

}  // namespace panoptes
