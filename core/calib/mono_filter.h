// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/calib/filtered_point.h"
#include "core/camera/rig.h"
#include "core/geometry/pose3.h"

namespace panoptes {

struct MonoFilterOptions {
  // Between pictures the camera goes on as it did, but for impulses (Davison 2003, thesis 2.17):
  double acceleration_mps2 = 1;         ///< one sigma, each way
  double turn_acceleration_radps2 = 3;  ///< one sigma, about each axis
  double start_speed_mps = 0.3;         ///< one sigma of what it may move at when it starts,
  double start_turn_radps = 0.3;        ///< and turn at
  double inverse_depth_per_m = 0.5;     ///< of a point just seen, where the map tells nothing yet
  double inverse_depth_sigma = 0.25;    ///< reaches from half a metre to the horizon
  double linearity = 0.1;               ///< below it a point is held by x, y, z (Civera 2008, 29)
  double gate_chi2 = 9.21;              ///< of two numbers, 99 %: what a match must meet
  // What is known of the lens, one sigma; where it is exact, nothing of it is estimated:
  double focal_ratio = 0;  ///< of both focal lengths, and of each coefficient of its distortion
  double centre_px = 0;    ///< each way
};

/// What else tells of the camera's motion since the picture before: odometry.
struct MotionTold {
  Pose3 T_before_now;
  /// Of the shift (in the camera's frame before) and the turn (about its axes now).
  Eigen::Matrix<double, 6, 6> covariance;
};

/// A point of the map, found in the picture.
struct PointMatch {
  int point = 0;  ///< its number
  Vec2 px = Vec2::Zero();
  double sigma_px = 0.5;  ///< each way
};

/// Where a point is expected, before it is looked for.
struct PointExpected {
  Vec2 px = Vec2::Zero();
  Mat2 covariance_px2 = Mat2::Zero();  ///< without a measurement's noise
};

struct FilterUpdate {
  std::vector<bool> inlier;   ///< of the matches
  double squared_sigmas = 0;  ///< of the inliers' innovation, by what it was expected to be;
  int dof = 0;                ///< its expectation
};

/// The matches that an update took in.
std::vector<PointMatch> inliers(const std::vector<PointMatch>& matches, const FilterUpdate& update);

/// What a single moving camera knows: where it is, how fast, points it sees, and its lens, in one
/// Gaussian (MonoSLAM: Davison 2003; the lens: Civera, Bueno, Davison and Montiel 2009;
/// thesis 2.2.1 and 4.3.2). `map` is the camera where it starts. Without odometry its metre is what
/// `inverse_depth_per_m` made it.
class MonoFilter {
 public:
  MonoFilter(const MonoFilterOptions& options, const Intrinsics& lens);

  /// So much later: as it is told, or by its own velocity.
  void predict(double dt_s, const std::optional<MotionTold>& told = std::nullopt);
  /// So much later: it has turned as it is told, and moved by its own velocity, whose metre is the
  /// map's.
  void predict_turned(double dt_s, const MotionTold& told);

  /// Empty for one that is not on the picture, or behind it.
  std::optional<PointExpected> expected(int point) const;

  /// Which of the matches agree is found by the hypotheses that each alone makes (1-point RANSAC of
  /// Civera, Grasa, Davison and Montiel 2010, all hypotheses tried), then by what all the others
  /// tell of each; what agrees is taken in, where it is so many and not less than half of them.
  FilterUpdate update(const std::vector<PointMatch>& matches, int fewest = 1);

  /// A new point at a pixel that has a direction. Its depth is as those on the picture have it,
  /// where some are known, or about what is told. Returns its number, never used before.
  int add(const Vec2& px, double sigma_px, std::optional<double> inverse_depth_per_m = {});

  void remove(int point);

  /// The mean inverse depth of the points held by rays is exactly what it is believed to be: that
  /// is what its metre is, where nothing else tells.
  void fix_metre();

  /// Points held by rays whose depth is known well enough are held by x, y, z from now on.
  void convert();

  const Intrinsics& lens() const { return lens_; }  ///< as it is believed by now
  const Pose3& T_map_camera() const { return T_map_camera_; }
  Eigen::Matrix<double, 6, 6> pose_covariance() const;  ///< shift in map, turn about its own axes
  std::vector<int> points() const;                      ///< their numbers, from the oldest on
  const FilteredPoint& point(int number) const;
  Mat3 point_covariance(int number) const;  ///< of x, y, z

  /// The camera is somewhere else: what it knew of where it is says nothing any more.
  void place(const Pose3& T_map_camera, const Eigen::Matrix<double, 6, 6>& covariance);

  /// For tests: symmetric, its eigenvalues not below 0.
  const Eigen::MatrixXd& covariance() const { return P_; }

 private:
  struct Held {
    int number = 0;
    Eigen::Index at = 0;  // in the covariance
    FilteredPoint point;
  };
  struct Observed {
    Vec2 px = Vec2::Zero();
    Eigen::Matrix<double, 2, 6> by_camera;
    Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 9> by_lens;
    Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 6> by_state;
    /// Of a point of inverse depth: by the product of that and a shift.
    std::optional<Eigen::Matrix<double, 2, 3>> by_shift_and_depth;
  };
  void predict_as_told(double dt_s, const MotionTold& told);
  const Held* find(int number) const;
  const Held& held(int number) const;
  std::optional<Observed> observe(const Pose3& T_map_camera, const FilteredPoint& point) const;
  Eigen::Matrix<double, Eigen::Dynamic, 2> covariance_with(const Held& of, const Observed& o) const;
  template <class Rows>
  Eigen::Matrix<double, 2, Rows::ColsAtCompileTime> moved_px(const Held& of, const Observed& o,
                                                             const Rows& all) const;
  Mat2 covariance_of(const Held& of, const Observed& o) const;
  Vec2 mean_of(const Held& of, const Observed& o) const;
  Mat2 second_order(const Held& of, const Observed& o) const;
  void move(const Eigen::VectorXd& by);
  /// What matches tell of all that is held.
  struct Linearised {
    Eigen::VectorXd innovation;
    Eigen::MatrixXd PHt;
    Eigen::MatrixXd S;  // of the innovation
  };
  Linearised linearised(const std::vector<PointMatch>& matches,
                        const std::vector<std::size_t>& which) const;
  std::optional<std::size_t> farthest_off(const Linearised& told) const;
  std::vector<std::size_t> take_in(const std::vector<PointMatch>& matches,
                                   std::vector<std::size_t> which, double& squared_sigmas);
  double expected_inverse_depth(double& sigma) const;
  void shrink(std::size_t which, const Eigen::Matrix<double, Eigen::Dynamic, 6>& by);
  void transform_camera(const Eigen::Matrix<double, 12, 12>& F,
                        const Eigen::Matrix<double, 12, 12>& Q);

  MonoFilterOptions options_;
  Intrinsics lens_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 9, 9> lens_by_held_;  // its parameters
  Pose3 T_map_camera_;
  Vec3 velocity_map_ = Vec3::Zero();
  Vec3 turn_rate_radps_ = Vec3::Zero();
  std::vector<Held> points_;
  int next_number_ = 0;
  Eigen::MatrixXd P_;  // shift, turn, velocity, turn rate, the lens, then the points
};

}  // namespace panoptes
