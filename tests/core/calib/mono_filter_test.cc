// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/mono_filter.h"

#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

Intrinsics bending_lens() {
  return lens_of_view(640, 480, deg_to_rad(80), BrownConrady{-0.2, 0.05, 0.001, -0.001, 0});
}

/// Points on the walls of a room of 6 x 6 x 2.6 m around the origin, x right, y down, z ahead.
std::vector<Vec3> wall_points(int count, Rng rng) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double along = rng.uniform(-3, 3);
    const double y = rng.uniform(-1.6, 1);
    const double off = rng.uniform(1.5, 3);  // furniture stands before walls
    switch (i % 4) {
      case 0:
        points.emplace_back(along, y, off);
        break;
      case 1:
        points.emplace_back(along, y, -off);
        break;
      case 2:
        points.emplace_back(off, y, along);
        break;
      default:
        points.emplace_back(-off, y, along);
    }
  }
  return points;
}

/// What a point tracker would tell of a drive, and what the filter makes of it.
struct Drive {
  double noise_px = 0.5;
  double false_share = 0;  ///< of the matches
  int most_in_view = 20;
  std::uint64_t seed = 1;
  MonoFilterOptions options = {};
  double believed_focal = 1;  ///< by the true one
};

struct Driven {
  std::vector<double> heading_error_rad;  ///< at each picture
  std::vector<Vec3> T_map, true_map;
  double squared_sigmas = 0;
  int dof = 0;
  int false_taken = 0;
  int false_made = 0;
  int points = 0;
  bool covariance_holds = true;
  double focal = 0;  ///< in the end, by the true one
};

Driven drive(const Drive& d, const std::vector<Pose3>& T_world_camera, double dt_s) {
  Rng rng(d.seed);
  const Intrinsics lens = bending_lens();
  const std::vector<Vec3> world = wall_points(600, rng.fork("world"));
  Intrinsics believed = lens;
  believed.fx_px *= d.believed_focal;
  believed.fy_px *= d.believed_focal;
  MonoFilter filter(d.options, believed);
  std::map<int, std::size_t> world_of;  // of the map's points
  std::vector<bool> is_held(world.size(), false);
  Driven out;
  for (std::size_t k = 0; k < T_world_camera.size(); ++k) {
    if (k > 0) {
      filter.predict(dt_s);
    }
    const Pose3 T_camera_world = T_world_camera[k].inverse();
    std::vector<PointMatch> matches;
    std::vector<bool> is_false;
    for (const int number : filter.points()) {
      const Vec3 p = T_camera_world * world[world_of.at(number)];
      if (!lens.sees(p) || !filter.expected(number)) {
        continue;
      }
      Vec2 px = lens.project(p) + d.noise_px * Vec2(rng.normal(), rng.normal());
      is_false.push_back(rng.uniform() < d.false_share);
      if (is_false.back()) {
        px += Vec2(rng.uniform(-30, 30), rng.uniform(-30, 30));
      }
      matches.push_back({number, px, d.noise_px});
    }
    const FilterUpdate update = filter.update(matches);
    out.squared_sigmas += update.squared_sigmas;
    out.dof += update.dof;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      out.false_made += is_false[i] ? 1 : 0;
      out.false_taken += is_false[i] && update.inlier[i] ? 1 : 0;
    }
    filter.convert();
    // New points where there are few.
    int in_view = static_cast<int>(matches.size());
    for (std::size_t i = 0; i < world.size() && in_view < d.most_in_view; ++i) {
      const Vec3 p = T_camera_world * world[i];
      if (is_held[i] || !lens.sees(p)) {
        continue;
      }
      const Vec2 px = lens.project(p) + d.noise_px * Vec2(rng.normal(), rng.normal());
      if (px.x() < 0 || px.y() < 0 || px.x() > 639 || px.y() > 479) {
        continue;
      }
      world_of[filter.add(px, d.noise_px)] = i;
      is_held[i] = true;
      ++in_view;
    }
    const Pose3 T_start_now = T_world_camera.front().inverse() * T_world_camera[k];
    const Eigen::Quaterniond off =
        T_start_now.rotation.conjugate() * filter.T_map_camera().rotation;
    out.heading_error_rad.push_back(2 * std::asin(std::min(1.0, off.vec().norm())));
    out.T_map.push_back(filter.T_map_camera().translation);
    out.true_map.push_back(T_start_now.translation);
  }
  const Eigen::MatrixXd& P = filter.covariance();
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(P).eigenvalues();
  out.covariance_holds = (P - P.transpose()).norm() == 0 && values.minCoeff() > -1e-9;
  out.points = static_cast<int>(filter.points().size());
  out.focal = filter.lens().fx_px / lens.fx_px;
  return out;
}

/// A camera 15 cm beside the axis that its robot turns about; headings and places of the body.
std::vector<Pose3> driven_by(const std::function<Pose2(double)>& body_at, double duration_s) {
  std::vector<Pose3> poses;
  const Vec3 mounted(0.05, 0, 0.15);
  for (int k = 0; k / 15.0 < duration_s; ++k) {
    const Pose2 at = body_at(k / 15.0);
    const Eigen::Quaterniond turn = turned_by(Vec3(0, -at.theta_rad, 0));
    poses.push_back({turn, turn * mounted + Vec3(-at.y_m, 0, at.x_m)});
  }
  return poses;
}

/// Half a metre ahead and back, then on by 40 degrees, until more than a whole turn is done.
Pose2 rose(double t_s) {
  constexpr double kPetal_s = 6;
  const int petal = static_cast<int>(t_s / kPetal_s);
  const double in_s = t_s - petal * kPetal_s;
  const double eased_turn =
      in_s < 4 ? 0 : deg_to_rad(40) * (1 - std::cos((in_s - 4) / 2 * M_PI)) / 2;
  const double heading = petal * deg_to_rad(40) + eased_turn;
  const double out_m = in_s < 4 ? 0.25 * (1 - std::cos(in_s / 2 * M_PI)) : 0;
  return {out_m * std::cos(heading), out_m * std::sin(heading), heading};
}

double mean_squared_sigmas(const Driven& d) { return d.squared_sigmas / d.dof; }

/// Root mean square distance of positions, the estimate scaled to fit.
double scaled_rms_m(const Driven& d) {
  double both = 0;
  double own = 0;
  for (std::size_t i = 0; i < d.T_map.size(); ++i) {
    both += d.T_map[i].dot(d.true_map[i]);
    own += d.T_map[i].squaredNorm();
  }
  double sum = 0;
  for (std::size_t i = 0; i < d.T_map.size(); ++i) {
    sum += (both / own * d.T_map[i] - d.true_map[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(d.T_map.size()));
}

TEST(MonoFilter, MapsARoomByVisionAlone) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Driven d = drive({.seed = seed}, driven_by(rose, 65), 1 / 15.0);
    const auto at = [&](double t_s) {
      return rad_to_deg(d.heading_error_rad[static_cast<std::size_t>(t_s * 15)]);
    };
    EXPECT_TRUE(d.covariance_holds);
    EXPECT_LT(at(53), 1.5);
    EXPECT_LT(at(64), 0.3);
    EXPECT_GT(mean_squared_sigmas(d), 0.8);
    EXPECT_LT(mean_squared_sigmas(d), 1.3);
    EXPECT_LT(scaled_rms_m(d), 0.02);
  }
}

// Civera, Bueno, Davison and Montiel 2009.
TEST(MonoFilter, OverAGapItTurnsAsItIsToldAndMovesByItsOwnVelocity) {
  MonoFilter told({}, bending_lens());
  MonoFilter alone = told;
  const Eigen::Quaterniond turn = turned_by(Vec3(0.02, 0.3, -0.01));
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Vec3::Constant(5), Vec3(0.01, 0.02, 0.03);
  told.predict_turned(0.4, {{turn, Vec3(9, 9, 9)}, sigma.cwiseAbs2().asDiagonal()});
  alone.predict(0.4);
  EXPECT_LT(told.T_map_camera().rotation.angularDistance(turn), 1e-12);
  EXPECT_EQ(told.T_map_camera().translation, alone.T_map_camera().translation);
  const Eigen::Matrix<double, 6, 6> known = told.pose_covariance();
  EXPECT_LT((known.topLeftCorner<3, 3>() - alone.pose_covariance().topLeftCorner<3, 3>()).norm(),
            1e-12);
  EXPECT_LT(
      (known.bottomRightCorner<3, 3>() - Mat3(sigma.tail<3>().cwiseAbs2().asDiagonal())).norm(),
      1e-12);
  // It goes on turning as fast.
  told.predict(0.2);
  const Eigen::Quaterniond farther = turn * turned_by(0.5 * Vec3(0.02, 0.3, -0.01));
  EXPECT_LT(told.T_map_camera().rotation.angularDistance(farther), 1e-9);
}

TEST(MonoFilter, FindsItsLens) {
  MonoFilterOptions options;
  options.focal_ratio = 0.05;
  options.centre_px = 3;
  for (const double believed : {0.95, 1.05}) {
    const Driven d =
        drive({.options = options, .believed_focal = believed}, driven_by(rose, 65), 1 / 15.0);
    EXPECT_NEAR(d.focal, 1, 0.005);
    EXPECT_LT(rad_to_deg(d.heading_error_rad.back()), 1);
    EXPECT_TRUE(d.covariance_holds);
  }
}

TEST(MonoFilter, ALensThatIsKnownStays) {
  const Driven d = drive({}, driven_by(rose, 6), 1 / 15.0);
  EXPECT_EQ(d.focal, 1);
}

TEST(MonoFilter, FalseMatchesAreLeftOut) {
  const Driven d = drive({.false_share = 0.2}, driven_by(rose, 65), 1 / 15.0);
  EXPECT_LT(rad_to_deg(d.heading_error_rad.back()), 0.5);
  EXPECT_LT(d.false_taken, 0.05 * d.false_made);
}

}  // namespace
}  // namespace panoptes
