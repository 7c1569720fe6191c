// SPDX-License-Identifier: BSD-3-Clause
#include "apps/calibrate/rig_figures.h"

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include "core/base/utf8.h"
#include "core/camera/lens_parameters.h"
#include "core/camera/mounting.h"

namespace panoptes {
namespace {

using Json = nlohmann::ordered_json;

Json matrix_json(const Eigen::MatrixXd& m) {
  Json rows;
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    const Eigen::VectorXd row = m.row(i);
    rows.push_back(std::vector<double>(row.data(), row.data() + row.size()));
  }
  return rows;
}

/// e^T C^-1 e by its dimension: 1 on the mean where the covariance is as large as errors are.
double normalised_error(const Pose3& found, const Pose3& truth,
                        const Eigen::Matrix<double, 6, 6>& covariance) {
  const Eigen::AngleAxisd off(found.rotation * truth.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> e;
  e << off.angle() * off.axis(), found.translation - truth.translation;
  return e.dot(covariance.ldlt().solve(e)) / static_cast<double>(e.size());
}

Json lens_json(const Intrinsics& lens, const Eigen::VectorXd& sigma) {
  Json figures;
  const Eigen::VectorXd numbers = lens_parameters(lens);
  const std::vector<std::string> names = lens_parameter_names(lens);
  for (std::size_t i = 0; i < names.size(); ++i) {
    figures[names[i]] = numbers[static_cast<Eigen::Index>(i)];
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    figures["sigma"][names[i]] = sigma[static_cast<Eigen::Index>(i)];
  }
  return figures;
}

}  // namespace

Json pose_figures(const Pose3& T) {
  const Vec3& t = T.translation;
  const Eigen::Quaterniond& q = T.rotation;
  return {{"translation_m", {t.x(), t.y(), t.z()}},
          {"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

void add_errors(const Pose3& found, const Pose3& truth, Json& figures) {
  figures["rotation_error_deg"] = rad_to_deg(found.rotation.angularDistance(truth.rotation));
  figures["translation_error_m"] = (found.translation - truth.translation).norm();
  const double cross = found.translation.cross(truth.translation).norm();
  figures["translation_direction_error_deg"] =
      rad_to_deg(std::atan2(cross, found.translation.dot(truth.translation)));
}

Json rig_figures(const RigCalibration& calibration, const std::optional<Rig>& truth) {
  const RigBundleState& state = calibration.bundle.state;
  const RigCovariance& known = calibration.bundle.known;
  const Eigen::VectorXd sigma = known.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const std::string& reference = calibration.cameras.front();
  const auto true_camera = [&](const std::string& name) -> const RigCamera* {
    return truth && truth->cameras.contains(name) ? &truth->cameras.at(name) : nullptr;
  };
  const RigCamera* true_reference = true_camera(reference);
  Json figures{{"reference", as_utf8(reference)},
               {"scale_source", calibration.bundle.tells_metre ? "odometry" : "rig_file"}};
  Json of_body = pose_figures(state.T_body_camera.front());
  of_body["covariance"] = matrix_json(known.covariance.topLeftCorner<6, 6>());
  of_body["unobservable"] = known.unobservable.front();
  if (true_reference != nullptr) {
    add_errors(state.T_body_camera.front(), true_reference->T_body_camera, of_body);
    const MountingOffset off =
        mounting_offset(true_reference->T_body_camera, state.T_body_camera.front());
    of_body["error"] = {{"roll_deg", rad_to_deg(off.rotation_rad.x())},
                        {"pitch_deg", rad_to_deg(off.rotation_rad.y())},
                        {"yaw_deg", rad_to_deg(off.rotation_rad.z())},
                        {"x_m", off.shift_m.x()},
                        {"y_m", off.shift_m.y()},
                        {"z_m", off.shift_m.z()}};
  }
  figures["T_body_reference"] = of_body;
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    const std::string& name = calibration.cameras[c];
    const Eigen::Index at = known.camera[c];
    const auto lens = static_cast<Eigen::Index>(lens_parameters(state.lenses[c]).size());
    Json camera;
    if (c > 0) {
      const Pose3 T = state.T_body_camera.front().inverse() * state.T_body_camera[c];
      camera["T_reference_camera"] = pose_figures(T);
      camera["covariance"] = matrix_json(known.relative(state, 0, c));
      if (true_reference != nullptr && true_camera(name) != nullptr) {
        const Pose3 truly =
            true_reference->T_body_camera.inverse() * true_camera(name)->T_body_camera;
        add_errors(T, truly, camera);
        camera["normalised_error"] = normalised_error(T, truly, known.relative(state, 0, c));
      }
    }
    camera["T_body_camera"] = pose_figures(state.T_body_camera[c]);
    if (const RigCamera* real = true_camera(name)) {
      add_errors(state.T_body_camera[c], real->T_body_camera, camera["T_body_camera"]);
    }
    camera["unobservable"] = known.unobservable[c];
    camera["intrinsics"] = lens_json(state.lenses[c], sigma.segment(at + 6, lens));
    camera["time_offset_s"] = state.clock_offset_s[c];
    camera["time_offset_sigma_s"] = sigma[at + 6 + lens];
    if (const RigCamera* real = true_camera(name)) {
      camera["time_offset_error_s"] = state.clock_offset_s[c] - real->clock_offset_s;
    }
    camera["shared_points"] = calibration.shared[c];
    camera["observation_sigma_px"] = {{"own", calibration.bundle.sigma_own_px[c]},
                                      {"others", calibration.bundle.sigma_other_px[c]}};
    figures["cameras"][as_utf8(name)] = camera;
  }
  const std::vector<std::string> wheels{"way_ratio", "turn_ratio", "turn_rad_per_m"};
  for (std::size_t i = 0; calibration.bundle.has_wheels && i < wheels.size(); ++i) {
    figures["wheels"][wheels[i]] = state.wheel_errors[static_cast<Eigen::Index>(i)];
    figures["wheels"]["sigma"][wheels[i]] = sigma[known.wheels + static_cast<Eigen::Index>(i)];
  }
  const RigBundle& bundle = calibration.bundle;
  figures["reprojection_rms_px"] = {{"before", bundle.rms_before_px},
                                    {"after", bundle.rms_after_px}};
  figures["slide_rad"] = bundle.slide_rad;
  figures["observations"] = bundle.observations;
  figures["inter_map_matches"] = bundle.observations_other;
  figures["left_out"] = bundle.left_out;
  figures["keyframes"] = calibration.tracks.instants.size();
  figures["points"] = state.points_start.size();
  return figures;
}

}  // namespace panoptes
