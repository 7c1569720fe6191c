// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/planar_hand_eye.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "core/base/median.h"
#include "core/calib/turning.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr double kLeastTurn_rad = deg_to_rad(90);
constexpr double kLongestOffset_s = 0.5;  // that is looked for
constexpr double kOffsetStep_s = 0.01;
constexpr double kMostSigmas = 2;  // of what counts fully (Huber)
constexpr int kWeighings = 10;
// What is believed of a mounting counts for nothing beside a metre of drive. A turn on the spot, or
// a circle, leaves yaw, place and metre open together: then they are those that are nearest to it.
constexpr double kBelieved_m = 0.1;
constexpr double kBelieved_rad = 0.2;
// Of what wheels say between two pictures: a step of the encoder, and slip over a metre.
constexpr double kStep_m = 0.0005;
constexpr double kSlip_m = 0.01;

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

using Complex = std::complex<double>;  // of a plane: a turn and a scale are one number

struct Mounted {
  Complex
      map_by_body;  ///< of the levelled map's metres, turned into its axes, by the body's metres
  Complex position_map;  ///< the camera from the body, in the levelled map
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  double unexplained = 1;  ///< share of all that moves (squared) that is left between both paths
};

Complex complex(const Vec2& v) { return {v.x(), v.y()}; }

/// Between one instant and the next the camera moves in the levelled map by
/// e^(i a_i) k b + (e^(i a_j) - e^(i a_i)) y, where b is what the body moves in its own frame, a
/// its turn, k takes the body's metres to the map's and y is where the camera is: linear in both.
/// What is measured is the camera's way, so that y is known where the body only turns, and noise
/// does not make it less.
struct MovedRow {
  Complex moved_map;
  Complex by_body;      ///< e^(i a_i) b
  Complex by_position;  ///< e^(i a_j) - e^(i a_i)
  double sigma_m = 1;   ///< of b, as the wheels' noise grows
};

std::vector<MovedRow> moved_rows(const std::vector<Vec2>& q, const std::vector<double>& angle_rad,
                                 const std::vector<std::optional<Pose2>>& wheels) {
  const double driven = tells_metre(wheels) ? 1 : 0;  // what they wander tells none
  std::vector<MovedRow> rows;
  for (std::size_t i = 0; i + 1 < q.size(); ++i) {
    if (wheels[i] && wheels[i + 1]) {
      const Vec2 b = (wheels[i]->inverse() * *wheels[i + 1]).position();
      const Complex before = std::polar(1.0, angle_rad[i]);
      rows.push_back({complex(q[i + 1] - q[i]), driven * before * complex(b),
                      std::polar(1.0, angle_rad[i + 1]) - before,
                      std::hypot(kStep_m, kSlip_m * std::sqrt(b.norm()))});
    }
  }
  return rows;
}

std::optional<Mounted> mounted(const std::vector<MovedRow>& rows, const Vec2& believed_body,
                               double heading_rad) {
  using Coefficients = Eigen::Matrix<double, 2, 4>;
  const auto coefficients = [](Complex of_k, Complex of_y) {
    Coefficients A;
    A << of_k.real(), -of_k.imag(), of_y.real(), -of_y.imag(), of_k.imag(), of_k.real(),
        of_y.imag(), of_y.real();
    return A;
  };
  if (rows.size() < 4) {
    return std::nullopt;
  }
  Mounted out;
  std::vector<double> weight(rows.size(), 1);
  double scatter = 1;
  double k_size = 1;
  for (int round = 0; round < kWeighings; ++round) {
    Eigen::Matrix4d H = Eigen::Matrix4d::Zero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    const auto add = [&](const Coefficients& A, Complex b, double w) {
      H += w * A.transpose() * A;
      g += w * A.transpose() * Vec2(b.real(), b.imag());
    };
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double sigma = scatter * k_size * rows[i].sigma_m;
      add(coefficients(rows[i].by_body, rows[i].by_position), rows[i].moved_map,
          weight[i] / (sigma * sigma));
    }
    add(coefficients(complex(believed_body), -1), 0, std::pow(kBelieved_m * k_size, -2));
    // The body's axis x in the map is k; across the believed heading it is nothing.
    Coefficients across = coefficients(std::polar(1.0, -heading_rad), 0);
    across.row(0).setZero();
    add(across, 0, std::pow(kBelieved_rad * k_size, -2));
    const Eigen::LDLT<Eigen::Matrix4d> solver(H);
    const Eigen::Vector4d x = solver.solve(g);
    out.map_by_body = {x[0], x[1]};
    out.position_map = {x[2], x[3]};
    out.covariance = solver.solve(Eigen::Matrix4d::Identity());
    k_size = std::abs(out.map_by_body);
    if (!(k_size > 0)) {
      return std::nullopt;
    }
    std::vector<double> off;
    double left = 0;
    double all = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const MovedRow& row = rows[i];
      const Complex by_body = row.by_body * out.map_by_body;
      const Complex by_position = row.by_position * out.position_map;
      const double r2 = std::norm(by_body + by_position - row.moved_map);
      off.push_back(r2 / std::pow(k_size * row.sigma_m, 2));
      left += weight[i] * r2;
      all += weight[i] * (std::norm(row.moved_map) + std::norm(by_body) + std::norm(by_position));
    }
    out.unexplained = all > 0 ? left / all : 1;
    const double median_of_chi2 = 2 * std::log(2);  // of two numbers
    scatter = std::max(1e-12, std::sqrt(median(std::vector<double>(off)) / median_of_chi2));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      weight[i] = std::min(1.0, kMostSigmas * scatter / std::sqrt(std::max(off[i], 1e-24)));
    }
  }
  return out;
}

/// A map bends and its metre wanders, by more than what is left from one picture to the next tells.
/// So the fit is made again without each eighth of the drive (Tukey's jackknife, of blocks because
/// of how slowly such errors change, Kuensch 1989): that is how well it is known, beside what its
/// residuals tell.
void widen_by_parts(const std::vector<MovedRow>& rows, const Vec2& believed_body,
                    double heading_rad, Mounted& fit) {
  constexpr std::size_t kParts = 8;
  std::vector<Eigen::Vector4d> without;
  for (std::size_t part = 0; part < kParts; ++part) {
    std::vector<MovedRow> others = rows;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(part * rows.size() / kParts),
                 others.begin() + static_cast<std::ptrdiff_t>((part + 1) * rows.size() / kParts));
    if (const std::optional<Mounted> again = mounted(others, believed_body, heading_rad)) {
      without.emplace_back(again->map_by_body.real(), again->map_by_body.imag(),
                           again->position_map.real(), again->position_map.imag());
    }
  }
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  for (const Eigen::Vector4d& each : without) {
    mean += each / static_cast<double>(without.size());
  }
  for (const Eigen::Vector4d& each : without) {
    fit.covariance += (each - mean) * (each - mean).transpose() *
                      static_cast<double>(without.size() - 1) / static_cast<double>(without.size());
  }
}

}  // namespace

PlanarHandEye planar_hand_eye(const std::vector<StampedCamera>& path, const WheelReadings& wheels,
                              const RigCamera& believed) {
  if (path.size() < 5) {
    throw HandEyeError(
        fmt::format("{} poses of the camera do not tell how it is mounted", path.size()));
  }
  Turning turning = turning_of(path);
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
    turning = turning.reversed();
    turned.gain = -turned.gain;
  }
  if (!std::isfinite(turned.rms)) {
    throw HandEyeError(
        "the camera turns and the wheels never do: is the odometry of this drive, and not of "
        "zeros?");
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
  const Pose3& first = path.front().T_map_camera;
  const Vec3 ahead_level =
      R_level_map *
      (first.rotation * (believed.T_body_camera.rotation.conjugate() * Vec3::UnitX()));
  const std::vector<MovedRow> rows = moved_rows(q, turning.angle_rad, at);
  const Vec2 believed_body = believed.T_body_camera.translation.head<2>();
  const double heading_rad = std::atan2(ahead_level.y(), ahead_level.x());
  std::optional<Mounted> fit = mounted(rows, believed_body, heading_rad);
  if (!fit) {
    throw HandEyeError("the wheels tell of fewer than 4 of the ways between its pictures");
  }
  constexpr double kMostUnexplained = 0.1;
  if (!(fit->unexplained < kMostUnexplained)) {
    throw PathsDisagree(fmt::format(
        "the camera's path and the wheels' do not fit one another: {:.0f} % of what moves is left "
        "between them (at most {:.0f}, squared)",
        100 * fit->unexplained, 100 * kMostUnexplained));
  }
  widen_by_parts(rows, believed_body, heading_rad, *fit);
  out.map_metre_m = 1 / std::abs(fit->map_by_body);
  const Complex position = fit->position_map / fit->map_by_body;
  const Eigen::Quaterniond R_start_map =
      turned_by({0, 0, -std::arg(fit->map_by_body)}) * R_level_map;
  out.T_body_camera.rotation = (R_start_map * first.rotation).normalized();
  out.T_body_camera.translation << position.real(), position.imag(),
      believed.T_body_camera.translation.z();
  out.T_start_map.rotation = R_start_map;
  out.T_start_map.translation =
      out.T_body_camera.translation - out.map_metre_m * (R_start_map * first.translation);
  const Eigen::Matrix4d& known = fit->covariance;
  out.yaw_sigma_rad = out.map_metre_m * std::sqrt(known.topLeftCorner<2, 2>().trace() / 2);
  // A shift of y / k is that of y less that of k times where the camera is, by k.
  Eigen::Matrix<double, 2, 4> J;
  J << -position.real(), position.imag(), 1, 0, -position.imag(), -position.real(), 0, 1;
  out.position_sigma_m =
      out.map_metre_m * std::sqrt((J * known * J.transpose()).diagonal().maxCoeff());
  return out;
}

}  // namespace panoptes
