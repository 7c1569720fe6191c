// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/joint_of_rig.h"

#include <Eigen/Eigenvalues>

#include "core/base/check.h"

namespace panoptes {
namespace {

/// The nearest one that is a covariance, each parameter counted in its sigmas: inversions leave
/// roundoff.
Eigen::MatrixXd semi_definite(const Eigen::MatrixXd& told) {
  const Eigen::VectorXd sigma = told.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd by = (sigma.array() > 0).select(sigma.cwiseInverse(), 0);
  const Eigen::MatrixXd scaled =
      by.asDiagonal() * Eigen::MatrixXd(0.5 * (told + told.transpose())) * by.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  const Eigen::MatrixXd sound = solver.eigenvectors() *
                                solver.eigenvalues().cwiseMax(0).asDiagonal() *
                                solver.eigenvectors().transpose();
  const Eigen::MatrixXd all = sigma.asDiagonal() * sound * sigma.asDiagonal();
  return 0.5 * (all + all.transpose());
}

}  // namespace

JointCovariance joint_covariance(const RigCalibration& calibration) {
  const RigCovariance& known = calibration.bundle.known;
  JointCovariance joint;
  std::vector<Eigen::Index> rows;
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    Eigen::Index row = known.camera[c];
    for (const std::string& parameter :
         joint_parameters(calibration.cameras[c], calibration.bundle.state.lenses[c])) {
      joint.parameters.push_back(parameter);
      rows.push_back(row++);
    }
    PANOPTES_CHECK(row <= known.wheels, "a camera's rows are those of its parameters");
  }
  joint.covariance = semi_definite(known.covariance(rows, rows));
  return joint;
}

}  // namespace panoptes
