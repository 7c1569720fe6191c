// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/pose_block.h"

#include <ceres/manifold.h>
#include <ceres/problem.h>

#include "core/camera/mounting.h"

namespace panoptes {
namespace {

constexpr int kNumbers = 7;
constexpr int kMoves = 6;

/// Cost functions give derivatives by the six moves themselves: the six are the block's first
/// numbers as far as the solver's chain rule goes.
class PoseMoves : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kNumbers; }
  int TangentSize() const override { return kMoves; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const PoseBlock block =
        to_block(moved(from_block(x), Eigen::Map<const Eigen::Matrix<double, kMoves, 1>>(delta)));
    std::copy(block.begin(), block.end(), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kNumbers, kMoves, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.topRows<kMoves>().setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Pose3 to = from_block(y);
    const Pose3 from = from_block(x);
    const Eigen::AngleAxisd turn(to.rotation * from.rotation.conjugate());
    Eigen::Map<Eigen::Matrix<double, kMoves, 1>> moves(y_minus_x);
    moves << turn.angle() * turn.axis(), to.translation - from.translation;
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, kMoves, kNumbers, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.leftCols<kMoves>().setIdentity();
    return true;
  }
};

}  // namespace

PoseBlock to_block(const Pose3& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Vec3& t = pose.translation;
  return {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z()};
}

Pose3 from_block(const double* block) {
  return {Eigen::Quaterniond(block[3], block[0], block[1], block[2]),
          Vec3(block[4], block[5], block[6])};
}

void add_pose(ceres::Problem& problem, PoseBlock& block) {
  problem.AddParameterBlock(block.data(), kNumbers, new PoseMoves);
}

Eigen::Matrix<double, 3, 6> moved_by_pose(const Pose3& T, const Vec3& p) {
  const Vec3 turned = T.rotation * p;
  Eigen::Matrix<double, 3, 6> J;
  J << 0, turned.z(), -turned.y(), 1, 0, 0,  //
      -turned.z(), 0, turned.x(), 0, 1, 0,   //
      turned.y(), -turned.x(), 0, 0, 0, 1;
  return J;
}

Pose3 moved(const Pose3& T, const Eigen::Matrix<double, 6, 1>& by) {
  return {(turned_by(by.head<3>()) * T.rotation).normalized(), T.translation + by.tail<3>()};
}

}  // namespace panoptes
