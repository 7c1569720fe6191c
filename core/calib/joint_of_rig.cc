// SPDX-License-Identifier: BSD-3-Clause
#include "core/calib/joint_of_rig.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "core/base/check.h"
#include "core/calib/rig_costs.h"
#include "core/camera/lens_parameters.h"

namespace panoptes {
namespace {

constexpr Eigen::Index kLensRow = 6;  // of a camera's rows
constexpr Eigen::Index kCentre = 2;   // of a lens's
constexpr double kLeastDistortion = 1e-6;

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

Eigen::MatrixXd covariance_before(const std::vector<std::string>& cameras,
                                  const std::vector<RigCamera>& believed,
                                  const std::optional<JointCovariance>& joint) {
  // What goes wholly together has no inverse.
  constexpr double kApart = 1e-6;
  std::vector<std::string> names;
  std::vector<double> sigma;
  std::vector<Eigen::Index> fx_row;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Intrinsics& lens = believed[c].intrinsics;
    const std::vector<std::string> of = joint_parameters(cameras[c], lens);
    const Eigen::VectorXd each = sigmas_before(believed[c].sigma, lens_parameters(lens));
    fx_row.push_back(kLensRow + static_cast<Eigen::Index>(names.size()));
    names.insert(names.end(), of.begin(), of.end());
    sigma.insert(sigma.end(), each.begin(), each.end());
  }
  const auto size = static_cast<Eigen::Index>(names.size());
  Eigen::MatrixXd together = Eigen::MatrixXd::Identity(size, size);
  const auto row_of = [&](Eigen::Index i) {
    return std::find(joint->parameters.begin(), joint->parameters.end(),
                     names[static_cast<std::size_t>(i)]) -
           joint->parameters.begin();
  };
  if (joint) {
    together = (1 - kApart) * correlations(*joint, names) + kApart * together;
  }
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Eigen::Index fx = fx_row[c];
    const Eigen::Index end = fx + lens_parameters(believed[c].intrinsics).size();
    if (joint && row_of(fx) < static_cast<Eigen::Index>(joint->parameters.size())) {
      for (Eigen::Index i = fx + kCentre + 2; i < end; ++i) {
        sigma[static_cast<std::size_t>(i)] =
            std::max(std::sqrt(joint->covariance(row_of(i), row_of(i))), kLeastDistortion);
      }
    } else {  // lens_known_cost
      const double apart = std::sqrt(1 + kFocalApart * kFocalApart);
      sigma[static_cast<std::size_t>(fx + 1)] *= apart;
      together(fx, fx + 1) = together(fx + 1, fx) = 1 / apart;
    }
  }
  const Eigen::Map<const Eigen::VectorXd> by(sigma.data(), size);
  return by.asDiagonal() * together * by.asDiagonal();
}

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
