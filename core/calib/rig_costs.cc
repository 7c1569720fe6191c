// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/rig_costs.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <ceres/sized_cost_function.h>

#include "core/calib/pose_block.h"
#include "core/calib/reprojection_cost.h"
#include "core/camera/lens_parameters.h"
#include "core/geometry/cross_matrix.h"

namespace panoptes {
namespace {

// A point that comes nearer to a camera is on its way through it: no step is to end there.
constexpr double kNearest_m = 0.01;

/// How far forward, by the chord of its arc.
double chord(const Pose2& moved) {
  const double half_rad = moved.theta_rad / 2;
  return std::cos(half_rad) * moved.x_m + std::sin(half_rad) * moved.y_m;
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ByPose = Eigen::Matrix<double, Eigen::Dynamic, 6>;

void set_by_pose(double* jacobian, const ByPose& by_moves) {
  Eigen::Map<RowMajor> J(jacobian, by_moves.rows(), 7);
  J.leftCols<6>() = by_moves;
  J.col(6).setZero();
}

/// How T * p moves with the six (pose_block.h), of a point in homogeneous coordinates.
Eigen::Matrix<double, 3, 6> moved_by_pose(const Pose3& T, const Vec3& p, double w) {
  Eigen::Matrix<double, 3, 6> J = moved_by_pose(T, p);
  J.rightCols<3>() *= w;
  return J;
}

class RigReprojectionCost : public ceres::CostFunction {
 public:
  RigReprojectionCost(const Intrinsics& lens, const Vec2& seen_px, double sigma_px,
                      const BodyMoved& moved, const BySlides& by_slides)
      : lens_(lens), seen_px_(seen_px), sigma_px_(sigma_px), moved_(moved), by_slides_(by_slides) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {
        static_cast<int>(lens_parameters(lens).size()), 7, 7, 1, kWheelErrors,
        4 + static_cast<int>(by_slides.cols())};
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Eigen::Index count = parameter_block_sizes()[0];
    const Intrinsics lens =
        with_parameters(lens_, Eigen::Map<const Eigen::VectorXd>(blocks[0], count));
    const Pose3 T_camera_body = from_block(blocks[1]);
    const Pose3 T_body_start = from_block(blocks[2]);
    const Vec3 errors = Eigen::Map<const Vec3>(blocks[4]);
    Eigen::Vector4d p_start = Eigen::Map<const Eigen::Vector4d>(blocks[5]);
    const double w = p_start[3];
    const Pose2 by_wheels = moved_.with_offset(blocks[3][0]);
    const Pose2 T_instant_taken = truly_moved(by_wheels, errors);
    const Pose3 T_taken_instant = on_floor(T_instant_taken).inverse();
    const auto taken = [&] {
      return Vec3(seen_from(T_taken_instant, seen_from(T_body_start, p_start)).head<3>());
    };
    const Mat3 R_camera_start =
        (T_camera_body.rotation * T_taken_instant.rotation * T_body_start.rotation)
            .toRotationMatrix();
    // By shares of the distance: in metres, or of a distance from elsewhere, slides would tell a
    // metre or a height, of which nothing is seen.
    double far = 0;
    Mat3 by_distance = Mat3::Identity();
    if (by_slides_.cols() > 0) {
      const Vec3 here = T_camera_body.rotation * taken() + w * T_camera_body.translation;
      const Vec3 slid_start =
          by_slides_ * Eigen::Map<const Eigen::VectorXd>(blocks[5] + 4, by_slides_.cols());
      far = here.norm();
      p_start.head<3>() += far * slid_start;
      by_distance += R_camera_start * slid_start * here.transpose() / far;
    }
    const Vec3 p_taken = taken();
    const Vec3 p = T_camera_body.rotation * p_taken + w * T_camera_body.translation;
    if (!can_draw(lens, p) || p.norm() < kNearest_m * std::abs(w)) {
      return false;
    }
    const Projection drawn = project_with_jacobian(lens, p);
    Eigen::Map<Vec2> r(residuals);
    r = (drawn.px - seen_px_) / sigma_px_;
    if (jacobians == nullptr) {
      return true;
    }
    const Eigen::Matrix<double, 2, 3> by_shift = drawn.px_by_point / sigma_px_;
    const Eigen::Matrix<double, 2, 3> by_p = by_shift * by_distance;
    const Eigen::Matrix<double, 2, 3> by_taken = by_p * T_camera_body.rotation.toRotationMatrix();
    const Eigen::Matrix<double, 2, 3> by_body =
        by_taken * T_taken_instant.rotation.toRotationMatrix();
    if (jacobians[0] != nullptr) {
      Eigen::Map<RowMajor>(jacobians[0], 2, count) = drawn.px_by_lens / sigma_px_;
    }
    if (jacobians[1] != nullptr) {
      set_by_pose(jacobians[1], by_p * moved_by_pose(T_camera_body, p_taken, w));
    }
    if (jacobians[2] != nullptr) {
      set_by_pose(jacobians[2], by_body * moved_by_pose(T_body_start, p_start.head<3>(), w));
    }
    if (jacobians[3] != nullptr) {
      // By a later clock the body was less far on its way.
      const double v_mps = (1 + errors[kWayError]) * moved_.twist_body.v_mps;
      const double w_radps = (1 + errors[kTurnError]) * moved_.twist_body.w_radps +
                             errors[kTurnPerMetre] * moved_.twist_body.v_mps;
      const Vec3 by_offset(w * v_mps - w_radps * p_taken.y(), w_radps * p_taken.x(), 0);
      Eigen::Map<Vec2> J(jacobians[3]);
      J = by_taken * by_offset;
    }
    if (jacobians[4] != nullptr) {
      // In the body's axes at the picture: the longer the way, the nearer is what lies ahead.
      const Vec2 way_taken = -w * T_instant_taken.inverse().position();
      Eigen::Matrix<double, 3, kWheelErrors> taken_by_errors =
          Eigen::Matrix<double, 3, kWheelErrors>::Zero();
      taken_by_errors.col(kWayError).head<2>() = -way_taken / (1 + errors[kWayError]);
      const Vec2 by_turn(p_taken.y() + way_taken.y() / 2, -p_taken.x() - way_taken.x() / 2);
      taken_by_errors.col(kTurnError).head<2>() = by_wheels.theta_rad * by_turn;
      taken_by_errors.col(kTurnPerMetre).head<2>() = chord(by_wheels) * by_turn;
      Eigen::Map<Eigen::Matrix<double, 2, kWheelErrors, Eigen::RowMajor>> J(jacobians[4]);
      J = by_taken * taken_by_errors;
    }
    if (jacobians[5] != nullptr) {
      Eigen::Map<RowMajor> J(jacobians[5], 2, parameter_block_sizes()[5]);
      const Eigen::Matrix<double, 2, 3> by_start =
          by_body * T_body_start.rotation.toRotationMatrix();
      J.leftCols<3>() = by_start;
      J.col(3) = by_p * (T_camera_body * (T_taken_instant * T_body_start.translation));
      J.rightCols(by_slides_.cols()) = far * by_shift * R_camera_start * by_slides_;
    }
    return true;
  }

 private:
  Intrinsics lens_;
  Vec2 seen_px_;
  double sigma_px_;
  BodyMoved moved_;
  BySlides by_slides_;
};

class WheelsCost : public ceres::SizedCostFunction<3, 7, 7, kWheelErrors> {
 public:
  WheelsCost(const Pose2& T_before_now, const WheelSigma& sigma)
      : way_(T_before_now.position()),
        chord_m_(chord(T_before_now)),
        turn_rad_(T_before_now.theta_rad) {
    weight_.setZero();
    weight_.topLeftCorner<2, 2>() = Vec2(1 / sigma.along_m, 1 / sigma.across_m).asDiagonal() *
                                    Eigen::Rotation2Dd(-turn_rad_ / 2).toRotationMatrix();
    weight_(2, 2) = 1 / sigma.turn_rad;
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose3 before = from_block(blocks[0]);
    const Pose3 now = from_block(blocks[1]);
    const double* error = blocks[2];
    const Mat3 R =
        (before.rotation * now.rotation.conjugate()).toRotationMatrix();  // before from now
    const Vec3 shift = before.translation - R * now.translation;
    const double turn_rad = std::atan2(R(1, 0), R(0, 0));
    // The chord of an arc turns by half of what the arc truly does, whatever the wheels say of it.
    const double more_rad = std::remainder(turn_rad - turn_rad_, 2 * std::numbers::pi);
    const Vec2 turned = Eigen::Rotation2Dd(more_rad / 2) * way_;
    const double per_metre = 1 / (1 + error[kWayError]);
    Eigen::Map<Vec3> r(residuals);
    r << per_metre * shift.head<2>() - turned,
        more_rad - error[kTurnError] * turn_rad_ - error[kTurnPerMetre] * chord_m_;
    r = (weight_ * r).eval();
    if (jacobians == nullptr) {
      return true;
    }
    const Vec2 by_turn(turned.y() / 2, -turned.x() / 2);
    if (jacobians[0] != nullptr) {
      Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
      J.topLeftCorner<2, 3>() = per_metre * cross_matrix(R * now.translation).topRows<2>();
      J.topRightCorner<2, 3>().leftCols<2>().diagonal().setConstant(per_metre);
      J(2, 2) = 1;
      J.topRows<2>() += by_turn * J.row(2);
      set_by_pose(jacobians[0], weight_ * J);
    }
    if (jacobians[1] != nullptr) {
      Eigen::Matrix<double, 3, 6> J;
      J.topLeftCorner<2, 3>() = -per_metre * (R * cross_matrix(now.translation)).topRows<2>();
      J.topRightCorner<2, 3>() = -per_metre * R.topRows<2>();
      J.row(2) << -R.row(2), 0, 0, 0;
      J.topRows<2>() += by_turn * J.row(2);
      set_by_pose(jacobians[1], weight_ * J);
    }
    if (jacobians[2] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, kWheelErrors, Eigen::RowMajor>> J(jacobians[2]);
      J.col(kWayError) << -per_metre * per_metre * shift.head<2>(), 0;
      J.col(kTurnError) << 0, 0, -turn_rad_;
      J.col(kTurnPerMetre) << 0, 0, -chord_m_;
      J = (weight_ * J).eval();
    }
    return true;
  }

 private:
  Vec2 way_;
  double chord_m_;  // forward
  double turn_rad_;
  Mat3 weight_;
};

class StartCost : public ceres::SizedCostFunction<3, 7> {
 public:
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    constexpr double kHeld = 1e4;  // per m and rad: by far more than anything else tells
    const Pose3 T = from_block(blocks[0]);
    const Mat3 R = T.rotation.toRotationMatrix();
    Eigen::Map<Vec3> r(residuals);
    r = kHeld * Vec3(T.translation.x(), T.translation.y(), std::atan2(R(1, 0), R(0, 0)));
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
      J(0, 3) = J(1, 4) = J(2, 2) = kHeld;
      set_by_pose(jacobians[0], J);
    }
    return true;
  }
};

class LevelCost : public ceres::SizedCostFunction<3, 7, kWheelErrors> {
 public:
  LevelCost(double sigma_m, double sigma_rad)
      : weight_(1 / sigma_rad, 1 / sigma_rad, 1 / sigma_m) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose3 T_body_start = from_block(blocks[0]);
    const Vec3 up = T_body_start.rotation * Vec3::UnitZ();
    const Vec3& t = T_body_start.translation;
    Eigen::Map<Vec3> r(residuals);
    const double per_metre = 1 / (1 + blocks[1][kWayError]);
    r = weight_.cwiseProduct(Vec3(up.x(), up.y(), per_metre * up.dot(t)));
    if (jacobians == nullptr) {
      return true;
    }
    if (jacobians[0] != nullptr) {
      Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
      J.topLeftCorner<2, 3>() = -cross_matrix(up).topRows<2>();
      J.row(2) << per_metre * up.cross(t).transpose(), per_metre * up.transpose();
      set_by_pose(jacobians[0], weight_.asDiagonal() * J);
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, kWheelErrors, Eigen::RowMajor>> J(jacobians[1]);
      J.setZero();
      J(2, kWayError) = -weight_[2] * per_metre * per_metre * up.dot(t);
    }
    return true;
  }

 private:
  Vec3 weight_;
};

class AwayCost : public ceres::SizedCostFunction<1, 7> {
 public:
  AwayCost(Vec3 p_body, double away_m, double sigma_m)
      : p_body_(std::move(p_body)), away_m_(away_m), sigma_m_(sigma_m) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose3 T_body_start = from_block(blocks[0]);
    const Vec3 from_start_body = p_body_ - T_body_start.translation;
    const Mat3 R_start_body = T_body_start.rotation.conjugate().toRotationMatrix();
    const Vec3 moved = R_start_body * from_start_body - p_body_;
    residuals[0] = (moved.norm() - away_m_) / sigma_m_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      set_by_pose(jacobians[0], -moved.normalized().transpose() * R_start_body *
                                    moved_by_pose(Pose3(), from_start_body) / sigma_m_);
    }
    return true;
  }

 private:
  Vec3 p_body_;
  double away_m_;
  double sigma_m_;
};

/// Numbers of some blocks, one after another.
class KnownCost : public ceres::CostFunction {
 public:
  KnownCost(std::vector<Eigen::VectorXd> values, RowMajor weight)
      : values_(std::move(values)), weight_(std::move(weight)) {
    set_num_residuals(static_cast<int>(weight_.rows()));
    for (const Eigen::VectorXd& value : values_) {
      mutable_parameter_block_sizes()->push_back(static_cast<int>(value.size()));
    }
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Eigen::VectorXd off(weight_.cols());
    Eigen::Index at = 0;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const Eigen::Index count = values_[i].size();
      off.segment(at, count) = Eigen::Map<const Eigen::VectorXd>(blocks[i], count) - values_[i];
      if (jacobians != nullptr && jacobians[i] != nullptr) {
        Eigen::Map<RowMajor>(jacobians[i], weight_.rows(), count) = weight_.middleCols(at, count);
      }
      at += count;
    }
    Eigen::Map<Eigen::VectorXd>(residuals, weight_.rows()) = weight_ * off;
    return true;
  }

 private:
  std::vector<Eigen::VectorXd> values_;
  RowMajor weight_;
};

class MountingKnownCost : public ceres::SizedCostFunction<6, 7> {
 public:
  MountingKnownCost(const Pose3& T_body_camera, double sigma_rad, const Vec3& sigma_m)
      : T_body_camera_(T_body_camera) {
    weight_ << Vec3::Constant(1 / sigma_rad), sigma_m.cwiseInverse();
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Pose3 T = from_block(blocks[0]);
    const Eigen::AngleAxisd off(T.rotation * T_body_camera_.rotation);
    const Vec3 position_body = -(T.rotation.conjugate() * T.translation);
    Eigen::Map<Eigen::Matrix<double, 6, 1>> r(residuals);
    r << off.angle() * off.axis(), position_body - T_body_camera_.translation;
    r = r.cwiseProduct(weight_);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      // -R^T t moves by R^T (w x t - s) for a small turn w and a shift s.
      const Mat3 R_body_camera = T.rotation.conjugate().toRotationMatrix();
      Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
      J.topLeftCorner<3, 3>().setIdentity();
      J.bottomLeftCorner<3, 3>() = -R_body_camera * cross_matrix(T.translation);
      J.bottomRightCorner<3, 3>() = -R_body_camera;
      set_by_pose(jacobians[0], weight_.asDiagonal() * J);
    }
    return true;
  }

 private:
  Pose3 T_body_camera_;
  Eigen::Matrix<double, 6, 1> weight_;
};

class MountingsKeptCost : public ceres::CostFunction {
 public:
  MountingsKeptCost(std::vector<Pose3> T_body_camera, RowMajor directions)
      : T_body_camera_(std::move(T_body_camera)), directions_(std::move(directions)) {
    set_num_residuals(static_cast<int>(directions_.rows()));
    mutable_parameter_block_sizes()->assign(T_body_camera_.size(), 7);
  }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, directions_.rows());
    r.setZero();
    for (std::size_t c = 0; c < T_body_camera_.size(); ++c) {
      const Pose3 T_body_camera = from_block(blocks[c]).inverse();
      const auto along = directions_.middleCols<6>(6 * static_cast<Eigen::Index>(c));
      r += along * mounting_moved(T_body_camera_[c], T_body_camera);
      if (jacobians != nullptr && jacobians[c] != nullptr) {
        Eigen::Map<RowMajor> J(jacobians[c], directions_.rows(), 7);
        J.leftCols<6>() = along * mounting_by_moves(T_body_camera);
        J.col(6).setZero();
      }
    }
    return true;
  }

 private:
  std::vector<Pose3> T_body_camera_;
  RowMajor directions_;
};

}  // namespace

Eigen::Vector4d seen_from(const Pose3& T, const Eigen::Vector4d& p) {
  Eigen::Vector4d out = p;
  out.head<3>() = T.rotation * p.head<3>() + p[3] * T.translation;
  return out;
}

Eigen::Matrix<double, 6, 1> mounting_moved(const Pose3& from_T_body_camera,
                                           const Pose3& to_T_body_camera) {
  const Eigen::AngleAxisd turn(to_T_body_camera.rotation * from_T_body_camera.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> moved;
  moved << turn.angle() * turn.axis(),
      to_T_body_camera.translation - from_T_body_camera.translation;
  return moved;
}

Eigen::Matrix<double, 6, 6> mounting_by_moves(const Pose3& T_body_camera) {
  const Mat3 R = T_body_camera.rotation.toRotationMatrix();
  const Vec3 t = -(R.transpose() * T_body_camera.translation);  // of T_camera_body
  Eigen::Matrix<double, 6, 6> G = Eigen::Matrix<double, 6, 6>::Zero();
  G.topLeftCorner<3, 3>() = -R;
  G.bottomLeftCorner<3, 3>() = -R * cross_matrix(t);
  G.bottomRightCorner<3, 3>() = -R;
  return G;
}

Pose2 truly_moved(const Pose2& by_wheels, const Vec3& wheel_errors) {
  const double more_rad = wheel_errors[kTurnError] * by_wheels.theta_rad +
                          wheel_errors[kTurnPerMetre] * chord(by_wheels);
  const Vec2 way =
      (1 + wheel_errors[kWayError]) * (Eigen::Rotation2Dd(more_rad / 2) * by_wheels.position());
  return {way.x(), way.y(), by_wheels.theta_rad + more_rad};
}

Pose2 BodyMoved::with_offset(double offset_s) const {
  return T_instant_taken * exp_twist(twist_body, clock_offset_s - offset_s);
}

ceres::CostFunction* rig_reprojection_cost(const Intrinsics& lens, const Vec2& seen_px,
                                           double sigma_px, const BodyMoved& moved,
                                           const BySlides& by_slides) {
  return new RigReprojectionCost(lens, seen_px, sigma_px, moved, by_slides);
}

ceres::CostFunction* slides_cost(int first, double sigma_rad) {
  RowMajor weight = RowMajor::Zero(2, 4 + kSlides);
  weight.middleCols<2>(4 + first).diagonal().setConstant(1 / sigma_rad);
  return new KnownCost({Eigen::VectorXd(Eigen::VectorXd::Zero(4 + kSlides))}, weight);
}

ceres::CostFunction* wheels_cost(const Pose2& T_before_now, const WheelSigma& sigma) {
  return new WheelsCost(T_before_now, sigma);
}

ceres::CostFunction* start_cost() { return new StartCost; }

ceres::CostFunction* level_cost(double sigma_m, double sigma_rad) {
  return new LevelCost(sigma_m, sigma_rad);
}

ceres::CostFunction* away_cost(const Vec3& p_body, double away_m, double sigma_m) {
  return new AwayCost(p_body, away_m, sigma_m);
}

ceres::CostFunction* known_cost(const Eigen::VectorXd& value, const Eigen::VectorXd& sigma) {
  return new KnownCost({value}, sigma.cwiseInverse().asDiagonal().toDenseMatrix());
}

Eigen::VectorXd sigmas_before(const CameraSigmas& known, const Eigen::VectorXd& lens) {
  Eigen::VectorXd sigma = Eigen::VectorXd::Constant(6 + lens.size() + 1, known.focal_ratio);
  sigma.head<3>() = known.rotation_rad;
  sigma.segment<3>(3) = known.position_m;
  sigma.segment<2>(6) *= lens[0];
  sigma.segment<2>(8).setConstant(known.centre_px);
  sigma[sigma.size() - 1] = known.clock_s;
  return sigma;
}

ceres::CostFunction* lens_known_cost(const Intrinsics& lens, const CameraSigmas& known) {
  const Eigen::VectorXd before = lens_parameters(lens);
  RowMajor weight = RowMajor::Zero(before.size(), before.size());
  weight.diagonal().setConstant(1 / known.focal_ratio);
  weight.diagonal().head<2>() << 1 / (known.focal_ratio * lens.fx_px),
      -1 / (kFocalApart * known.focal_ratio * lens.fx_px);
  weight(1, 0) = -weight(1, 1);
  weight.diagonal().segment<2>(2).setConstant(1 / known.centre_px);
  return new KnownCost({before}, weight);
}

ceres::CostFunction* mounting_known_cost(const Pose3& T_body_camera, double sigma_rad,
                                         const Vec3& sigma_m) {
  return new MountingKnownCost(T_body_camera, sigma_rad, sigma_m);
}

ceres::CostFunction* mountings_kept_cost(const std::vector<Pose3>& T_body_camera,
                                         const Eigen::MatrixXd& directions) {
  return new MountingsKeptCost(T_body_camera, directions);
}

ceres::CostFunction* known_together_cost(const std::vector<Eigen::VectorXd>& values,
                                         const Eigen::MatrixXd& weight) {
  return new KnownCost(values, weight);
}

}  // namespace panoptes
